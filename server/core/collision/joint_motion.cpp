// SPDX-License-Identifier: Apache-2.0
#include "core/collision/joint_motion.hpp"

#include <algorithm>
#include <cmath>

namespace handover {

void PolylineMotion::stretch(double from, double to, MotionInterval& out) const {
  const Eigen::Index segments = waypoints_.cols() - 1;
  if (segments == 0) {
    out.q_middle = waypoints_.col(0);
    out.along.setZero(out.q_middle.size());
    out.rest.setZero(out.q_middle.size());
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

void BothMotions::stretch(double from, double to, MotionInterval& out) const {
  first_.stretch(from, to, of_first_);
  second_.stretch(from, to, of_second_);
  const Eigen::Index size = of_first_.q_middle.size() + of_second_.q_middle.size();
  out.q_middle.resize(size);
  out.q_middle << of_first_.q_middle, of_second_.q_middle;
  out.along.resize(size);
  out.along << of_first_.along, of_second_.along;
  out.rest.resize(size);
  out.rest << of_first_.rest, of_second_.rest;
}

}  // namespace handover
