// SPDX-License-Identifier: Apache-2.0
// An events writer and the answers that it holds for late readers.
#pragma once

#include "wire/entities.hpp"

#include <handover/common/mutex.hpp>
#include <handover/common/plan_event.hpp>

#include <chrono>
#include <cstddef>
#include <map>
#include <optional>
#include <vector>

namespace handover {

/// Takes answers until it is full and is given up whole when none of them is needed any more:
/// unregistering an instance of a living writer can spin the receive thread of Fast DDS 2.9.1.
/// Methods are safe from any thread; write() from one at a time.
class AnswerWriter {
 public:
  using Clock = std::chrono::steady_clock;

  /// Writes in the client's partition. @throws wire::DdsError.
  AnswerWriter(const wire::Participant& participant, const std::string& client_id);

  /// True when it should take no further answer.
  bool full() const;
  /// True when it has begun an answer to that request and not ended it.
  bool answering(const RequestId& id) const;
  std::vector<RequestId> unfinished() const;
  /// Writes an event; its first one begins an answer. False when it could not, within 20 ms.
  bool write(const PlanEvent& event);
  /// The client has the outcome of a request.
  void confirm(const RequestId& id);
  /// An answer that it has begun is not gone on with: nobody needs it.
  void giveUp(const RequestId& id);
  /// True when no answer is needed any more: each has ended and is confirmed, or ended before then.
  bool spent(Clock::time_point before) const;
  /// True when the client, or every reader there is, has everything.
  bool delivered();
  /// Of the events held.
  std::size_t bytes() const;

 private:
  struct Answer {
    std::optional<Clock::time_point> ended_at;
    bool confirmed = false;
  };

  wire::Writer<msg::PlanEvent> writer_;
  mutable Mutex mutex_;
  std::map<RequestId, Answer> answers_ HANDOVER_GUARDED_BY(mutex_);
  std::size_t bytes_ HANDOVER_GUARDED_BY(mutex_) = 0;
};

}  // namespace handover
