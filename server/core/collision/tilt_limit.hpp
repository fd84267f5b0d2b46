// SPDX-License-Identifier: Apache-2.0
// How far a held object may lean (design §5, Upright).
#pragma once

#include "core/collision/joint_motion.hpp"
#include "core/collision/rigid_groups.hpp"

#include <handover/common/pose.hpp>

namespace handover {

/// The angle between an axis of the object and world z is at most `most` [rad], but for the
/// rounding of its ends' poses (kTiltSlack).
struct TiltLimit {
  Eigen::Vector3d axis_O = Eigen::Vector3d::UnitZ();  ///< unit
  double most = 0;

  bool keeps(const Pose& X_WO) const;

  /// What leans too far is turned back to this angle [rad]: segments to and from there lean more
  /// than their ends. (With 2 degrees less than the limit kneeling needs a third more time.)
  double within() const { return 0.5 * most; }

  /// The least turn of the world that brings an object there; none where it keeps the limit.
  Eigen::AngleAxisd turnWithin(const Eigen::Matrix3d& R_WO) const;
};

/// A state may be beyond its limit by half of this [rad], and what is between states by all: a
/// tenth of what the contract's verifier forgives.
inline constexpr double kTiltSlack = 2e-5;

/// The angle between a unit axis and world z [rad], from 0 to pi.
double tiltOf(const Eigen::Vector3d& axis_W);

/// True when an object that moves with a group keeps its limit all along a motion: proven by
/// halving it. Moves the groups.
/// @param R_GO  of the object in the group.
/// @pre the groups have their posture.
bool keepsTilt(RigidGroups& groups, int group, const Eigen::Matrix3d& R_GO, const TiltLimit& limit,
               const JointMotion& motion, double from, double to);

}  // namespace handover
