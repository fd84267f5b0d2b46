// SPDX-License-Identifier: Apache-2.0
// From timed and scheduled stages to what the wire and the plan file carry.
#pragma once

#include "core/planning/schedule.hpp"

#include <vector>

namespace handover {

/// A plan, ready to be sent.
struct TransportPlan {
  Solution solution;
  std::vector<StageTrajectory> trajectories;
};

/// Contacts and holds are those of each stage's own time: `may_touch` what is allowed all through
/// it, `holding` what is held as it begins.
TransportPlan assemblePlan(const TransportProblem& problem, CollisionContext& context,
                           const TransportPath& path, const std::vector<TimedStage>& timed,
                           const std::vector<ScheduledStage>& schedule);

}  // namespace handover
