// SPDX-License-Identifier: Apache-2.0
// Motions of least time between states of joints under limits of velocity and acceleration (Kunz,
// Stilman 2014; Hauser, Ng-Thow-Hing 2010): each joint has at most three pieces of constant
// acceleration, and all joints arrive together.
#pragma once

#include "core/motion/trajectory.hpp"

#include <optional>
#include <vector>

namespace handover {

/// Joints at one moment.
struct MotionState {
  Eigen::VectorXd q, qd;
};

class LeastTimeMotion {
 public:
  /// The quickest motion in which every joint gets by with the least acceleration for the common
  /// time and does not reverse it at once: there is time to build it down (jerk) in between;
  /// `least` [s] at least. nullopt: none was found that keeps lower/upper and the limits of
  /// velocity and acceleration. @pre sizes agree; the states' velocities are within their limits.
  static std::optional<LeastTimeMotion> between(const MotionState& from, const MotionState& to,
                                                const TimingLimits& limits, double least = 0);

  double duration() const { return duration_; }

  /// Joint positions [rad] at a time, clamped to [0, duration()], into `q`.
  void at(double t, Eigen::Ref<Eigen::VectorXd> q) const;

 private:
  /// One joint: `a` until `speed_up`, none until `slow_down`, then -`a`.
  struct Ramp {
    double q = 0, v = 0, a = 0, speed_up = 0, slow_down = 0;

    double at(double t) const;
    double velocityAt(double t) const;
  };

  struct JointEnds {
    double q, v, q_to, v_to;
  };

  struct JointLimits {
    double velocity, acceleration, jerk;
  };

  static std::optional<Ramp> ramp(const JointEnds& ends, double time, const JointLimits& limits);
  static bool keeps(const Ramp& ramp, double time, double lower, double upper);

  std::vector<Ramp> ramps_;
  double duration_ = 0;
};

/// [s] that a joint needs at least from one position and velocity to others; infinite where a
/// velocity is beyond its limit.
double leastTime(double way, double v, double v_to, double most_v, double most_a);

/// The slowest joint's, of all: never more than LeastTimeMotion's.
double leastTime(const MotionState& from, const MotionState& to, const TimingLimits& limits);

}  // namespace handover
