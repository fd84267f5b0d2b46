// SPDX-License-Identifier: Apache-2.0
// The way to one client: a bounded queue, a thread and an events writer in the client's partition,
// so that a slow or dead client holds up nobody else.
#pragma once

#include "wire/entities.hpp"

#include <handover/common/mutex.hpp>
#include <handover/common/plan_event.hpp>

#include <chrono>
#include <deque>
#include <functional>
#include <string>
#include <thread>
#include <vector>

namespace handover {

/// Public methods are safe from any thread and do not wait for the client, flush() apart.
class ClientStream {
 public:
  struct Settings {
    std::chrono::milliseconds retention;
    std::size_t max_backlog;
  };

  /// `on_drop` is called, once and from the stream's thread, when the client does not keep up.
  ClientStream(const wire::Participant& participant, std::string client_id, Settings settings,
               std::function<void()> on_drop);
  /// Joins; what is still queued is not sent.
  ~ClientStream();
  ClientStream(const ClientStream&) = delete;
  ClientStream& operator=(const ClientStream&) = delete;

  void publish(const PlanEvent& event);
  /// True when nothing was published for the retention time and all instances are gone.
  bool idle() const;
  /// Waits until the client has what was published before, or the time is over.
  void flush(std::chrono::steady_clock::time_point until);

 private:
  using Clock = std::chrono::steady_clock;

  struct Answered {
    RequestId id;
    Clock::time_point at;
  };

  void loop() noexcept;
  void run();
  bool send(wire::Writer<msg::PlanEvent>& writer, const PlanEvent& event);
  void forget(wire::Writer<msg::PlanEvent>& writer, Clock::time_point now);

  const wire::Participant& participant_;
  const std::string client_id_;
  const Settings settings_;
  const std::function<void()> on_drop_;
  std::deque<Answered> answered_;  // of the thread alone: disposed, not yet unregistered

  mutable Mutex mutex_;
  Condition changed_;
  std::deque<PlanEvent> backlog_ HANDOVER_GUARDED_BY(mutex_);
  bool stopping_ HANDOVER_GUARDED_BY(mutex_) = false;
  bool dropped_ HANDOVER_GUARDED_BY(mutex_) = false;
  /// Until the client has acknowledged everything.
  bool flush_wanted_ HANDOVER_GUARDED_BY(mutex_) = false;
  std::size_t instances_ HANDOVER_GUARDED_BY(mutex_) = 0;
  Clock::time_point last_used_ HANDOVER_GUARDED_BY(mutex_) = Clock::now();

  std::jthread thread_;
};

}  // namespace handover
