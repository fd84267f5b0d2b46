// SPDX-License-Identifier: Apache-2.0
#include "core/collision/joint_motion.hpp"

#include <algorithm>
#include <cmath>

namespace handover {

void JointMotion::stretch(double from, double to, MotionInterval& out) const {
  const Eigen::Index size = joints();
  out.q_middle.resize(size);
  out.along.resize(size);
  out.rest.resize(size);
  fill(from, to, {out.q_middle, out.along, out.rest});
}

void PolylineMotion::fill(double from, double to, MotionIntervalRef out) const {
  const Eigen::Index segments = waypoints_.cols() - 1;
  if (segments == 0) {
    out.q_middle = waypoints_.col(0);
    out.along.setZero();
    out.rest.setZero();
    return;
  }
  const auto at = [&](double s) {
    const double place = s * static_cast<double>(segments);
    const auto before = std::min(static_cast<Eigen::Index>(place), segments - 1);
    const double fraction = place - static_cast<double>(before);
    return waypoints_.col(before) +
           fraction * (waypoints_.col(before + 1) - waypoints_.col(before));
  };
  const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
  out.q_middle = at(middle);
  out.along = 0.5 * (at(to) - at(from));
  // Between corners the curve is farthest from a line at an end or at a corner.
  out.rest = (at(from) + out.along - out.q_middle)
                 .cwiseAbs()
                 .cwiseMax((at(to) - out.along - out.q_middle).cwiseAbs());
  const auto first = static_cast<Eigen::Index>(std::ceil(from * static_cast<double>(segments)));
  const auto last = static_cast<Eigen::Index>(std::floor(to * static_cast<double>(segments)));
  for (Eigen::Index i = std::max<Eigen::Index>(first, 0); i <= std::min(last, segments); ++i) {
    const double s = static_cast<double>(i) / static_cast<double>(segments);
    const double x = half > 0 ? std::clamp((s - middle) / half, -1.0, 1.0) : 0.0;
    out.rest = out.rest.cwiseMax((waypoints_.col(i) - x * out.along - out.q_middle).cwiseAbs());
  }
}

void BothMotions::fill(double from, double to, MotionIntervalRef out) const {
  const Eigen::Index before = first_.joints(), after = second_.joints();
  first_.fill(from, to, {out.q_middle.head(before), out.along.head(before), out.rest.head(before)});
  second_.fill(from, to, {out.q_middle.tail(after), out.along.tail(after), out.rest.tail(after)});
}

}  // namespace handover
