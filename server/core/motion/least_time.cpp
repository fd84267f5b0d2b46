// SPDX-License-Identifier: Apache-2.0
#include "core/motion/least_time.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace handover {
namespace {

using Eigen::Index;

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kRounding = 1e-9;  // of limits, and of times
// Between the least time and longer ones a joint that comes or leaves in motion may have times at
// which it cannot arrive, and coasting takes a little: these shares of the least time are tried.
constexpr std::array<double, 12> kLonger{1,    1.0003, 1.001, 1.003, 1.01, 1.03,
                                         1.06, 1.1,    1.15,  1.22,  1.3,  1.4};

double square(double x) { return x * x; }

}  // namespace

double leastTime(double way, double v, double v_to, double most_v, double most_a) {
  double least = kNever;
  for (const double side : {1.0, -1.0}) {
    const double a = side * most_a;
    const double squared = 0.5 * (square(v) + square(v_to)) + a * way;
    if (squared < 0) continue;
    const double peak = side * std::sqrt(squared);
    if (side * (peak - v) < -kRounding * most_v || side * (peak - v_to) < -kRounding * most_v) {
      continue;
    }
    if (std::abs(peak) <= most_v) {
      least = std::min(least, std::max(0.0, (2 * peak - v - v_to) / a));
      continue;
    }
    const double coast = side * most_v;
    const double ramps = (2 * square(coast) - square(v) - square(v_to)) / (2 * a);
    least = std::min(least, (2 * coast - v - v_to) / a + std::max(0.0, (way - ramps) / coast));
  }
  return least;
}

double leastTime(const MotionState& from, const MotionState& to, const TimingLimits& limits) {
  double time = 0;
  for (Index j = 0; j < from.q.size(); ++j) {
    time = std::max(time, leastTime(to.q[j] - from.q[j], from.qd[j], to.qd[j], limits.velocity[j],
                                    limits.acceleration[j]));
  }
  return time;
}

double LeastTimeMotion::Ramp::at(double t) const {
  const double first = std::min(t, speed_up);
  const double middle = std::clamp(t - speed_up, 0.0, slow_down - speed_up);
  const double last = std::max(0.0, t - slow_down);
  const double coast = v + a * speed_up;
  return q + (v + 0.5 * a * first) * first + coast * middle + (coast - 0.5 * a * last) * last;
}

double LeastTimeMotion::Ramp::velocityAt(double t) const {
  return v + a * std::min(t, speed_up) - a * std::max(0.0, t - slow_down);
}

/// With the least acceleration that arrives at `time`, coasting for `coast` at least in between.
std::optional<LeastTimeMotion::Ramp> LeastTimeMotion::ramp(const JointEnds& ends, double time,
                                                           const JointLimits& limits) {
  const double q = ends.q, v = ends.v, v_to = ends.v_to;
  const double way = ends.q_to - q, change = v_to - v;
  if (time <= 0) {
    if (std::abs(way) > kRounding || std::abs(change) > kRounding) return std::nullopt;
    return Ramp{q, v, 0, 0, 0};
  }
  if (std::abs(change) <= 1e-12 && std::abs(way - v * time) <= 1e-12) {
    return Ramp{q, v, 0, time, time};
  }
  std::optional<Ramp> best;
  const auto offer = [&](double a, double speed_up, double slow_down) {
    if (std::abs(a) > limits.acceleration * (1 + kRounding)) return;
    if (!best || std::abs(a) < std::abs(best->a)) best = Ramp{q, v, a, speed_up, slow_down};
  };
  // a^2 s (s + 2 coast) + a b - change^2 = 0, where s is the time not coasted.
  const double coast = std::min(limits.acceleration / limits.jerk, 0.5 * time);
  const double s = time - coast, square_term = s * (s + 2 * coast);
  const double b = 2 * (s + coast) * (v + v_to) - 4 * way;
  const double root = std::sqrt(square(b) + 4 * square_term * square(change));
  for (const double side : {1.0, -1.0}) {
    const double a = (side * root - b) / (2 * square_term);
    if (std::abs(a) < 1e-15) continue;
    const double turn = 0.5 * (s + change / a);
    if (turn < -kRounding * time || turn > s * (1 + kRounding)) continue;
    if (std::abs(v + a * turn) > limits.velocity * (1 + kRounding)) continue;
    const double speed_up = std::clamp(turn, 0.0, s);
    offer(a, speed_up, speed_up + coast);
  }
  for (const double speed : {limits.velocity, -limits.velocity}) {
    const double left = 2 * (speed * time - way);
    const double a = (square(speed - v) + square(speed - v_to)) / left;
    if (!(a * speed > 0)) continue;
    const double up = (speed - v) / a, down = (speed - v_to) / a;
    if (up < -kRounding || down < -kRounding || up + down > time * (1 + kRounding)) continue;
    const double speed_up = std::clamp(up, 0.0, time);
    offer(a, speed_up, std::clamp(time - down, speed_up, time));
  }
  return best;
}

bool LeastTimeMotion::keeps(const Ramp& ramp, double time, double lower, double upper) {
  const auto inside = [&](double t) {
    const double q = ramp.at(std::clamp(t, 0.0, time));
    return q >= lower - kRounding && q <= upper + kRounding;
  };
  if (!inside(0) || !inside(time)) return false;
  if (ramp.a == 0) return true;
  const double first = -ramp.v / ramp.a;  // it turns round
  if (first > 0 && first < ramp.speed_up && !inside(first)) return false;
  const double second = ramp.slow_down + ramp.velocityAt(ramp.slow_down) / ramp.a;
  return !(second > ramp.slow_down && second < time) || inside(second);
}

std::optional<LeastTimeMotion> LeastTimeMotion::between(const MotionState& from,
                                                        const MotionState& to,
                                                        const TimingLimits& limits, double least) {
  const double quickest = std::max(least, leastTime(from, to, limits));
  if (!(quickest < kNever)) return std::nullopt;
  const Index dof = from.q.size();
  LeastTimeMotion motion;
  for (const double longer : kLonger) {
    motion.ramps_.clear();
    motion.duration_ = longer * quickest;
    for (Index j = 0; j < dof; ++j) {
      const auto found = ramp({from.q[j], from.qd[j], to.q[j], to.qd[j]}, motion.duration_,
                              {limits.velocity[j], limits.acceleration[j], limits.jerk[j]});
      if (!found || !keeps(*found, motion.duration_, limits.lower[j], limits.upper[j])) break;
      motion.ramps_.push_back(*found);
    }
    if (motion.ramps_.size() == static_cast<std::size_t>(dof)) return motion;
  }
  return std::nullopt;
}

void LeastTimeMotion::at(double t, Eigen::Ref<Eigen::VectorXd> q) const {
  t = std::clamp(t, 0.0, duration_);
  for (std::size_t j = 0; j < ramps_.size(); ++j) q[static_cast<Index>(j)] = ramps_[j].at(t);
}

}  // namespace handover
