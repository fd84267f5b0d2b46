// SPDX-License-Identifier: Apache-2.0
#include "core/planning/timed_motion.hpp"

#include "core/motion/quintic.hpp"

#include <algorithm>
#include <cmath>

namespace handover {
namespace {

using Eigen::Index;

/// A time, and the samples between which it lies; both the same before the path and after it.
struct Place {
  double t;
  std::size_t before, after;
};

Place placeAt(const TimedPath& path, double t) {
  const std::size_t last = path.t.size() - 1;
  if (t <= 0) return {t, 0, 0};
  if (t >= path.duration()) return {t, last, last};
  const auto after =
      static_cast<std::size_t>(std::upper_bound(path.t.begin(), path.t.end(), t) - path.t.begin());
  return {t, after - 1, after};
}

JointState sampleOf(const TimedPath& path, std::size_t i, Index j) {
  return {path.q[i][j], path.qd[i][j], path.qdd[i][j]};
}

JointState stateAt(const TimedPath& path, const Place& place, Index j) {
  const JointState before = sampleOf(path, place.before, j);
  if (place.before == place.after) return before;
  const double t = path.t[place.before];
  return Quintic(before, sampleOf(path, place.after, j), path.t[place.after] - t).at(place.t - t);
}

}  // namespace

void TimedMotion::fill(double from, double to, MotionIntervalRef out) const {
  const Index dof = joints();
  const double t_from = begin_ + from * (end_ - begin_), t_to = begin_ + to * (end_ - begin_);
  const double t_middle = 0.5 * (t_from + t_to), half = 0.5 * (t_to - t_from);
  // The path moves from `first` to `last` only.
  const Place first = placeAt(path_, std::clamp(t_from, 0.0, path_.duration()));
  const Place middle = placeAt(path_, t_middle);
  const Place last = placeAt(path_, std::clamp(t_to, first.t, path_.duration()));
  for (Index j = 0; j < dof; ++j) {
    const double q_middle = stateAt(path_, middle, j).q;
    JointState state = stateAt(path_, first, j);
    const JointState end = stateAt(path_, last, j);
    const double along = 0.5 * (end.q - state.q);
    double rest = 0;
    // A quintic stays within its control points, and so does what a line leaves of it.
    const auto take = [&](double t, double q) {
      const double x = half > 0 ? std::clamp((t - t_middle) / half, -1.0, 1.0) : 0.0;
      rest = std::max(rest, std::abs(q - x * along - q_middle));
    };
    take(t_from, state.q);
    take(t_to, end.q);
    double t = first.t;
    for (std::size_t i = first.before + 1; t < last.t; ++i) {
      const bool whole = i < last.after;
      const double t_next = whole ? path_.t[i] : last.t;
      const JointState next = whole ? sampleOf(path_, i, j) : end;
      const double fifth = 0.2 * (t_next - t);
      if (fifth > 0) {
        const std::array<double, 6> control = Quintic(state, next, t_next - t).controls();
        for (std::size_t k = 0; k < control.size(); ++k) {
          take(t + static_cast<double>(k) * fifth, control[k]);
        }
      }
      t = t_next;
      state = next;
    }
    out.q_middle[j] = q_middle;
    out.along[j] = along;
    out.rest[j] = rest;
  }
}

}  // namespace handover
