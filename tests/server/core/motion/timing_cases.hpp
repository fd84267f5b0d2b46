// SPDX-License-Identifier: Apache-2.0
// Random paths and limits for tests of timing, and what every timed path promises.
#pragma once

#include "core/motion/timing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

namespace handover::test {

using Eigen::VectorXd;

inline TimingLimits uniformLimits(int dof, double position, double velocity, double acceleration) {
  return {VectorXd::Constant(dof, -position), VectorXd::Constant(dof, position),
          VectorXd::Constant(dof, velocity), VectorXd::Constant(dof, acceleration),
          VectorXd::Constant(dof, 10 * acceleration)};
}

/// The LWA4's orders of magnitude.
inline TimingLimits armLimits(int dof = 7) {
  TimingLimits limits = uniformLimits(dof, 3.0, 1.2, 0.4);
  for (int j = 0; j < dof; ++j) limits.velocity[j] = 0.9 + 0.1 * j;
  return limits;
}

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }

  int upTo(int most) { return static_cast<int>(uniform(0, most + 1)); }

  VectorXd point(const TimingLimits& limits) {
    VectorXd q(limits.lower.size());
    for (int j = 0; j < q.size(); ++j) q[j] = uniform(limits.lower[j], limits.upper[j]);
    return q;
  }

  /// Steps of 1e-7 to 1 times the way to other points, now and then none, back, or straight on.
  std::vector<VectorXd> path(const TimingLimits& limits) {
    std::vector<VectorXd> waypoints{point(limits)};
    const int count = upTo(8);
    for (int i = 0; i < count; ++i) {
      const double size = std::pow(10, upTo(4) == 0 ? uniform(-7, -3) : uniform(-2, 0));
      const VectorXd& last = waypoints.back();
      const int kind = waypoints.size() < 2 ? 9 : upTo(9);
      const VectorXd before = waypoints[waypoints.size() - (kind < 3 ? 2 : 1)];
      VectorXd next = last + size * (point(limits) - last);
      if (kind == 0) next = before;
      if (kind == 1) next = last + size * (last - before);
      if (kind == 2) next = last;
      waypoints.push_back(next.cwiseMax(limits.lower).cwiseMin(limits.upper));
    }
    return waypoints;
  }

 private:
  std::mt19937_64 engine_;
};

/// Position and its three derivatives at x in [0, 1] of interval i, in Bernstein form, to be
/// independent of the code under test.
struct State {
  VectorXd q, qd, qdd, jerk;
};

inline State hermite(const TimedPath& path, std::size_t i, double x) {
  const double h = path.t[i + 1] - path.t[i];
  const VectorXd v0 = h / 5 * path.qd[i], v1 = h / 5 * path.qd[i + 1];
  const VectorXd a0 = h * h / 20 * path.qdd[i], a1 = h * h / 20 * path.qdd[i + 1];
  const VectorXd d = path.q[i + 1] - path.q[i];
  std::vector<VectorXd> b{VectorXd::Zero(d.size()), v0, 2 * v0 + a0, d - 2 * v1 + a1, d - v1, d};
  const auto value = [x](std::vector<VectorXd> c) {
    for (; c.size() > 1; c.pop_back()) {
      for (std::size_t k = 0; k + 1 < c.size(); ++k) c[k] += x * (c[k + 1] - c[k]);
    }
    return c.front();
  };
  const auto derive = [h](std::vector<VectorXd>& c) {
    const double degree = static_cast<double>(c.size() - 1);
    for (std::size_t k = 0; k + 1 < c.size(); ++k) c[k] = degree / h * (c[k + 1] - c[k]);
    c.pop_back();
  };
  State state;
  state.q = path.q[i] + value(b);
  derive(b);
  state.qd = value(b);
  derive(b);
  state.qdd = value(b);
  derive(b);
  state.jerk = value(b);
  return state;
}

inline double share(const VectorXd& value, const VectorXd& limit) {
  return (value.array().abs() / limit.array()).maxCoeff();
}

/// Distance of q from the polyline.
inline double deviation(const std::vector<VectorXd>& waypoints, const VectorXd& q) {
  double best = (q - waypoints[0]).norm();
  for (std::size_t i = 0; i + 1 < waypoints.size(); ++i) {
    const VectorXd d = waypoints[i + 1] - waypoints[i];
    const double s =
        std::clamp(d.dot(q - waypoints[i]) / std::max(d.squaredNorm(), 1e-300), 0.0, 1.0);
    best = std::min(best, (q - waypoints[i] - s * d).norm());
  }
  return best;
}

/// What parameterize() promises of any path. The acceleration has no step as long as the jerk is
/// bounded and neighbours share a sample.
inline void expectSound(const TimedPath& path, const std::vector<VectorXd>& waypoints,
                        const TimingLimits& limits, const TimingSettings& settings) {
  ASSERT_GE(path.t.size(), 2u);
  ASSERT_EQ(path.t.size(), path.q.size());
  ASSERT_EQ(path.t.size(), path.qd.size());
  ASSERT_EQ(path.t.size(), path.qdd.size());
  EXPECT_EQ(path.t.front(), 0);
  EXPECT_EQ(path.q.front(), waypoints.front());
  EXPECT_EQ(path.q.back(), waypoints.back());
  for (const auto* rest :
       {&path.qd.front(), &path.qd.back(), &path.qdd.front(), &path.qdd.back()}) {
    EXPECT_EQ(rest->cwiseAbs().maxCoeff(), 0);
  }
  const LimitUse use = limitUse(path, limits);
  EXPECT_LE(use.velocity, 1.0);
  EXPECT_LE(use.acceleration, 1.0);
  EXPECT_LE(use.jerk, 1.0);
  EXPECT_LE(positionExcess(path, limits), 2e-9);
  State last{path.q[0], path.qd[0], path.qdd[0], path.qdd[0]};
  for (std::size_t i = 0; i + 1 < path.t.size(); ++i) {
    const double h = path.t[i + 1] - path.t[i];
    ASSERT_GE(h, 1e-3);
    EXPECT_LE(h, settings.max_sample_gap / settings.speed_scale * (1 + 1e-6));
    for (int k = 0; k <= 4; ++k) {
      const State state = hermite(path, i, k / 4.0);
      ASSERT_LE((state.q - limits.upper).maxCoeff(), 2e-9);
      ASSERT_LE((limits.lower - state.q).maxCoeff(), 2e-9);
      // Nothing between the samples beats what limitUse() says; rounding apart.
      ASSERT_LE(share(state.qd, limits.velocity), use.velocity + 1e-9);
      ASSERT_LE(share(state.qdd, limits.acceleration), use.acceleration + 1e-7);
      ASSERT_LE(share(state.jerk, limits.jerk), use.jerk + 1e-5);
      if (k == 0) {
        ASSERT_LE(share(state.qd - last.qd, limits.velocity), 1e-9);
        ASSERT_LE(share(state.qdd - last.qdd, limits.acceleration), 1e-7);
      }
      if (k == 4) last = state;
    }
  }
}

}  // namespace handover::test
