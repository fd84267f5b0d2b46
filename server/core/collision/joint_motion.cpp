// SPDX-License-Identifier: Apache-2.0
#include "core/collision/joint_motion.hpp"

#include <algorithm>
#include <cmath>

namespace handover {

void PolylineMotion::stretch(double from, double to, Eigen::VectorXd& q_middle,
                             Eigen::VectorXd& stray) const {
  const Eigen::Index segments = waypoints_.cols() - 1;
  const auto at = [&](double s, Eigen::VectorXd& q) {
    const double place = s * static_cast<double>(segments);
    const auto before =
        std::min(static_cast<Eigen::Index>(place), std::max<Eigen::Index>(segments - 1, 0));
    if (segments == 0) {
      q = waypoints_.col(0);
    } else {
      const double fraction = place - static_cast<double>(before);
      q = waypoints_.col(before) + fraction * (waypoints_.col(before + 1) - waypoints_.col(before));
    }
  };
  at(0.5 * (from + to), q_middle);
  if (segments == 0) {
    stray.setZero(q_middle.size());
    return;
  }
  // Between corners the curve strays most at an end or at a corner.
  const auto take = [&](double s) {
    const double place = s * static_cast<double>(segments);
    const auto before = std::min(static_cast<Eigen::Index>(place), segments - 1);
    const double fraction = place - static_cast<double>(before);
    stray =
        stray.cwiseMax((waypoints_.col(before) +
                        fraction * (waypoints_.col(before + 1) - waypoints_.col(before)) - q_middle)
                           .cwiseAbs());
  };
  stray.setZero(q_middle.size());
  take(from);
  take(to);
  const auto first = static_cast<Eigen::Index>(std::ceil(from * static_cast<double>(segments)));
  const auto last = static_cast<Eigen::Index>(std::floor(to * static_cast<double>(segments)));
  for (Eigen::Index i = std::max<Eigen::Index>(first, 0); i <= std::min(last, segments); ++i) {
    stray = stray.cwiseMax((waypoints_.col(i) - q_middle).cwiseAbs());
  }
}

void BothMotions::stretch(double from, double to, Eigen::VectorXd& q_middle,
                          Eigen::VectorXd& stray) const {
  first_.stretch(from, to, q_first_, stray_first_);
  second_.stretch(from, to, q_second_, stray_second_);
  q_middle.resize(q_first_.size() + q_second_.size());
  q_middle << q_first_, q_second_;
  stray.resize(q_middle.size());
  stray << stray_first_, stray_second_;
}

}  // namespace handover
