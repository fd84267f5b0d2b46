// SPDX-License-Identifier: Apache-2.0
#include "dds/client_stream.hpp"

#include <handover/common/log.hpp>

#include <algorithm>
#include <iterator>
#include <utility>

namespace handover {
namespace {

/// Events that a sender writes before others have their turn.
constexpr std::size_t kTurn = 32;
/// Of ended answers that nobody confirmed: beyond it the oldest are given up before their time.
constexpr std::size_t kMostBytes = 32 << 20;

PlanEvent givenUp(const RequestId& id) {
  Failed failed{FailureReason::kInternal, {}};
  failed.explanation.filter = "wire";
  failed.explanation.text = "The answer could not be sent whole: it has too many events.";
  return {id, RequestId::random().bytes, 0, 0, Outcome{failed}};
}

}  // namespace

ClientStream::ClientStream(const wire::Participant& participant, std::string client_id,
                           std::chrono::milliseconds retention)
    : participant_(participant), client_id_(std::move(client_id)), retention_(retention) {}

std::vector<ClientStream::WriterPtr> ClientStream::writers() const {
  const MutexLock lock(mutex_);
  return writers_;
}

ClientStream::WriterPtr ClientStream::addWriter() {
  auto made = std::make_shared<AnswerWriter>(participant_, client_id_);
  const MutexLock lock(mutex_);
  return writers_.emplace_back(std::move(made));
}

void ClientStream::prepare() {
  if (writers().empty()) addWriter();
}

bool ClientStream::push(PlanEvent event) {
  const MutexLock lock(mutex_);
  last_used_ = Clock::now();
  backlog_.push_back(std::move(event));
  return !std::exchange(sending_, true);
}

ClientStream::WriterPtr ClientStream::writerOf(const PlanEvent& event) {
  const auto all = writers();
  if (event.sequence == 0) return all.empty() || all.back()->full() ? addWriter() : all.back();
  const auto found = std::find_if(all.begin(), all.end(), [&](const WriterPtr& each) {
    return each->answering(event.request_id);
  });
  return found == all.end() ? nullptr : *found;
}

ClientStream::Sent ClientStream::send() {
  Sent sent;
  for (std::size_t turn = 0; turn < kTurn; ++turn) {
    PlanEvent event;
    {
      const MutexLock lock(mutex_);
      if (backlog_.empty()) break;
      event = std::move(backlog_.front());
      backlog_.pop_front();
    }
    const WriterPtr writer = writerOf(event);
    if (writer == nullptr || writer->write(event)) continue;
    const auto broken = replace(writer);
    sent.broken.insert(sent.broken.end(), broken.begin(), broken.end());
  }
  tidy();
  const MutexLock lock(mutex_);
  sent.more = sending_ = !backlog_.empty();
  return sent;
}

std::vector<RequestId> ClientStream::replace(const WriterPtr& broken) {
  logger("dds")->warn("client {}: an answer that cannot be sent whole ends as failed", client_id_);
  {
    const MutexLock lock(mutex_);
    std::erase(writers_, broken);
  }
  std::vector<RequestId> ids = broken->unfinished();
  const WriterPtr next = addWriter();
  for (const RequestId& id : ids) (void)next->write(givenUp(id));
  return ids;
}

void ClientStream::tidy() {
  std::size_t held = bytes();
  std::vector<WriterPtr> over;  // ends without the lock
  const MutexLock lock(mutex_);
  for (auto it = writers_.begin(); it != writers_.end() && std::next(it) != writers_.end();) {
    const bool too_much = held > kMostBytes && (*it)->unfinished().empty();
    if (too_much || (*it)->spent(Clock::now() - retention_)) {
      held -= (*it)->bytes();
      over.push_back(std::move(*it));
      it = writers_.erase(it);
    } else {
      ++it;
    }
  }
}

void ClientStream::confirm(const RequestId& id) {
  for (const WriterPtr& writer : writers()) writer->confirm(id);
}

void ClientStream::giveUp(const RequestId& id) {
  std::vector<WriterPtr> over;  // ends without the lock
  const MutexLock lock(mutex_);
  std::erase_if(backlog_, [&](const PlanEvent& event) { return event.request_id == id; });
  std::erase_if(writers_, [&](const WriterPtr& writer) {
    if (!writer->answering(id)) return false;
    writer->giveUp(id);
    const bool spent = writer->spent(Clock::now() - retention_);
    if (spent) over.push_back(writer);
    return spent;
  });
}

bool ClientStream::idle() const {
  const MutexLock lock(mutex_);
  return !sending_ && std::all_of(writers_.begin(), writers_.end(), [](const WriterPtr& writer) {
    return writer->unfinished().empty();
  });
}

bool ClientStream::spent() const {
  const MutexLock lock(mutex_);
  return !sending_ && std::all_of(writers_.begin(), writers_.end(), [&](const WriterPtr& writer) {
    return writer->spent(Clock::now() - retention_);
  });
}

bool ClientStream::delivered() const {
  {
    const MutexLock lock(mutex_);
    if (sending_) return false;
  }
  const auto all = writers();
  return std::all_of(all.begin(), all.end(),
                     [](const WriterPtr& writer) { return writer->delivered(); });
}

std::size_t ClientStream::bytes() const {
  std::size_t sum = 0;
  for (const WriterPtr& writer : writers()) sum += writer->bytes();
  return sum;
}

ClientStream::Clock::time_point ClientStream::lastUsed() const {
  const MutexLock lock(mutex_);
  return last_used_;
}

}  // namespace handover
