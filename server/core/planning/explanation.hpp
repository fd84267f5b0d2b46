// SPDX-License-Identifier: Apache-2.0
// Why there is no plan: the first filter that emptied, in one sentence, with typed causes.
#pragma once

#include "core/planning/arm_selection.hpp"
#include "core/planning/cause_tally.hpp"
#include "core/planning/grasp_feasibility.hpp"

#include <map>
#include <string>

namespace handover {

/// @param exhaustive  everything within what the search covers was tried.
Failed failed(FailureReason reason, std::string filter, std::string text,
              std::vector<CauseCount> causes, bool exhaustive);

/// What a search has gone through.
struct SearchCounts {
  std::uint32_t lattice_points = 0;  ///< that a giver and a receiver reach
  std::uint32_t poses_asked = 0;
  std::uint32_t tuples = 0;
  bool cut = false;  ///< some handover poses were not looked at, or not to the end
  CauseTally handover_rejects, motion_rejects;
};

/// Grasp sets pruned so far, by arm.
using PrunedByArm = std::map<ArmName, PrunedGrasps>;

/// No arm is left for the start (or the goal): kNoGrasp where none can hold the object at all.
Failed explainArms(const TransportProblem& problem, PruningPlace place, const ArmRanking& ranking);

/// No plan, though there are arms.
Failed explainSearch(const TransportProblem& problem, const PrunedByArm& at_start,
                     const PrunedByArm& at_goal, const SearchCounts& counts);

bool noneKept(const PrunedByArm& sets);

}  // namespace handover
