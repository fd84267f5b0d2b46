// SPDX-License-Identifier: Apache-2.0
// Stops the datagrams that end or spin Fast DDS 2.9.1 before it sees them. Whoever may send to a
// port of ours could send one; none of these rules needs to know who did.
#pragma once

#include <handover/common/mutex.hpp>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>

namespace eprosima::fastdds::rtps {
struct TransportDescriptorInterface;
}

namespace handover::wire {

/// Why a datagram is dropped.
enum class PacketFault {
  kLength,      ///< a submessage that ends beyond the datagram, or lacks what its kind has
  kStatistics,  ///< eProsima's statistics before the end of the datagram: an assertion
  kSequence,    ///< a sample's number beyond all that are counted: its successor is an assertion
  kGap,         ///< a gap that begins before 1, or is too long: it would be walked one by one
  kHeartbeat,   ///< a first sample before 1 (an assertion), or too far on: walked one by one
  kData,        ///< inline QoS that end beyond the submessage: the payload's length underflows
  kFragment,    ///< fragments too small, too many or of none: written or read beyond the sample
};

/// The first fault of an RTPS datagram by itself; none: it may pass. What is not RTPS passes, the
/// library passes over it; encrypted submessages pass as they are.
std::optional<PacketFault> packetFault(std::span<const std::uint8_t> datagram);

/// Holds a datagram also against what its writers said before: a heartbeat's first sample may not
/// be far beyond the last first one. Methods are safe from any thread.
class PacketGuard {
 public:
  using Clock = std::chrono::steady_clock;

  std::optional<PacketFault> fault(std::span<const std::uint8_t> datagram,
                                   Clock::time_point now = Clock::now());

  /// Of writers that were heard.
  std::size_t size() const;

 private:
  using Guid = std::array<std::uint8_t, 16>;

  /// A writer's highest first sample that passed.
  struct Heard {
    std::int64_t first = 0;
    Clock::time_point at;
  };

  mutable Mutex mutex_;
  std::map<Guid, Heard> writers_ HANDOVER_GUARDED_BY(mutex_);
};

/// What a guarded transport sees of its work. Safe from any thread.
class GuardWatch {
 public:
  using Clock = std::chrono::steady_clock;

  std::atomic<std::uint64_t> dropped{0};

  /// Hands a datagram over by `call`, on the thread that received it.
  template <typename Call>
  void watch(Call call) {
    const std::uint64_t number = begin();
    call();
    end(number);
  }

  /// How long the library has been at the datagram that it has been at longest; 0: at none. Longer
  /// than it could take: the thread hangs (2.9.1 can, when a participant leaves), and whoever is
  /// new is not heard.
  Clock::duration atOne(Clock::time_point now = Clock::now()) const;

 private:
  std::uint64_t begin();
  void end(std::uint64_t number);

  mutable Mutex mutex_;
  std::uint64_t numbers_ HANDOVER_GUARDED_BY(mutex_) = 0;
  std::map<std::uint64_t, Clock::time_point> begun_ HANDOVER_GUARDED_BY(mutex_);
};

/// The transport of `below` behind a guard that drops datagrams with a fault and sees
/// to the leases of participants (ParticipantLeases).
std::shared_ptr<eprosima::fastdds::rtps::TransportDescriptorInterface> guarded(
    std::shared_ptr<eprosima::fastdds::rtps::TransportDescriptorInterface> below,
    std::shared_ptr<GuardWatch> watch);

}  // namespace handover::wire
