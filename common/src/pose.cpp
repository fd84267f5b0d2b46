// SPDX-License-Identifier: Apache-2.0
#include <handover/common/pose.hpp>

#include <algorithm>
#include <cmath>

namespace handover {

PoseValue toValue(const Pose& X) {
  Eigen::Quaterniond quat(X.linear());
  quat.normalize();
  const std::array<double, 4> wxyz{quat.w(), quat.x(), quat.y(), quat.z()};
  const auto first = std::find_if(wxyz.begin(), wxyz.end(), [](double c) { return c != 0.0; });
  const double sign = (first != wxyz.end() && *first < 0.0) ? -1.0 : 1.0;
  PoseValue value;
  for (std::size_t i = 0; i < 4; ++i) value.quat_wxyz[i] = sign * wxyz[i] + 0.0;  // + 0.0: no -0.0
  for (int i = 0; i < 3; ++i) value.xyz[static_cast<std::size_t>(i)] = X.translation()[i] + 0.0;
  return value;
}

Pose toPose(const PoseValue& value) {
  const auto& c = value.quat_wxyz;
  Pose X = Pose::Identity();
  X.linear() = Eigen::Quaterniond(c[0], c[1], c[2], c[3]).normalized().toRotationMatrix();
  X.translation() = Eigen::Vector3d(value.xyz[0], value.xyz[1], value.xyz[2]);
  return X;
}

Eigen::Matrix3d rotationFromRpy(double roll, double pitch, double yaw) {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  return (AngleAxisd(yaw, Vector3d::UnitZ()) * AngleAxisd(pitch, Vector3d::UnitY()) *
          AngleAxisd(roll, Vector3d::UnitX()))
      .toRotationMatrix();
}

double rotationAngle(const Eigen::Matrix3d& R) {
  const Eigen::Vector3d axis(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  return std::atan2(axis.norm(), R.trace() - 1.0);
}

}  // namespace handover
