// SPDX-License-Identifier: Apache-2.0
#include "core/planning/linear_motion.hpp"

#include <algorithm>
#include <span>

namespace handover {
namespace {

/// The line of the greatest of the distances (falling) that is free; end_at(distance) is where it
/// leads.
template <typename EndAt>
std::optional<JointPath> longestPath(const Manipulator& arm, const ArmVector& q, const Pose& X_WT,
                                     std::span<const double> distances, const EndAt& end_at,
                                     StateChecker& checker) {
  // The shortest first: where it is blocked, longer ones are, too.
  auto shortest = linearPath(arm, q, X_WT, end_at(distances.back()), checker);
  if (!shortest) return std::nullopt;
  for (const double distance : distances.first(distances.size() - 1)) {
    if (auto path = linearPath(arm, q, X_WT, end_at(distance), checker)) return path;
  }
  return shortest;
}

}  // namespace

JointPath reversed(JointPath path) {
  std::reverse(path.waypoints.begin(), path.waypoints.end());
  return path;
}

std::optional<JointPath> linearPath(const Manipulator& arm, const ArmVector& q, const Pose& X_WT,
                                    const Pose& X_WT_end, StateChecker& checker) {
  auto line = straightLine(*arm.kinematics, q, arm.worldToArm(X_WT), arm.worldToArm(X_WT_end));
  if (!line || !checker.valid(line->waypoints.back()) ||
      !checker.isMotionFree(PolylineMotion(line->waypoints))) {
    return std::nullopt;
  }
  return std::move(*line);
}

std::optional<JointPath> retreatPath(const Manipulator& arm, const ArmVector& q, const Pose& X_WT,
                                     StateChecker& checker, const LinearMotionSettings& settings) {
  const auto back = [&](double distance) { return arm.backedOff(X_WT, distance); };
  return longestPath(arm, q, X_WT, settings.retreat, back, checker);
}

std::optional<JointPath> liftPath(const Manipulator& arm, const ArmVector& q, const Pose& X_WT,
                                  StateChecker& checker, const LinearMotionSettings& settings) {
  const auto up = [&](double height) -> Pose { return Eigen::Translation3d(0, 0, height) * X_WT; };
  return longestPath(arm, q, X_WT, settings.lift, up, checker);
}

}  // namespace handover
