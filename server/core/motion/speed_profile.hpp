// SPDX-License-Identifier: Apache-2.0
// How fast a rounded polyline can be passed from rest to rest.
#pragma once

#include "core/motion/corner_path.hpp"
#include "core/motion/trajectory.hpp"

#include <cstddef>
#include <vector>

namespace handover {

/// x = s'^2 on the points of a path, linear in s between them.
class SpeedProfile {
 public:
  /// The fastest: backward controllable sets and a greedy forward pass (TOPP-RA, Pham & Pham 2018).
  /// Velocity and acceleration keep their limits everywhere, not just at the points.
  /// The path outlives this.
  SpeedProfile(const CornerPath& path, const TimingLimits& limits);

  /// False if no speed above 0 was found somewhere.
  bool passable() const { return passable_; }

  double duration() const { return t_.back(); }

  /// [s] that the greatest acceleration of a joint needs to build up within its limit of jerk.
  double buildUp(const TimingLimits& limits) const;

  /// The same curve, slower by `factor`.
  void slowDown(double factor);

  /// Holds the speed for `window` [s] wherever it would turn from rising to falling sooner, as far
  /// as the falls of speed before and after leave room: acceleration is not reversed at once.
  void flattenPeaks(double window);

  /// q at 0, step, 2 step, ..., the last of them not before the end: one column each.
  Eigen::MatrixXd sample(double step) const;

  /// When the path is at s [rad] from its start.
  double timeAt(double s) const;
  /// How fast it passes there [rad/s].
  double speedAt(double s) const;

  /// q at a time, clamped to [0, duration()].
  void at(double t, Eigen::Ref<Eigen::VectorXd> q) const;

 private:
  // Two-sided bound on u, linear in x: |u + slope x| <= reach.
  struct Row {
    double reach, slope;
  };

  // Bounds on u in cell i at x: the lines c0 + c1 x.
  struct Range {
    double high0, high1, low0, low1;

    double high(double x) const { return high0 + high1 * x; }

    double low(double x) const { return low0 + low1 * x; }
  };

  void makeRows(const TimingLimits& limits);
  Row makeRow(std::size_t cell, double a, double b, double c);
  void cap(const TimingLimits& limits);
  Range range(std::size_t cell, double x, double next) const;
  void backward();
  void forward();
  void measureTime();
  bool allowed(std::size_t cell, double x, double next) const;
  void fill(std::size_t cell, double t, double* q) const;
  std::size_t flattenPeak(std::size_t peak, double window);

  const CornerPath& path_;
  std::vector<Row> rows_;                         // per cell: dof at its start, dof at its end
  std::vector<double> row_cap_, straight_reach_;  // per cell
  std::vector<double> cap_, reach_, x_, t_;       // per point
  bool passable_ = true;
};

}  // namespace handover
