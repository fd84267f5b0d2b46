// SPDX-License-Identifier: Apache-2.0
#include "core/handover/timed_motion.hpp"

#include <algorithm>

namespace handover {

void TimedMotion::stretch(double from, double to, Eigen::VectorXd& q_middle,
                          Eigen::VectorXd& stray) const {
  const double t_from = begin_ + from * (end_ - begin_), t_to = begin_ + to * (end_ - begin_);
  evaluate(path_, 0.5 * (t_from + t_to), q_middle, qd_);
  stray.setZero(q_middle.size());
  // A cubic stays within its control points: its ends and a third of the way along its end slopes.
  double t = t_from;
  evaluate(path_, t, q_, qd_);
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
    stray = stray.cwiseMax((q_ - q_middle).cwiseAbs())
                .cwiseMax((q_ + third * qd_ - q_middle).cwiseAbs())
                .cwiseMax((q_end_ - third * qd_end_ - q_middle).cwiseAbs())
                .cwiseMax((q_end_ - q_middle).cwiseAbs());
    t = t_end;
    std::swap(q_, q_end_);
    std::swap(qd_, qd_end_);
  }
}

}  // namespace handover
