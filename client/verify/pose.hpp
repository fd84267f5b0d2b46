// SPDX-License-Identifier: Apache-2.0
// Poses of the verifier: plain Eigen isometries, and how far apart two of them are.
#pragma once

#include <Eigen/Geometry>

#include <cmath>

namespace handover::verify {

using Pose = Eigen::Isometry3d;

/// Distance of the origins [m].
inline double translationBetween(const Pose& X_WA, const Pose& X_WB) {
  return (X_WA.translation() - X_WB.translation()).norm();
}

/// Angle of the rotation from A to B [rad]; exact near 0, where acos of the trace is not.
inline double rotationBetween(const Pose& X_WA, const Pose& X_WB) {
  const Eigen::Quaterniond quat_AB(X_WA.linear().transpose() * X_WB.linear());
  return 2 * std::atan2(quat_AB.vec().norm(), std::abs(quat_AB.w()));
}

/// R = Rz(yaw) Ry(pitch) Rx(roll), as URDF writes it.
inline Eigen::Matrix3d rotationFromRpy(const Eigen::Vector3d& rpy) {
  return (Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

}  // namespace handover::verify
