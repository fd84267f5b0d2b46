// SPDX-License-Identifier: Apache-2.0
// What the log tells of a request once it is answered.
#pragma once

#include <handover/common/plan_event.hpp>

#include <string>

namespace handover {

/// What became known of a request while it was answered; times in seconds.
struct AnswerFacts {
  std::string task, scene_hash;  ///< as planned: with the task that the request left out
  double queued_s = 0;           ///< until a worker took it, or its end
  double prepared_s = 0;         ///< making what it lacked
  double planned_s = 0;          ///< on a worker
};

/// "done", "failed: no_path (..)", "rejected: bad_request (field: fault; ..)", ...
std::string textOf(const Outcome& outcome);

/// One line: ids, cell, task, seed, scene, outcome and times; the same as fields for a journal.
void logAnswer(const PlanRequest& request, const AnswerFacts& facts, const Outcome& outcome);

}  // namespace handover
