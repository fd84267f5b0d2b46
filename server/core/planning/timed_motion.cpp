// SPDX-License-Identifier: Apache-2.0
#include "core/planning/timed_motion.hpp"

#include <algorithm>

namespace handover {

void TimedMotion::stretch(double from, double to, MotionInterval& out) const {
  const double t_from = begin_ + from * (end_ - begin_), t_to = begin_ + to * (end_ - begin_);
  const double t_middle = 0.5 * (t_from + t_to), half = 0.5 * (t_to - t_from);
  evaluate(path_, t_middle, out.q_middle, qd_);
  evaluate(path_, t_to, q_end_, qd_end_);
  double t = t_from;
  evaluate(path_, t, q_, qd_);
  out.along = 0.5 * (q_end_ - q_);
  out.rest.setZero(q_.size());
  // A cubic stays within its control points, and so does what a line leaves of it.
  const auto take = [&](double at, const auto& control) {
    const double x = half > 0 ? std::clamp((at - t_middle) / half, -1.0, 1.0) : 0.0;
    out.rest = out.rest.cwiseMax((control - x * out.along - out.q_middle).cwiseAbs());
  };
  auto next = static_cast<std::size_t>(std::upper_bound(path_.t.begin(), path_.t.end(), t) -
                                       path_.t.begin());
  for (bool last = false; !last; ++next) {
    last = next >= path_.t.size() || path_.t[next] >= t_to;
    if (last) {
      evaluate(path_, t_to, q_end_, qd_end_);
    } else {
      q_end_ = path_.q[next];
      qd_end_ = path_.qd[next];
    }
    const double t_end = last ? t_to : path_.t[next], third = (t_end - t) / 3;
    take(t, q_);
    take(t + third, q_ + third * qd_);
    take(t_end - third, q_end_ - third * qd_end_);
    take(t_end, q_end_);
    t = t_end;
    std::swap(q_, q_end_);
    std::swap(qd_, qd_end_);
  }
}

}  // namespace handover
