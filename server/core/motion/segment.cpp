// SPDX-License-Identifier: Apache-2.0
#include "core/motion/segment.hpp"

#include <cmath>

namespace handover {

bool restOfSegmentValid(const MotionProblem& problem, const ArmVector& from, const ArmVector& to) {
  const ArmVector move = to - from;
  const double largest = move.size() == 0 ? 0 : move.cwiseAbs().maxCoeff();
  if (!(largest < 1e6 * problem.resolution)) return false;  // catches NaN, too
  if (!problem.valid(to)) return false;
  if (problem.valid_between) return problem.valid_between(from, to);
  const int steps = static_cast<int>(std::ceil(largest / problem.resolution));
  // Bisection by levels: middle, quarters, eighths ... each inner point once.
  int stride = 1;
  while (stride < steps) stride *= 2;
  ArmVector q(from.size());
  for (; stride >= 2; stride /= 2) {
    for (int k = stride / 2; k < steps; k += stride) {
      q = from + (static_cast<double>(k) / steps) * move;
      if (!problem.valid(q)) return false;
    }
  }
  return true;
}

bool segmentValid(const MotionProblem& problem, const ArmVector& from, const ArmVector& to) {
  return from.allFinite() && problem.valid(from) && restOfSegmentValid(problem, from, to);
}

}  // namespace handover
