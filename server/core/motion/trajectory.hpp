// SPDX-License-Identifier: Apache-2.0
// Timed joint curves: quintic Hermite samples, and what they keep of the joints' limits.
#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <vector>

namespace handover {

/// Samples of a motion; between them q(t) is the quintic Hermite curve of (q, qd, qdd).
struct TimedPath {
  std::vector<double> t;  ///< strictly rising from 0 [s], at least two
  std::vector<Eigen::VectorXd> q, qd, qdd;

  double duration() const { return t.back(); }
};

struct TimingLimits {
  Eigen::VectorXd lower, upper;  ///< [rad]
  Eigen::VectorXd velocity, acceleration, jerk;
};

/// q on the curve at time t, clamped to [0, duration].
Eigen::VectorXd evaluate(const TimedPath& path, double t);
/// The same, and the curve's velocity there; no allocation when the sizes fit already.
void evaluate(const TimedPath& path, double t, Eigen::VectorXd& q, Eigen::VectorXd& qd);
void evaluate(const TimedPath& path, double t, Eigen::VectorXd& q, Eigen::VectorXd& qd,
              Eigen::VectorXd& qdd);

/// Greatest ratios of |velocity|, |acceleration| and |jerk| to their limits over the whole curve,
/// between samples too: never too low, too high by at most 1e-9.
struct LimitUse {
  double velocity = 0, acceleration = 0, jerk = 0;
};

LimitUse limitUse(const TimedPath& path, const TimingLimits& limits);

/// Greatest excess [rad] of the curve beyond lower/upper: never too low, too high by at most
/// 1e-9; <= 0 inside.
double positionExcess(const TimedPath& path, const TimingLimits& limits);

/// The samples `first` to `last`, both included, with a time of their own from 0: the pieces of a
/// path that is cut at a sample have its q, qd, qdd in common.
/// @pre first < last < path.t.size(); else std::invalid_argument.
TimedPath slice(const TimedPath& path, std::size_t first, std::size_t last);

/// Lets `next` follow. @pre it begins with the q, qd, qdd that `path` ends with.
void append(TimedPath& path, const TimedPath& next);

/// The same curve, slower by `factor` > 0.
void stretchTime(TimedPath& path, double factor);

/// Slows the whole curve until the limits of velocity, acceleration and jerk hold for the numbers
/// as they are.
void keepLimits(TimedPath& path, const TimingLimits& limits);

}  // namespace handover
