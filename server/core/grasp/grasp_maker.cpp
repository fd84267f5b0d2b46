// SPDX-License-Identifier: Apache-2.0
#include "core/grasp/grasp_maker.hpp"

#include <algorithm>

namespace handover {

using Eigen::Vector3d;

Extent extentOf(const std::vector<SurfaceSample>& samples) {
  Extent extent;
  Vector3d low = samples.front().p_O;
  Vector3d high = low;
  for (const SurfaceSample& s : samples) {
    extent.centre += s.p_O / static_cast<double>(samples.size());
    low = low.cwiseMin(s.p_O);
    high = high.cwiseMax(s.p_O);
  }
  for (const SurfaceSample& s : samples)
    extent.size = std::max(extent.size, (s.p_O - extent.centre).norm());
  extent.box = high - low;
  int longest = 2;  // ties within 5 %: the later axis wins, so a cube's is z
  for (int axis = 1; axis >= 0; --axis) {
    if ((high - low)[axis] > 1.05 * (high - low)[longest]) longest = axis;
  }
  extent.long_axis = Vector3d::Unit(longest);
  return extent;
}

Pose toolPose(const SurfaceSample& sample, const HandModel& hand, const Extent& extent,
              double height, double roll) {
  const auto frame = [](const Vector3d& main, const Vector3d& hint, const Vector3d& other_hint) {
    Vector3d side = hint - hint.dot(main) * main;
    if (side.norm() < 0.1) side = other_hint - other_hint.dot(main) * main;
    side.normalize();
    Eigen::Matrix3d R;
    R << main, side, main.cross(side);
    return R;
  };
  const Vector3d other(extent.long_axis.y(), extent.long_axis.z(), extent.long_axis.x());
  const Eigen::Matrix3d R_OF = frame(-sample.n_O, extent.long_axis, other);
  const Eigen::Matrix3d R_TF = frame(hand.approach_T, Vector3d::UnitX(), Vector3d::UnitY());
  Pose X_OT = Pose::Identity();
  X_OT.linear() = Eigen::AngleAxisd(roll, -sample.n_O) * R_OF * R_TF.transpose();
  X_OT.translation() = sample.p_O + height * sample.n_O;
  return X_OT;
}

Pose asWritten(Pose X) {
  for (int nudge = 0; nudge < 20; ++nudge) {
    for (int i = 0; i < 5; ++i) {
      const Pose again = toPose(toValue(X));
      if (again.matrix() == X.matrix()) return X;
      X = again;
    }
    X.linear() = X.linear() * Eigen::AngleAxisd(1e-9, Vector3d(0.36, 0.48, 0.8)).toRotationMatrix();
  }
  return X;
}

}  // namespace handover
