// SPDX-License-Identifier: Apache-2.0
#include "dds/answer_writer.hpp"

#include "wire/codec.hpp"

#include <algorithm>

namespace handover {
namespace {

/// What a writer holds at most when it begins another answer: a plan of two holders takes 0.1 to
/// 0.5 MB, a rejection 1 KB.
constexpr std::size_t kFullBytes = 8 << 20;

msg::PlanEvent keyOnly(const RequestId& id) {
  msg::PlanEvent message;
  message.request_id(id.bytes);
  return message;
}

}  // namespace

AnswerWriter::AnswerWriter(const wire::Participant& participant, const std::string& client_id)
    : writer_(participant, {.partition = client_id}) {}

bool AnswerWriter::full() const {
  const MutexLock lock(mutex_);
  return answers_.size() >= wire::kAnswersPerWriter || bytes_ >= kFullBytes;
}

bool AnswerWriter::answering(const RequestId& id) const {
  const MutexLock lock(mutex_);
  const auto found = answers_.find(id);
  return found != answers_.end() && !found->second.ended_at;
}

std::vector<RequestId> AnswerWriter::unfinished() const {
  const MutexLock lock(mutex_);
  std::vector<RequestId> ids;
  for (const auto& [id, answer] : answers_) {
    if (!answer.ended_at) ids.push_back(id);
  }
  return ids;
}

bool AnswerWriter::write(const PlanEvent& event) {
  const msg::PlanEvent message = wire::encode(event);
  {
    const MutexLock lock(mutex_);
    if (event.sequence == 0) answers_[event.request_id] = {};
    bytes_ += msg::PlanEvent::getCdrSerializedSize(message);
  }
  if (writer_.write(message) != wire::WriteResult::kOk) return false;
  if (!std::holds_alternative<Outcome>(event.payload)) return true;
  writer_.dispose(keyOnly(event.request_id));
  const MutexLock lock(mutex_);
  answers_[event.request_id].ended_at = Clock::now();
  return true;
}

void AnswerWriter::confirm(const RequestId& id) {
  const MutexLock lock(mutex_);
  const auto found = answers_.find(id);
  if (found != answers_.end()) found->second.confirmed = true;
}

void AnswerWriter::giveUp(const RequestId& id) {
  const MutexLock lock(mutex_);
  const auto found = answers_.find(id);
  if (found != answers_.end()) found->second = {Clock::now(), true};
}

bool AnswerWriter::spent(Clock::time_point before) const {
  const MutexLock lock(mutex_);
  return std::all_of(answers_.begin(), answers_.end(), [&](const auto& entry) {
    const Answer& answer = entry.second;
    return answer.ended_at && (answer.confirmed || *answer.ended_at < before);
  });
}

bool AnswerWriter::delivered() {
  using namespace std::chrono_literals;
  return spent(Clock::time_point::min()) || writer_.waitForAcknowledgments(0ms);
}

std::size_t AnswerWriter::bytes() const {
  const MutexLock lock(mutex_);
  return bytes_;
}

}  // namespace handover
