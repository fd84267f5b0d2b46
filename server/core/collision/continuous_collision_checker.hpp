// SPDX-License-Identifier: Apache-2.0
// Are bodies free of contact all along a motion? Proven by halving it.
#pragma once

#include "core/collision/collision_scene.hpp"
#include "core/collision/joint_motion.hpp"
#include "core/collision/rigid_groups.hpp"

namespace handover {

/// Scratch for proofs over one world; see StateChecker::isMotionFree() for what is proven.
class ContinuousCollisionChecker {
 public:
  /// False when a pair touches: it goes to `hit`. Moves the bodies in the world.
  /// @pre the groups have their posture and their balls.
  /// @throws std::invalid_argument when the motion's states do not fit the groups or are not
  /// finite.
  bool free(CollisionWorld& world, const PairList& pairs, RigidGroups& groups,
            const std::vector<MovingBody>& moving, const std::vector<int>& moving_index,
            const JointMotion& motion, double from, double to, const Clearance& clearance,
            BodyContact* hit);

 private:
  /// Part of a motion, and the pairs that may meet on it.
  struct Interval {
    double from, to;
    std::size_t first, last;  ///< in rows_
  };

  std::vector<Interval> intervals_;
  std::vector<PairList::Row> rows_, undecided_;
  std::vector<bool> wanted_;  ///< by index in `moving`
  MotionInterval interval_;
};

}  // namespace handover
