// SPDX-License-Identifier: Apache-2.0
// The way to one client: what is to be sent, and the writers of its partition that hold what was. A
// client that is slow, stopped or gone holds up nobody: writing does not wait for it.
#pragma once

#include "dds/answer_writer.hpp"

#include <deque>
#include <memory>
#include <string>
#include <vector>

namespace handover {

/// Public methods are safe from any thread; send() from one at a time, by what push() says.
class ClientStream {
 public:
  using Clock = AnswerWriter::Clock;

  /// Answers that their client did not confirm stay readable for `retention`.
  ClientStream(const wire::Participant& participant, std::string client_id,
               std::chrono::milliseconds retention);

  /// Makes a writer, ahead of the first answer.
  void prepare();

  /// Queues an event. True: nothing was queued, so that send() is to be called, until it says that
  /// no more waits.
  bool push(PlanEvent event);

  struct Sent {
    bool more = false;              ///< waits to be sent
    std::vector<RequestId> broken;  ///< could not go on: their answers ended as failed
  };

  /// Writes some of what is queued. @throws wire::DdsError.
  Sent send();

  /// The client has the outcome of a request.
  void confirm(const RequestId& id);

  /// Takes back what waits of an answer, and with it the writer that has begun it, where that holds
  /// nothing else that is needed. Not on Fast DDS's threads.
  void giveUp(const RequestId& id);

  /// True when nothing waits and every answer has ended.
  bool idle() const;
  /// True when, besides, the client has confirmed all of them or they are too old.
  bool spent() const;
  /// True when what was pushed has arrived.
  bool delivered() const;
  /// Of the answers held.
  std::size_t bytes() const;
  /// When it was made or last pushed to.
  Clock::time_point lastUsed() const;

 private:
  using WriterPtr = std::shared_ptr<AnswerWriter>;

  std::vector<WriterPtr> writers() const;
  WriterPtr addWriter();
  /// The one that the event belongs to, made if need be; null: its answer was given up.
  WriterPtr writerOf(const PlanEvent& event);
  /// Ends what a writer has begun, in a new one.
  std::vector<RequestId> replace(const WriterPtr& broken);
  /// Gives up writers that are not needed any more; the newest stays for the next answer.
  void tidy();

  const wire::Participant& participant_;
  const std::string client_id_;
  const std::chrono::milliseconds retention_;

  mutable Mutex mutex_;
  std::deque<PlanEvent> backlog_ HANDOVER_GUARDED_BY(mutex_);
  /// From the first event of the backlog until send() said that no more waits.
  bool sending_ HANDOVER_GUARDED_BY(mutex_) = false;
  /// The newest last: it takes the next answer unless it is full.
  std::vector<WriterPtr> writers_ HANDOVER_GUARDED_BY(mutex_);
  Clock::time_point last_used_ HANDOVER_GUARDED_BY(mutex_) = Clock::now();
};

}  // namespace handover
