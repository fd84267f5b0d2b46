// SPDX-License-Identifier: Apache-2.0
// Inside of CollisionScene, shared by the sources of this module only.
#pragma once

#include "core/collision/collision_scene.hpp"
#include "core/collision/narrow_phase.hpp"

namespace handover {

/// One convex shape of a body, and a box round it (margin included) for the tests that come first.
struct SceneShape {
  NarrowShape narrow;
  Pose X_BS;                 ///< of the shape in its body
  Pose X_BBox;               ///< of the box's middle in the body
  Eigen::Vector3d box_half;  ///< half edges [m], margin included
};

/// What a body is: a robot's link, or an object.
struct BodyOwner {
  RobotId robot;
  LinkId link;
  ObjectId object;
};

struct ScenePlacement {
  Pose X_WO = Pose::Identity();
  std::optional<Attachment> attached_to;
};

struct CollisionScene::Data {
  std::vector<SceneRobot> robots;
  std::vector<ScenePlacement> objects;
  std::vector<std::string> names;  ///< by body, like owners
  std::vector<BodyOwner> owners;
  std::vector<int> first_shape;  ///< by body, one past the last at the end
  std::vector<SceneShape> shapes;
  std::vector<std::vector<BodyId>> link_bodies;  ///< by robot and link; invalid: no shapes
  std::vector<BodyId> object_bodies;
  BodyPairs standing{0};
};

}  // namespace handover
