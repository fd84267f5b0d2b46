// SPDX-License-Identifier: Apache-2.0
// Kinematics of one serial arm, alone: frame A is the arm's base link, T its tool link.
#pragma once

#include "core/model/robot_model.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace handover {

using ArmJacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 8>;

/// How an IK call searches: swivel samples for redundant closed-form arms.
struct IkQuery {
  int swivel_samples = 32;    ///< evenly over the circle, starting at `swivel_offset`
  double swivel_offset = 0;   ///< [rad]
  bool all_windings = false;  ///< every 2 pi copy within limits, else only the nearest to `q_near`
  ArmVector q_near;           ///< preferred configuration; empty: middle of the limits
};

/// Why IK candidates fell: for the funnel's reject counts.
struct IkCounts {
  std::uint32_t no_ik = 0;   ///< geometry cannot reach
  std::uint32_t limits = 0;  ///< reached outside the joint limits
  std::uint32_t solutions = 0;
};

/// What the distance of two points alone tells of an arm with a spherical shoulder and wrist.
struct WristReach {
  Eigen::Vector3d p_TWrist;     ///< stays in T
  Eigen::Vector3d p_AShoulder;  ///< stays in A
  double least = 0;             ///< squared distance of the two [m^2]
  double most = 0;

  /// False: no configuration has them at that squared distance, whatever the joint limits.
  bool contains(double squared_distance) const {
    return squared_distance >= least && squared_distance <= most;
  }
};

/// Yoshikawa's sqrt(det(J J^T)), unscaled, m and rad ([paper] §IV-A): the product of J's singular
/// values. With fewer than six joints that of the joints' space, sqrt(det(J^T J)).
double manipulability(const ArmJacobian& J);

/// Immutable; safe from any thread. Joint vectors of another size than dofs() throw
/// std::invalid_argument.
class ArmKinematics {
 public:
  /// @throws std::invalid_argument when the arm has more than 8 joints, is not serial, has mimic
  /// joints or limits that are not finite.
  ArmKinematics(const RobotModel& model, ArmId arm);
  ~ArmKinematics();
  ArmKinematics(ArmKinematics&&) noexcept;
  ArmKinematics& operator=(ArmKinematics&&) noexcept;

  int dofs() const;
  const ArmVector& lower() const;
  const ArmVector& upper() const;
  const ArmVector& velocity() const;
  const ArmVector& acceleration() const;

  /// X_AT at q (FK of the model itself).
  Pose toolPose(const ArmVector& q) const;
  /// The same with its Jacobian, at little more than the price of one.
  Pose toolPose(const ArmVector& q, ArmJacobian& J) const;
  /// Geometric Jacobian of T in A: rows are linear (m), then angular (rad).
  ArmJacobian jacobian(const ArmVector& q) const;
  /// handover::manipulability of the Jacobian at q.
  double manipulability(const ArmVector& q) const;
  /// nullopt where there is no closed form.
  const std::optional<WristReach>& wristReach() const;
  /// No configuration within limits puts T farther than this from A's origin [m].
  double reach() const;
  /// The paper's shoulder, in A [m]: the settings' override, else where the first three axes meet,
  /// else where the first two do, else the first joint's origin.
  Eigen::Vector3d shoulder() const;
  /// True when the closed form for spherical-revolute-spherical arms applies.
  bool closedForm() const;
  bool withinLimits(const ArmVector& q, double tolerance = 1e-9) const;

  /// Configurations within limits that reach X_AT to 1e-9 in position [m] and rotation [rad],
  /// appended to `out` in an order that depends on the arguments alone. Closed form: every branch
  /// of every swivel angle; the angles in an order of which each beginning is spread evenly. Other
  /// chains: least squares from q_near and then from fixed configurations near the pose, two starts
  /// for each of swivel_samples, each configuration once (to 0.01 rad or m). A pose that is not
  /// finite has no solution.
  IkCounts solve(const Pose& X_AT, const IkQuery& query, std::vector<ArmVector>& out) const;

  /// True to go on.
  using Take = std::function<bool(const ArmVector&)>;
  /// The same configurations in the same order, each handed over as soon as it is found; ends early
  /// when `take` has had enough, and counts what was looked at until then. The first costs about 1
  /// us by the closed form, 20 us by least squares.
  IkCounts visit(const Pose& X_AT, const IkQuery& query, const Take& take) const;

  /// The one configuration that continues `q_near` to X_AT (to 1e-9) on the same branch with the
  /// least joint motion, for straight-line segments; false, q untouched, if it needs more than
  /// `max_step` [rad or m] of a joint or leaves the limits.
  bool trackPose(const Pose& X_AT, const ArmVector& q_near, double max_step, ArmVector& q) const;

 private:
  struct Data;
  std::unique_ptr<const Data> data_;
};

}  // namespace handover
