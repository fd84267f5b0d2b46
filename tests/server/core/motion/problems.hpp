// SPDX-License-Identifier: Apache-2.0
// Planning problems without a robot: joint spaces with known obstacles.
#pragma once

#include "core/motion/ikbirrt.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>

namespace handover::test {

inline ArmVector joints(std::initializer_list<double> values) {
  ArmVector q(static_cast<Eigen::Index>(values.size()));
  Eigen::Index j = 0;
  for (const double v : values) q[j++] = v;
  return q;
}

inline MotionProblem emptyProblem(int dofs) {
  MotionProblem problem;
  problem.lower = ArmVector::Constant(dofs, -3);
  problem.upper = ArmVector::Constant(dofs, 3);
  problem.valid = [](const ArmVector&) { return true; };
  return problem;
}

/// Wall of 0.4 at q0 = 0 with one hole of +-`hole` in all other joints.
inline MotionProblem wallProblem(int dofs, double hole) {
  MotionProblem problem = emptyProblem(dofs);
  problem.valid = [hole](const ArmVector& q) {
    if (std::abs(q[0]) > 0.2) return true;
    for (int j = 1; j < q.size(); ++j) {
      if (std::abs(q[j] - 0.5) > hole) return false;
    }
    return true;
  };
  return problem;
}

/// Planar arm of seven links of 0.2 m from the origin among three discs; links have their own
/// width.
class DiscWorld {
 public:
  static MotionProblem problem(double margin = 0) {
    MotionProblem problem = emptyProblem(7);
    problem.valid = [margin](const ArmVector& q) { return clearance(q) > margin; };
    return problem;
  }

  static double clearance(const ArmVector& q) {
    static constexpr std::array<std::array<double, 3>, 3> discs{
        {{0.6, 0.45, 0.2}, {0.55, -0.55, 0.25}, {-0.5, 0.5, 0.25}}};
    double least = 1e9, x = 0, y = 0, angle = 0;
    for (int j = 0; j < q.size(); ++j) {
      angle += q[j];
      const double nx = x + 0.2 * std::cos(angle), ny = y + 0.2 * std::sin(angle);
      for (const auto& disc : discs) {
        const double s =
            std::clamp(((disc[0] - x) * (nx - x) + (disc[1] - y) * (ny - y)) / 0.04, 0.0, 1.0);
        const double dx = x + s * (nx - x) - disc[0], dy = y + s * (ny - y) - disc[1];
        least = std::min(least, std::sqrt(dx * dx + dy * dy) - disc[2] - 0.02);
      }
      x = nx, y = ny;
    }
    return least;
  }
};

inline double length(const JointPath& path) {
  double sum = 0;
  for (std::size_t i = 0; i + 1 < path.waypoints.size(); ++i) {
    sum += (path.waypoints[i + 1] - path.waypoints[i]).norm();
  }
  return sum;
}

/// Every segment in turn, at `resolution`, by a plain walk.
inline bool pathValid(const MotionProblem& problem, const JointPath& path, double resolution) {
  for (std::size_t i = 0; i + 1 < path.waypoints.size(); ++i) {
    const ArmVector move = path.waypoints[i + 1] - path.waypoints[i];
    const int steps =
        std::max(1, static_cast<int>(std::ceil(move.cwiseAbs().maxCoeff() / resolution)));
    for (int k = 0; k <= steps; ++k) {
      const ArmVector q = path.waypoints[i] + static_cast<double>(k) / steps * move;
      if (!problem.valid(q)) return false;
    }
  }
  return !path.waypoints.empty() && problem.valid(path.waypoints[0]);
}

}  // namespace handover::test
