// SPDX-License-Identifier: Apache-2.0
// Small robots made by hand: a wrist with a hand of few joints.
#pragma once

#include "core/model/robot_model.hpp"
#include "core/model/scene.hpp"

namespace handover {

/// One wrist joint, a box for a palm, two flat fingers that slide towards each other along x;
/// approach axis +z, tool frame 5 cm before the palm. Opens to 110 mm, fingers 60 mm long.
RobotModel parallelGripper();

/// The same palm with two fingers of two hinges each that curl towards each other, 80 mm and 60 mm
/// long links; the second finger's tip mimics the first's.
RobotModel curlingHand();

/// A cup of 30 mm length before a body of 60 x 60 x 50 mm; the tool's origin is the middle of the
/// cup's lip, z towards the object.
RobotModel suctionGripper(double radius);

SceneObject objectOf(const std::string& name, std::vector<Shape> shapes);
SceneObject boxObject(const Eigen::Vector3d& size);
SceneObject sphereObject(double radius);
SceneObject cylinderObject(double radius, double length);

}  // namespace handover
