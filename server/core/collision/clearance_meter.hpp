// SPDX-License-Identifier: Apache-2.0
// How near bodies come to each other while they move: bounds for whole stretches of a motion.
#pragma once

#include "core/collision/collision_scene.hpp"

#include <memory>
#include <vector>

namespace handover {

/// The bodies of a scene with poses of its own. Distances are of the shapes as the collision model
/// has them, without margins. Not thread-safe.
class ClearanceMeter {
 public:
  /// @pre the scene outlives this.
  explicit ClearanceMeter(const CollisionScene& scene);
  ~ClearanceMeter();

  /// @throws std::invalid_argument when the pose is not finite.
  void setPose(BodyId body, const Pose& X_WBody);

  /// Pairs of one of `moving` with any other body that may come nearer than `within` [m] while they
  /// travel, as their boxes tell; of two that move, once.
  /// @param groups  just given bounds, the bodies in place.
  /// @param index   in `moving`, by body; -1: stands still
  /// @pre every body has a pose.
  void findPairs(const RigidGroups& groups, const std::vector<MovingBody>& moving,
                 const std::vector<int>& index, double within, std::vector<BodyPair>& pairs);

  /// Whether it is proven that two bodies keep more than `apart` [m] all along the motion from
  /// where they stand.
  /// @param at_most  where it is not: they are no farther apart than this as they stand [m]; it
  /// falls
  ///                 to their distance as the motion gets shorter.
  bool keepApart(BodyId a, BodyId b, const PairMotion& motion, double apart, double& at_most) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace handover
