// SPDX-License-Identifier: Apache-2.0
// A hand alone, beside an object: what grasps are made with.
#pragma once

#include "core/collision/collision_scene.hpp"

#include <memory>
#include <vector>

namespace handover {

/// The hand cut off at the wrist: everything rigidly beyond the arm's last joint, and the fingers.
struct HandModel {
  std::shared_ptr<const RobotModel> model;  ///< root = child link of the arm's last joint, R
  Pose X_RT = Pose::Identity();
  Hand hand;  ///< with links and dofs of `model`
  Eigen::Vector3d approach_T = Eigen::Vector3d::UnitZ();
  /// The palm's (or cup's) farthest point along approach_T, from T [m]; -infinity: no shapes.
  double palm_extent = 0;
};

/// @throws std::invalid_argument if the arm has no hand or the palm, no cup, has no shapes.
HandModel extractEndEffector(const RobotModel& model, ArmId arm);

/// Every joint at 0, or as near as its limits let it come.
RobotVector restingPosture(const RobotModel& model);

/// The points that a link's shapes are drawn by, in the link; round shapes by inscribed facets.
std::vector<Eigen::Vector3d> outline(const Link& link);

/// The hand as robot 0 at rest, the object as object 0 at the origin.
std::shared_ptr<const CollisionScene> handAndObject(const SceneObject& object,
                                                    const HandModel& hand);

}  // namespace handover
