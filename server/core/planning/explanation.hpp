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
  /// That a giver and a receiver reach: of a chain's handovers the fewest, of chains the most.
  std::uint32_t lattice_points = 0;
  std::uint32_t poses_asked = 0;
  std::uint32_t last_poses = 0;  ///< of the last handover that both hands hold the object at
  std::uint32_t tuples = 0;
  std::uint32_t chains = 0;  ///< of arms, each with a grasp at the start and one at the goal
  bool alone = false;  ///< a chain of one was searched: the same grasp at the start and at the goal
  bool cut = false;    ///< some handover poses were not looked at, or not to the end
  bool may_meet = false;  ///< two arms that follow each other are not too far apart to meet
  CauseTally handover_rejects, motion_rejects;
};

/// Grasp sets pruned so far, by arm.
using PrunedByArm = std::map<ArmName, PrunedGrasps>;

/// No arm is left for the start (or the goal): kNoGrasp where none can hold the object at all.
Failed explainArms(const TransportProblem& problem, PruningPlace place, const ArmRanking& ranking);

/// The arm that is said to hold the object at the start cannot have it.
Failed explainUnfitHolder(const TransportProblem& problem, const ChainHolder& holder,
                          const Unfit& unfit);

/// No plan, though there are arms.
Failed explainSearch(const TransportProblem& problem, const PrunedByArm& at_start,
                     const PrunedByArm& at_goal, const SearchCounts& counts);

/// The deadline passed: how far the search was, and what it had counted.
Failed explainDeadline(const PrunedByArm& at_start, const PrunedByArm& at_goal,
                       const SearchCounts& counts);

/// Arms reach the start and the goal, but none that could make up a chain of n.
/// @param n  holders. @param takers, bringers  arms that reach the start, and the goal.
/// @param tally  what stands against the others.
Failed explainNoChain(const TransportProblem& problem, std::size_t n,
                      const std::vector<ArmName>& takers, const std::vector<ArmName>& bringers,
                      CauseTally tally);

bool noneKept(const PrunedByArm& sets);

}  // namespace handover
