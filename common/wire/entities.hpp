// SPDX-License-Identifier: Apache-2.0
// DDS entities as scoped objects. QoS is set here, in code, and nowhere else: UDP on loopback, no
// multicast, no shared memory, and XML profiles are ignored.
//
// Callbacks run on Fast DDS's threads: they hand over and return, and never create or delete
// entities. An exception that leaves one is logged and swallowed.
#pragma once

#include <handover.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

namespace handover::wire {

/// A DDS entity could not be made or used.
class DdsError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Identity of a writer or reader anywhere in the domain.
using Guid = std::array<std::uint8_t, 16>;

/// True when two entities are of one participant.
inline bool sameParticipant(const Guid& a, const Guid& b) {
  return std::equal(a.begin(), a.begin() + 12, b.begin());
}

/// Sends Fast DDS's warnings (or only its errors) to our log, tag "fastdds", repeats left out.
/// Call once, before the first participant.
void routeDdsLog(bool errors_only);

/// Has participants of this process reach each other by their sockets only, as others reach them.
/// Otherwise one hears the other though nobody else can. Before the first participant.
void deliverOverSockets();

/// A remote writer of one of our topics, as discovery reports it.
struct RemoteWriter {
  Guid guid{};
  std::string topic;
  std::string user_data;
};

struct ParticipantOptions {
  int domain = 0;
  std::string name;
  /// Called for each remote writer that is found.
  std::function<void(const RemoteWriter&)> on_writer;
};

/// The name of daemons' participants.
inline constexpr const char* kDaemonParticipant = "handoverd";

/// A participant with the types and topics of handover registered. The entities made from it keep
/// it alive.
class Participant {
 public:
  /// @throws DdsError.
  explicit Participant(ParticipantOptions options);

  Guid guid() const;

  /// How many other participants of that name there are: the first that is heard of them.
  int others(const std::string& name) const;

  /// Datagrams that its guard has dropped (see packet_guard.hpp).
  std::uint64_t droppedPackets() const;

  /// How long one of its receiving threads has been at one datagram (GuardWatch).
  std::chrono::steady_clock::duration atOneDatagram() const;

  struct Impl;

 private:
  friend class WriterCore;
  friend class ReaderCore;
  std::shared_ptr<Impl> impl_;
};

/// A peer was matched with an entity of ours, or lost.
struct Match {
  Guid peer{};
  bool gained = false;
  int current = 0;  ///< peers now
};

struct EntityOptions {
  std::string partition{};  ///< empty: the default one
  std::string user_data{};  ///< travels with discovery (writers)
  /// Of a writer of the leader topic: while stronger ones live, readers hear nothing of it.
  std::uint32_t strength = 0;
  std::function<void(const Match&)> on_match{};
};

enum class WriteResult { kOk, kTimeout, kError };

enum class TopicId { kRequest, kCancel, kEvent, kStatus, kLeader, kProbe };

/// Answers that one events writer can hold; each has at most 4096 events.
inline constexpr int kAnswersPerWriter = 128;

/// A leader that wrote nothing for this long is gone.
inline constexpr std::chrono::milliseconds kLeaderLease{500};

inline constexpr const char* kRequestTopic = "handover/v1/request";

template <typename Message>
struct TopicOf;

template <>
struct TopicOf<msg::HandoverRequest> {
  static constexpr TopicId kId = TopicId::kRequest;
};

template <>
struct TopicOf<msg::HandoverCancel> {
  static constexpr TopicId kId = TopicId::kCancel;
};

template <>
struct TopicOf<msg::PlanEvent> {
  static constexpr TopicId kId = TopicId::kEvent;
};

template <>
struct TopicOf<msg::DaemonStatus> {
  static constexpr TopicId kId = TopicId::kStatus;
};

template <>
struct TopicOf<msg::Leader> {
  static constexpr TopicId kId = TopicId::kLeader;
};

template <>
struct TopicOf<msg::Probe> {
  static constexpr TopicId kId = TopicId::kProbe;
};

/// What Writer<T> is made of; use that.
class WriterCore {
 public:
  WriterCore(const Participant& participant, TopicId topic, EntityOptions options);
  WriterCore(WriterCore&&) noexcept;
  WriterCore& operator=(WriterCore&&) noexcept;
  ~WriterCore();

  WriteResult write(const void* message);
  bool dispose(const void* message);
  bool unregister(const void* message);
  bool waitForAcknowledgments(std::chrono::milliseconds most);
  int matched() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Writes one topic. Methods are safe from any thread.
template <typename Message>
class Writer {
 public:
  /// @throws DdsError.
  Writer(const Participant& participant, EntityOptions options)
      : core_(participant, TopicOf<Message>::kId, std::move(options)) {}

  /// kTimeout: the history stayed full for the blocking time.
  [[nodiscard]] WriteResult write(const Message& message) { return core_.write(&message); }

  /// Ends the instance of the message's key; late joiners still get its samples.
  bool dispose(const Message& message) { return core_.dispose(&message); }

  /// Frees the instance; late joiners get nothing of it. Not disposed before: disposes it too.
  bool unregister(const Message& message) { return core_.unregister(&message); }

  /// True when all matched readers have everything.
  bool waitForAcknowledgments(std::chrono::milliseconds most) {
    return core_.waitForAcknowledgments(most);
  }

  int matched() const { return core_.matched(); }

 private:
  WriterCore core_;
};

/// What a reader got: a message, or word that the key's instance is gone.
template <typename Message>
struct Sample {
  const Message* message = nullptr;    ///< null: the instance was disposed or lost its writers
  std::array<std::uint8_t, 16> key{};  ///< of the instance
  Guid writer{};
  bool writers_lost = false;  ///< no message: its writers are gone, nobody disposed it
};

/// What Reader<T> is made of; use that.
class ReaderCore {
 public:
  struct RawSample {
    const void* message = nullptr;
    std::array<std::uint8_t, 16> key{};
    Guid writer{};
    bool writers_lost = false;
  };

  ReaderCore(const Participant& participant, TopicId topic, EntityOptions options,
             std::shared_ptr<void> scratch, std::function<void(const RawSample&)> on_sample);
  ReaderCore(ReaderCore&&) noexcept;
  ReaderCore& operator=(ReaderCore&&) noexcept;
  ~ReaderCore();

  int matched() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Reads one topic and hands each sample to a callback, on the receiving thread.
template <typename Message>
class Reader {
 public:
  using OnSample = std::function<void(const Sample<Message>&)>;

  /// Callbacks may come before the constructor returns, and none after the destructor did. @throws
  /// DdsError.
  Reader(const Participant& participant, EntityOptions options, OnSample on_sample)
      : core_(participant, TopicOf<Message>::kId, std::move(options), std::make_shared<Message>(),
              [call = std::move(on_sample)](const ReaderCore::RawSample& raw) {
                call({static_cast<const Message*>(raw.message), raw.key, raw.writer,
                      raw.writers_lost});
              }) {}

  int matched() const { return core_.matched(); }

 private:
  ReaderCore core_;
};

}  // namespace handover::wire
