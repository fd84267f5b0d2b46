// SPDX-License-Identifier: Apache-2.0
// Time-optimal timing of a joint path under velocity and acceleration limits, as a cubic Hermite curve.
#pragma once

#include "core/motion/ikbirrt.hpp"

#include <handover/common/result.hpp>

#include <vector>

namespace handover {

/// Samples of a motion at rest at both ends; between them q(t) is the cubic Hermite curve of (q, qd).
struct TimedPath {
  std::vector<double> t;                 ///< strictly rising from 0 [s]
  std::vector<Eigen::VectorXd> q, qd;

  double duration() const { return t.back(); }
};

struct TimingLimits {
  Eigen::VectorXd lower, upper;          ///< the curve stays within 1e-9 of them
  Eigen::VectorXd velocity, acceleration;
};

struct TimingSettings {
  double blend = 0.05;                   ///< largest deviation at a corner from the polyline [rad]
  double max_sample_gap = 0.05;          ///< [s]
  double speed_scale = 1.0;              ///< in (0, 1]: stretches time by its inverse
};

/// Times a path (any number of joints). Zero-length and one-point paths give two equal samples
/// at rest, 1 ms apart. The curve keeps every limit exactly (velocity, acceleration <= limits).
/// kInvalidInput: no waypoints, not finite, sizes differ, a waypoint outside lower/upper, limits <= 0.
Result<TimedPath> parameterize(const std::vector<Eigen::VectorXd>& waypoints,
                               const TimingLimits& limits, const TimingSettings& settings);

/// q on the Hermite curve at time t, clamped to [0, duration].
Eigen::VectorXd evaluate(const TimedPath& path, double t);

/// Greatest ratios of |velocity| and |acceleration| to their limits over the whole curve, exact
/// (extremes of the cubics, not samples).
struct LimitUse {
  double velocity = 0, acceleration = 0;
};
LimitUse limitUse(const TimedPath& path, const TimingLimits& limits);

}  // namespace handover
