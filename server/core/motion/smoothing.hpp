// SPDX-License-Identifier: Apache-2.0
// From positions at even times to a curve whose jerk is bounded: their moving average is the
// control polygon of a uniform cubic B-spline.
//
// Why the limits hold: the spline's velocity and acceleration are convex combinations of the first
// and second differences of its control points, and those are averages of the samples' own, which
// are averages of the sampled motion's. Its jerk between two knots is the difference of two second
// differences of the samples, m apart, over m steps: known exactly before the curve is made.
#pragma once

#include "core/motion/trajectory.hpp"

#include <vector>

namespace handover {

/// Positions of a motion at even times; before and after it stands still.
class EvenSamples {
 public:
  /// @param q  one column per sample, at least one; @param step [s] between them.
  EvenSamples(Eigen::MatrixXd q, double step, const Eigen::VectorXd& jerk);

  double step() const { return step_; }

  /// The least number of samples to average over so that no joint's jerk is beyond its limit.
  int leastWindow() const;

  /// The knots of the spline for a window of m samples, from rest to rest: knot k of them stands at
  /// the time (k - m) step of the samples, and sees those at (k - m - 1) to (k) steps.
  Eigen::Index knots(int m) const { return q_.cols() + m + 1; }

  /// The spline, exact in quintic samples at some of its knots: those in `keep` (rising), the two
  /// ends, and where the jerk changes; none further apart than `gap`.
  /// @param[out] kept  the knots of the samples.
  TimedPath spline(int m, double gap, const std::vector<Eigen::Index>& keep,
                   std::vector<Eigen::Index>& kept) const;

 private:
  void fillJerk(int m, Eigen::Index interval, double* use) const;
  void appendKnot(int m, Eigen::Index knot, TimedPath& path) const;
  const double* column(Eigen::Index sample) const;

  Eigen::MatrixXd q_;
  double step_;
  /// Second differences, over what the limits of jerk let the acceleration change in one step.
  Eigen::MatrixXd bend_;
  Eigen::VectorXd rounding_;  ///< of a bend
};

}  // namespace handover
