// SPDX-License-Identifier: Apache-2.0
// Straight lines of the tool in space, as joint paths: approach, lift, place, retreat. Not checked
// for collisions.
#pragma once

#include "core/kinematics/arm_kinematics.hpp"
#include "core/motion/ikbirrt.hpp"

#include <handover/common/pose.hpp>
#include <handover/common/result.hpp>

#include <functional>

namespace handover {

struct StraightSettings {
  double step = 0.005;            ///< [m] between waypoints
  double angle_step = 0.0349066;  ///< [rad] between waypoints (2 degrees)
  double max_joint_step = 0.15;   ///< [rad] of one joint between waypoints; more is a jump
};

/// Continues a configuration to a near tool pose, as ArmKinematics::trackPose() does.
using TrackPoseIk =
    std::function<bool(const Pose& X_AT, const ArmVector& q_near, double max_step, ArmVector& q)>;

/// The joint path on which T goes straight from X_AT_from to X_AT_to: positions linearly, rotations
/// by slerp, both in step. Its first waypoint is `q_from` to the bit. kUnreachable where `track`
/// gives up: the detail tells which part of the line was passed. kInvalidInput: not finite, no
/// function, settings <= 0.
/// @pre X_AT_from is the tool's pose at q_from. A line the other way round is the path reversed.
Result<JointPath> straightLine(const TrackPoseIk& track, const ArmVector& q_from,
                               const Pose& X_AT_from, const Pose& X_AT_to,
                               const StraightSettings& settings = {});

/// The same on an arm's own kinematics.
inline Result<JointPath> straightLine(const ArmKinematics& kinematics, const ArmVector& q_from,
                                      const Pose& X_AT_from, const Pose& X_AT_to,
                                      const StraightSettings& settings = {}) {
  const TrackPoseIk track = [&](const Pose& X_AT, const ArmVector& q_near, double max_step,
                                ArmVector& q) {
    return kinematics.trackPose(X_AT, q_near, max_step, q);
  };
  return straightLine(track, q_from, X_AT_from, X_AT_to, settings);
}

}  // namespace handover
