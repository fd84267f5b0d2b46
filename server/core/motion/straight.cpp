// SPDX-License-Identifier: Apache-2.0
#include "core/motion/straight.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace handover {
namespace {

constexpr double kMostSteps = 100'000;

std::string faultOf(const TrackPoseIk& track, const ArmVector& q_from, const Pose& X_AT_from,
                    const Pose& X_AT_to, const StraightSettings& settings) {
  if (!track) return "track: no function";
  if (q_from.size() == 0 || !q_from.allFinite()) return "q_from: empty or not finite";
  if (!X_AT_from.matrix().allFinite()) return "X_AT_from: not finite";
  if (!X_AT_to.matrix().allFinite()) return "X_AT_to: not finite";
  for (const double value : {settings.step, settings.angle_step, settings.max_joint_step}) {
    if (!(value > 0)) return "settings: a step is not above 0";
  }
  return "";
}

std::string passed(int step, int steps) {
  return std::to_string(100 * step / steps) + " % of the straight line passed";
}

}  // namespace

Result<JointPath> straightLine(const TrackPoseIk& track, const ArmVector& q_from,
                               const Pose& X_AT_from, const Pose& X_AT_to,
                               const StraightSettings& settings) {
  if (const std::string fault = faultOf(track, q_from, X_AT_from, X_AT_to, settings);
      !fault.empty()) {
    return {ErrorCode::kInvalidInput, fault};
  }
  const Eigen::Vector3d p_from = X_AT_from.translation(), p_to = X_AT_to.translation();
  const Eigen::Quaterniond quat_from(X_AT_from.linear()), quat_to(X_AT_to.linear());
  const double lengths = (p_to - p_from).norm() / settings.step;
  const double turns = quat_from.angularDistance(quat_to) / settings.angle_step;
  // 20.000000001 steps are 20.
  const double wanted = std::max(1.0, std::ceil(std::max(lengths, turns) - 1e-6));
  if (wanted > kMostSteps) return {ErrorCode::kInvalidInput, "the line needs too many steps"};
  const int steps = static_cast<int>(wanted);

  JointPath path;
  path.waypoints.reserve(static_cast<std::size_t>(steps) + 1);
  path.waypoints.push_back(q_from);
  for (int k = 1; k <= steps; ++k) {
    Pose X_AT = X_AT_to;
    if (k < steps) {
      const double s = static_cast<double>(k) / steps;
      X_AT.translation() = p_from + s * (p_to - p_from);
      X_AT.linear() = quat_from.slerp(s, quat_to).toRotationMatrix();
    }
    ArmVector q;
    if (!track(X_AT, path.waypoints.back(), settings.max_joint_step, q)) {
      return {ErrorCode::kUnreachable, passed(k - 1, steps)};
    }
    path.waypoints.push_back(q);
  }
  return path;
}

}  // namespace handover
