// SPDX-License-Identifier: Apache-2.0
// Timing of joint polylines under velocity, acceleration and jerk limits.
//
// Corners are rounded by parabolas and the path is passed as fast as velocity and acceleration
// allow (SpeedProfile); then its samples at even times are smoothed by a moving average as wide as
// jerk asks for (EvenSamples), about the time that acceleration needs to build up. That keeps every
// limit, bends the path by at most acceleration * window^2 / 24 and takes one window longer.
#pragma once

#include "core/motion/trajectory.hpp"

#include <handover/common/result.hpp>

#include <cstddef>
#include <vector>

namespace handover {

struct TimingSettings {
  double blend = 0.05;           ///< largest deviation at a corner from the polyline [rad]
  double max_sample_gap = 0.05;  ///< [s] at full speed, at least 2 ms; longer in motions of minutes
  double speed_scale = 1.0;      ///< in (0, 1]: stretches time by its inverse
};

/// Times a path (any number of joints). The first and the last sample are the given waypoints to
/// the bit, with qd = qdd = 0; waypoints nearer than 2e-5 rad to the one before are left out; at a
/// corner the curve stops if blend is 0. Zero-length and one-point paths give two equal samples at
/// rest, 2 ms apart; no two samples are nearer than that. The curve keeps the limits of velocity,
/// acceleration and jerk, and lower/upper within 1e-9 rad; the acceleration is continuous.
/// kInvalidInput: no waypoints, not finite, sizes differ, a waypoint outside lower/upper (by more
/// than 1e-9), limits <= 0, settings out of range, more than an hour of motion. Safe from any
/// thread.
Result<TimedPath> parameterize(const std::vector<Eigen::VectorXd>& waypoints,
                               const TimingLimits& limits, const TimingSettings& settings);

/// Samples of a joined path around the point where one polyline goes over into the next.
struct Junction {
  std::size_t first = 0;    ///< the curve is on the polyline before up to here
  std::size_t nearest = 0;  ///< it passes the point about here
  std::size_t last = 0;     ///< it is on the polyline after from here on
};

struct JoinedTiming {
  TimedPath path;
  std::vector<Junction> junctions;  ///< one less than polylines, in order
};

/// Times polylines that follow one another as one motion. A junction is a corner like any other, so
/// the motion does not stop there unless blend is 0. `Junction` tells where the curve leaves the
/// last straight line of the polyline before (by more than 0.1 mrad on top of what smoothing bends)
/// and where it has reached the first of the polyline after; first <= nearest <= last, and all are
/// equal where it stops. Cut with slice(). Otherwise as parameterize(); kInvalidInput too if a
/// polyline does not begin where the one before ends, to the bit.
Result<JoinedTiming> parameterizeJoined(const std::vector<std::vector<Eigen::VectorXd>>& polylines,
                                        const TimingLimits& limits, const TimingSettings& settings);

}  // namespace handover
