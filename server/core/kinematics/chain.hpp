// SPDX-License-Identifier: Apache-2.0
// A serial chain as plain arrays, every joint turned so that it moves about or along its own z
// axis.
#pragma once

#include "core/kinematics/arm_kinematics.hpp"

#include <array>

namespace handover::kinematics {

inline constexpr int kMaxJoints = 8;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Immutable after construction.
class Chain {
 public:
  /// @throws std::invalid_argument as ArmKinematics does.
  Chain(const RobotModel& model, const Arm& arm);

  int dofs() const { return dofs_; }

  bool prismatic(int joint) const { return prismatic_[joint]; }

  /// X_AT at q.
  Pose toolPose(const ArmVector& q) const;
  /// The same with the geometric Jacobian of T in A: linear rows (m) above angular ones (rad).
  Pose toolPose(const ArmVector& q, ArmJacobian& J) const;

  /// The joint's axis at q = 0 in A: a unit direction and a point on it.
  struct Axis {
    Eigen::Vector3d direction, point;
  };

  std::array<Axis, kMaxJoints> axesAtZero() const;
  /// No configuration within limits puts T farther from A's origin [m].
  double reach() const;

  ArmVector lower, upper, velocity, acceleration;

 private:
  struct Step {
    Eigen::Matrix3d R;
    Eigen::Vector3d p;
  };

  int dofs_ = 0;
  std::array<bool, kMaxJoints> prismatic_{};
  /// From A to the first joint's frame, from each joint's moved frame to the next, from the last to
  /// T.
  std::array<Step, kMaxJoints + 1> steps_;
};

/// What takes `X` to `X_target`: translation (m) over rotation vector (rad), both in A.
Vector6 poseError(const Pose& X_target, const Pose& X);

/// All numbers finite and the linear part a rotation to 1e-6: what may be asked for.
bool isRigid(const Pose& X);

/// True if both parts of a pose error are at most `tolerance` long.
inline bool withinTolerance(const Vector6& error, double tolerance) {
  const double limit = tolerance * tolerance;
  return error.head<3>().squaredNorm() <= limit && error.tail<3>().squaredNorm() <= limit;
}

}  // namespace handover::kinematics
