// SPDX-License-Identifier: Apache-2.0
// Curves through joint space, as the collision checks want to know them.
#pragma once

#include <Eigen/Core>

#include <vector>

namespace handover {

/// Part of a curve through joint space, nearly straight: each of its states is
/// q_middle + x * along + something of at most `rest` per joint, with x from -1 to 1.
struct MotionInterval {
  Eigen::VectorXd q_middle, along, rest;
};

/// Where the values of a MotionInterval go, or those of some of its joints: all of one size.
struct MotionIntervalRef {
  Eigen::Ref<Eigen::VectorXd> q_middle, along, rest;
};

/// A continuous curve q(s) of some joints, s from 0 to 1.
class JointMotion {
 public:
  virtual ~JointMotion() = default;

  virtual Eigen::Index joints() const = 0;

  /// The curve between two parameters. `along` and `rest` go to 0 with the stretch, `rest` the
  /// faster where the curve is smooth. No allocation.
  /// @pre 0 <= from <= to <= 1; `out` has the size of joints().
  virtual void fill(double from, double to, MotionIntervalRef out) const = 0;

  /// The same; no allocation when the sizes fit already.
  void stretch(double from, double to, MotionInterval& out) const;
};

/// One straight segment. @pre `from` and `to` are of one size; they outlive this.
class SegmentMotion : public JointMotion {
 public:
  SegmentMotion(const Eigen::Ref<const Eigen::VectorXd>& from,
                const Eigen::Ref<const Eigen::VectorXd>& to)
      : from_(from), to_(to) {}

  Eigen::Index joints() const override { return from_.size(); }

  void fill(double from, double to, MotionIntervalRef out) const override {
    out.q_middle = from_ + 0.5 * (from + to) * (to_ - from_);
    out.along = 0.5 * (to - from) * (to_ - from_);
    out.rest.setZero();
  }

 private:
  Eigen::Ref<const Eigen::VectorXd> from_, to_;
};

/// Straight segments from waypoint to waypoint, all given an equal share of s.
class PolylineMotion : public JointMotion {
 public:
  /// @pre at least one waypoint, all of one size.
  template <typename Vector>
  explicit PolylineMotion(const std::vector<Vector>& waypoints)
      : waypoints_(waypoints.front().size(), static_cast<Eigen::Index>(waypoints.size())) {
    for (std::size_t i = 0; i < waypoints.size(); ++i) {
      waypoints_.col(static_cast<Eigen::Index>(i)) = waypoints[i];
    }
  }

  Eigen::Index joints() const override { return waypoints_.rows(); }

  void fill(double from, double to, MotionIntervalRef out) const override;

 private:
  Eigen::MatrixXd waypoints_;  ///< one per column
};

/// Two motions at once: the first's joints, then the second's. They outlive this.
class BothMotions : public JointMotion {
 public:
  BothMotions(const JointMotion& first, const JointMotion& second)
      : first_(first), second_(second) {}

  Eigen::Index joints() const override { return first_.joints() + second_.joints(); }

  void fill(double from, double to, MotionIntervalRef out) const override;

 private:
  const JointMotion &first_, &second_;
};

}  // namespace handover
