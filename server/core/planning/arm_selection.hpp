// SPDX-License-Identifier: Apache-2.0
// Which arms may take and which may put down ([paper] §IV-A).
#pragma once

#include "core/planning/transport_problem.hpp"

#include <handover/common/deadline.hpp>

#include <vector>

namespace handover {

struct RankedArm {
  ChainHolder arm;
  double manipulability = 0;  ///< the map's entry that ranked it, or that of a configuration
};

struct ArmRanking {
  std::vector<RankedArm> arms;   ///< usable ones, best first, ties by robot and model order
  std::vector<ArmScore> scores;  ///< every arm of those robots, in that order
  bool proven = true;            ///< no arm was left out by a sample alone: a map, a numeric IK
};

/// Ranks arms for an object pose. The paper looks up the object's origin; `wide` looks up the tool
/// positions of the arm's grasps and takes the best (a hammer is longer than a voxel); an arm that
/// the map says does not reach is out only if no grasp has an IK solution either.
/// @param which   a robot's arms, or one of them; nullopt: every robot's.
/// @param holder  place in the chain, for the scores.
/// @param deadline  once it is over arms that the map does not know are left out.
ArmRanking rankArms(const TransportProblem& problem, const std::optional<ChainHolder>& which,
                    std::size_t holder, const Pose& X_WO, const Deadline& deadline);

/// Every arm that could hold the object in the middle of a chain: those that are fit.
std::vector<ChainHolder> fitArms(const TransportProblem& problem,
                                 const std::optional<ChainHolder>& which);

}  // namespace handover
