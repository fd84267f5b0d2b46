// SPDX-License-Identifier: Apache-2.0
#include "core/collision/tilt_limit.hpp"

#include <cmath>
#include <utility>
#include <vector>

namespace handover {

double tiltOf(const Eigen::Vector3d& axis_W) {
  return std::atan2(std::hypot(axis_W.x(), axis_W.y()), axis_W.z());
}

bool TiltLimit::keeps(const Pose& X_WO) const {
  return tiltOf(X_WO.linear() * axis_O) <= most + 0.5 * kTiltSlack;
}

Eigen::AngleAxisd TiltLimit::turnWithin(const Eigen::Matrix3d& R_WO) const {
  const Eigen::Vector3d axis_W = R_WO * axis_O;
  const double tilt = tiltOf(axis_W);
  if (tilt <= most) return Eigen::AngleAxisd::Identity();
  const Eigen::Vector3d across = axis_W.cross(Eigen::Vector3d::UnitZ());
  const bool turned_over = across.norm() < 1e-9;  // any way back is as short
  return Eigen::AngleAxisd(tilt - within(),
                           turned_over ? Eigen::Vector3d::UnitX() : across.normalized());
}

bool keepsTilt(RigidGroups& groups, int group, const Eigen::Matrix3d& R_GO, const TiltLimit& limit,
               const JointMotion& motion, double from, double to) {
  const Eigen::Vector3d axis_G = R_GO * limit.axis_O;
  MotionInterval stretch;
  // Breadth first: what leans too far is found by few looks spread over the motion.
  std::vector<std::pair<double, double>> parts{{from, to}};
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto [begin, end] = parts[i];
    motion.stretch(begin, end, stretch);
    groups.place(stretch.q_middle);
    const double tilt = tiltOf(groups.pose(group).linear() * axis_G);
    if (tilt > limit.most + 0.5 * kTiltSlack) return false;
    const double turn = groups.turn(group, Eigen::Vector3d::UnitZ(), stretch);
    if (tilt + turn <= limit.most + kTiltSlack) continue;
    const double middle = 0.5 * (begin + end);
    parts.emplace_back(begin, middle);
    parts.emplace_back(middle, end);
  }
  return true;
}

}  // namespace handover
