// SPDX-License-Identifier: Apache-2.0
#include "runtime/request_log.hpp"

#include <handover/common/log.hpp>

#include <algorithm>

namespace handover {
namespace {

constexpr std::size_t kMostFaults = 8;

std::string textOf(const Rejected& rejected) {
  std::string faults;
  const std::size_t shown = std::min(rejected.faults.size(), kMostFaults);
  for (std::size_t i = 0; i < shown; ++i) {
    const Fault& fault = rejected.faults[i];
    faults +=
        (i == 0 ? "" : "; ") + fault.field + (fault.field.empty() ? "" : ": ") + fault.message;
  }
  const std::size_t more = rejected.faults.size() - shown;
  if (more > 0) faults += fmt::format("; and {} more", more);
  return fmt::format("rejected: {} ({})", toString(rejected.reason), faults);
}

const char* wordOf(const Outcome& outcome) {
  static constexpr const char* kWords[] = {"done", "failed", "cancelled", "rejected"};
  static_assert(std::variant_size_v<Outcome> == std::size(kWords));
  return kWords[outcome.index()];
}

std::string milliseconds(double seconds) { return fmt::format("{:.1f}", 1e3 * seconds); }

}  // namespace

std::string textOf(const Outcome& outcome) {
  if (const auto* done = std::get_if<Done>(&outcome)) {
    return done->complete ? "done" : "done, cut by the deadline";
  }
  if (const auto* fail = std::get_if<Failed>(&outcome)) {
    return fmt::format("failed: {} ({})", toString(fail->reason), fail->explanation.text);
  }
  if (const auto* rejected = std::get_if<Rejected>(&outcome)) return textOf(*rejected);
  return fmt::format("cancelled: {}", toString(std::get<Cancelled>(outcome).cause));
}

void logAnswer(const PlanRequest& request, const AnswerFacts& facts, const Outcome& outcome) {
  const std::string text = fmt::format(
      "request {} of {}: cell {}, task {}, seed {}, scene {}: {}; queued {} ms, prepared {} ms, "
      "planned {} ms",
      request.id.hex(), request.client_id, request.cell, facts.task, request.seed, facts.scene_hash,
      textOf(outcome), milliseconds(facts.queued_s), milliseconds(facts.prepared_s),
      milliseconds(facts.planned_s));
  logWith("runtime", spdlog::level::info, text,
          {{"HANDOVER_REQUEST", request.id.hex()},
           {"HANDOVER_CLIENT", request.client_id},
           {"HANDOVER_CELL", request.cell},
           {"HANDOVER_TASK", facts.task},
           {"HANDOVER_SEED", std::to_string(request.seed)},
           {"HANDOVER_SCENE", facts.scene_hash},
           {"HANDOVER_OUTCOME", wordOf(outcome)},
           {"HANDOVER_QUEUED_MS", milliseconds(facts.queued_s)},
           {"HANDOVER_PREPARED_MS", milliseconds(facts.prepared_s)},
           {"HANDOVER_PLANNED_MS", milliseconds(facts.planned_s)}});
}

}  // namespace handover
