// SPDX-License-Identifier: Apache-2.0
// Two robots, or two arms of one, that move at once.
#pragma once

#include "core/collision/continuous_collision_checker.hpp"
#include "core/collision/state_checker.hpp"

namespace handover {

/// Tests what one mover moves against what another moves, carried objects included; each
/// against everything else is for the two checkers by themselves. Standing pairs and those that
/// either setup allows are left out.
class RobotPairChecker {
 public:
  /// @throws std::invalid_argument when the checkers move a joint in common or are of two worlds.
  /// Their world must outlive this.
  RobotPairChecker(StateChecker& first, StateChecker& second);

  /// As StateChecker::isMotionFree(), of motions whose states are the first's dofs and then the
  /// second's. Leaves the movers anywhere.
  bool isMotionFree(const JointMotion& motion);

 private:
  CollisionWorld* world_;
  std::vector<MovingBody> moving_;  ///< the first's, then the second's; so the groups
  RigidGroups groups_;
  std::vector<int> moving_index_;  ///< by body; -1: not in `moving_`
  PairList pairs_;
  ContinuousCollisionChecker proof_;
};

}  // namespace handover
