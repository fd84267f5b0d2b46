// SPDX-License-Identifier: Apache-2.0
// Rigid poses, and the one place where they turn into plain numbers and back.
//
// X_AB is the pose of frame B seen from frame A; p_AB a point; R_AB a rotation. The letters:
//   W world · B a robot's root link · A an arm's base link (parent of its first joint) · L a link
//   T a tool link (Tg giver's, Tr receiver's) · O the object · H the object at the handover
//   S a shape
#pragma once

#include <Eigen/Geometry>

#include <array>

namespace handover {

using Pose = Eigen::Isometry3d;

/// A pose as files and the wire carry it: metres and a unit quaternion with w >= 0.
struct PoseValue {
  std::array<double, 3> xyz{0, 0, 0};
  std::array<double, 4> quat_wxyz{1, 0, 0, 0};

  bool operator==(const PoseValue&) const = default;
};

/// Plain numbers of a rigid pose. The quaternion is normalised, its first non-zero component
/// positive; no component is -0.0, so equal poses print alike.
PoseValue toValue(const Pose& X);

/// The rigid pose of plain numbers; the quaternion is normalised first.
/// @pre all numbers finite, the quaternion not zero (validated where input is decoded).
Pose toPose(const PoseValue& value);

/// Fixed-axis roll, pitch, yaw (URDF convention) [rad] to a rotation.
Eigen::Matrix3d rotationFromRpy(double roll, double pitch, double yaw);

/// Angle of a rotation [rad], in [0, pi].
double rotationAngle(const Eigen::Matrix3d& R);

}  // namespace handover
