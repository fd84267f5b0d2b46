// SPDX-License-Identifier: Apache-2.0
// Time-optimal timing of a joint path under velocity and acceleration limits, as a cubic Hermite
// curve.
#pragma once

#include "core/motion/ikbirrt.hpp"

#include <handover/common/result.hpp>

#include <vector>

namespace handover {

/// Samples of a motion at rest at both ends; between them q(t) is the cubic Hermite curve of (q,
/// qd).
struct TimedPath {
  std::vector<double> t;  ///< strictly rising from 0 [s]
  std::vector<Eigen::VectorXd> q, qd;

  double duration() const { return t.back(); }
};

struct TimingLimits {
  Eigen::VectorXd lower, upper;  ///< the curve stays within 1e-9 of them
  Eigen::VectorXd velocity, acceleration;
};

struct TimingSettings {
  double blend = 0.05;           ///< largest deviation at a corner from the polyline [rad]
  double max_sample_gap = 0.05;  ///< [s] at full speed
  double speed_scale = 1.0;      ///< in (0, 1]: stretches time by its inverse
};

/// Times a path (any number of joints) near the optimum: straight lines joined by parabolas, timed
/// by backward controllable sets and a greedy forward pass (TOPP-RA, Pham & Pham 2018). The first
/// and the last sample are the given waypoints to the bit; waypoints nearer than 2e-5 rad to the
/// one before are left out; a blend of 0 stops at every corner. Zero-length and one-point paths
/// give two equal samples at rest, 1 ms apart. The curve keeps every limit exactly (velocity,
/// acceleration <= limits). kInvalidInput: no waypoints, not finite, sizes differ, a waypoint
/// outside lower/upper (by more than 1e-9), limits <= 0, settings out of range. Safe from any
/// thread.
/// @param stretch  if given: the factor (>= 1) by which the optimum of the grid was slowed so that
/// the
///                 cubics keep the limits, speed_scale apart.
Result<TimedPath> parameterize(const std::vector<Eigen::VectorXd>& waypoints,
                               const TimingLimits& limits, const TimingSettings& settings,
                               double* stretch = nullptr);

/// The same curve at `speed_scale` times the speed. @pre 0 < speed_scale <= 1.
TimedPath slowed(const TimedPath& path, double speed_scale);

/// q on the Hermite curve at time t, clamped to [0, duration].
Eigen::VectorXd evaluate(const TimedPath& path, double t);
/// The same, and the curve's velocity there; no allocation when the sizes fit already.
void evaluate(const TimedPath& path, double t, Eigen::VectorXd& q, Eigen::VectorXd& qd);

/// Greatest ratios of |velocity| and |acceleration| to their limits over the whole curve, exact
/// (extremes of the cubics, not samples).
struct LimitUse {
  double velocity = 0, acceleration = 0;
};

LimitUse limitUse(const TimedPath& path, const TimingLimits& limits);

/// Greatest excess of the curve beyond lower/upper, exact; <= 0 inside.
double positionExcess(const TimedPath& path, const TimingLimits& limits);

}  // namespace handover
