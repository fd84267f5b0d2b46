// SPDX-License-Identifier: Apache-2.0
// Which arms may give and which may receive ([paper] §IV-A).
#pragma once

#include "core/handover/planner.hpp"

#include <string>
#include <vector>

namespace handover {

struct RankedArm {
  int arm = -1;
  double manipulability = 0;  ///< the map's entry that ranked it, or that of a configuration
};

struct ArmRanking {
  std::vector<RankedArm> arms;   ///< usable ones, best first, ties by model order
  std::vector<ArmScore> scores;  ///< every arm, in model order, with why it is out
};

/// Ranks a robot's arms for an object pose. The paper looks up the object's origin; `wide` looks up
/// the tool positions of the arm's grasps and takes the best (a hammer is longer than a voxel); an
/// arm that the map says does not reach is out only if no grasp has an IK solution either.
/// @param only  name of the only arm allowed; empty: any.
ArmRanking rankArms(const HandoverProblem& problem, int robot, const Pose& X_WO,
                    const std::string& only, SearchWidth search);

}  // namespace handover
