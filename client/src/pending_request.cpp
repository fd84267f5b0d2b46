// SPDX-License-Identifier: Apache-2.0
#include "pending_request.hpp"

namespace handover::client {

bool PlanHandle::State::begin(const AnswerId& id) {
  const bool again = answer.has_value();
  if (again) dropped.insert(*answer);
  answer = id;
  planned_at.reset();
  failed_at.reset();
  stages_missing.clear();
  next_sequence = 0;
  return again;
}

bool PlanHandle::State::isOutdated(const PlanEvent& event) {
  const auto* accepted = std::get_if<Accepted>(&event.payload);
  if (accepted != nullptr && accepted->epoch > 0 && accepted->epoch < epoch) {
    outdated.insert(event.answer_id);
  }
  return outdated.contains(event.answer_id);
}

void PlanHandle::State::note(const PlanEvent& event, const wire::Guid& sender,
                             Clock::time_point at) {
  if (event.sequence == 0) {
    const auto* accepted = std::get_if<Accepted>(&event.payload);
    epoch = accepted == nullptr ? 0 : accepted->epoch;
    from = sender;
  }
  ++next_sequence;
  heard_at = at;
  if (const auto* solution = std::get_if<Solution>(&event.payload)) {
    stages_missing[solution->index] = solution->stage_count;
  } else if (const auto* stage = std::get_if<StageTrajectory>(&event.payload)) {
    const auto found = stages_missing.find(stage->solution);
    const bool whole = found != stages_missing.end() && --found->second == 0;
    if (whole && !planned_at) planned_at = at;
  } else if (std::holds_alternative<Failure>(event.payload) && !failed_at) {
    failed_at = at;
  } else if (const auto* outcome = std::get_if<Outcome>(&event.payload)) {
    if (std::holds_alternative<Failed>(*outcome) && !failed_at) failed_at = at;
    if (!std::holds_alternative<Failed>(*outcome)) failed_at.reset();
  }
}

}  // namespace handover::client
