// SPDX-License-Identifier: Apache-2.0
#include "core/motion/trajectory.hpp"

#include "core/motion/quintic.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

namespace handover {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kTolerance = 1e-9;  // of a limit, or [rad]

JointState stateAt(const TimedPath& path, std::size_t i, Index j) {
  return {path.q[i][j], path.qd[i][j], path.qdd[i][j]};
}

Quintic quinticAt(const TimedPath& path, std::size_t i, Index j) {
  return {stateAt(path, i, j), stateAt(path, i + 1, j), path.t[i + 1] - path.t[i]};
}

/// Raises a share of a limit to what the polynomial with these Bernstein coefficients makes of it.
template <std::size_t n>
void raise(double& use, const std::array<double, n>& b, double limit) {
  double hull = 0;
  for (const double it : b) hull = std::max(hull, std::abs(it));
  if (hull <= use * limit) return;
  use = std::max(use, greatestMagnitude(b, use * limit, kTolerance * limit) / limit);
}

/// Calls use(j, state) for each joint's state at t.
template <typename Use>
void forEachJoint(const TimedPath& path, double t, const Use& use) {
  const Index dof = path.q.front().size();
  if (!(t > 0) || t >= path.duration()) {
    const std::size_t i = t > 0 ? path.t.size() - 1 : 0;
    for (Index j = 0; j < dof; ++j) use(j, stateAt(path, i, j));
    return;
  }
  const auto after = std::upper_bound(path.t.begin(), path.t.end(), t);
  const auto i = static_cast<std::size_t>(after - path.t.begin()) - 1;
  for (Index j = 0; j < dof; ++j) use(j, quinticAt(path, i, j).at(t - path.t[i]));
}

}  // namespace

VectorXd evaluate(const TimedPath& path, double t) {
  VectorXd q(path.q.front().size());
  forEachJoint(path, t, [&](Index j, const JointState& state) { q[j] = state.q; });
  return q;
}

void evaluate(const TimedPath& path, double t, VectorXd& q, VectorXd& qd) {
  q.resize(path.q.front().size());
  qd.resize(q.size());
  forEachJoint(path, t, [&](Index j, const JointState& state) {
    q[j] = state.q;
    qd[j] = state.qd;
  });
}

void evaluate(const TimedPath& path, double t, VectorXd& q, VectorXd& qd, VectorXd& qdd) {
  q.resize(path.q.front().size());
  qd.resize(q.size());
  qdd.resize(q.size());
  forEachJoint(path, t, [&](Index j, const JointState& state) {
    q[j] = state.q;
    qd[j] = state.qd;
    qdd[j] = state.qdd;
  });
}

LimitUse limitUse(const TimedPath& path, const TimingLimits& limits) {
  LimitUse use;
  for (std::size_t i = 0; i + 1 < path.t.size(); ++i) {
    for (Index j = 0; j < path.q[i].size(); ++j) {
      const Quintic curve = quinticAt(path, i, j);
      raise(use.velocity, curve.velocityControls(), limits.velocity[j]);
      raise(use.acceleration, curve.accelerationControls(), limits.acceleration[j]);
      raise(use.jerk, curve.jerkControls(), limits.jerk[j]);
    }
  }
  return use;
}

double positionExcess(const TimedPath& path, const TimingLimits& limits) {
  double worst = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < path.t.size(); ++i) {
    for (Index j = 0; j < path.q[i].size(); ++j) {
      std::array<double, 6> above = quinticAt(path, i, j).controls(), below = above;
      for (double& it : above) it -= limits.upper[j];
      for (double& it : below) it = limits.lower[j] - it;
      worst = greatestValue(above, worst, kTolerance);
      worst = greatestValue(below, worst, kTolerance);
    }
  }
  return worst;
}

TimedPath slice(const TimedPath& path, std::size_t first, std::size_t last) {
  if (first >= last || last >= path.t.size()) {
    throw std::invalid_argument("slice: no samples from " + std::to_string(first) + " to " +
                                std::to_string(last) + " of " + std::to_string(path.t.size()));
  }
  const auto cut = [&](const auto& all) {
    const auto begin = all.begin();
    return std::decay_t<decltype(all)>(begin + static_cast<std::ptrdiff_t>(first),
                                       begin + static_cast<std::ptrdiff_t>(last) + 1);
  };
  TimedPath piece{cut(path.t), cut(path.q), cut(path.qd), cut(path.qdd)};
  for (double& t : piece.t) t -= path.t[first];
  return piece;
}

void append(TimedPath& path, const TimedPath& next) {
  const double begin = path.duration();
  for (std::size_t i = 1; i < next.t.size(); ++i) path.t.push_back(begin + next.t[i]);
  path.q.insert(path.q.end(), next.q.begin() + 1, next.q.end());
  path.qd.insert(path.qd.end(), next.qd.begin() + 1, next.qd.end());
  path.qdd.insert(path.qdd.end(), next.qdd.begin() + 1, next.qdd.end());
}

void stretchTime(TimedPath& path, double factor) {
  for (double& t : path.t) t *= factor;
  for (VectorXd& qd : path.qd) qd /= factor;
  for (VectorXd& qdd : path.qdd) qdd /= factor * factor;
}

void keepLimits(TimedPath& path, const TimingLimits& limits) {
  for (int round = 0; round < 20; ++round) {
    const LimitUse use = limitUse(path, limits);
    if (use.velocity <= 1 && use.acceleration <= 1 && use.jerk <= 1) return;
    const double over = std::max({use.velocity, std::sqrt(use.acceleration), std::cbrt(use.jerk)});
    stretchTime(path, over * (1 + 1e-12 * (1 << round)));
  }
}

}  // namespace handover
