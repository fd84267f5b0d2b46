// SPDX-License-Identifier: Apache-2.0
#include "core/motion/segment.hpp"

#include <algorithm>
#include <cmath>

namespace handover {

namespace {

// The largest of a joint [rad].
double largestOf(const ArmVector& move) {
  return move.size() == 0 ? 0 : move.cwiseAbs().maxCoeff();
}

// False for NaN, too.
bool inBounds(const MotionProblem& problem, double largest) {
  return largest < 1e6 * problem.resolution;
}

}  // namespace

bool restOfSegmentValid(const MotionProblem& problem, const ArmVector& from, const ArmVector& to) {
  const ArmVector move = to - from;
  const double largest = largestOf(move);
  if (!inBounds(problem, largest) || !problem.valid(to)) return false;
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
  if (problem.valid_between)
    return inBounds(problem, largestOf(to - from)) && problem.valid_between(from, to);
  return from.allFinite() && problem.valid(from) && restOfSegmentValid(problem, from, to);
}

bool cornerValid(const MotionProblem& problem, const ArmVector& before, const ArmVector& corner,
                 const ArmVector& after) {
  if (problem.rounding <= 0) return true;
  const ArmVector in = corner - before, out = after - corner;
  const double length_in = in.norm(), length_out = out.norm();
  if (!(length_in > 0) || !(length_out > 0)) return true;
  const double turn = (out / length_out - in / length_in).norm();
  // As the timing does it: the parabola passes the corner at a distance of half * turn / 4, and
  // takes no more than half of a segment.
  double half = 0.5 * std::min(length_in, length_out);
  if (half * turn > 4 * problem.rounding) half = 4 * problem.rounding / turn;
  const ArmVector from = corner - half / length_in * in, to = corner + half / length_out * out;
  const ArmVector apex = 0.25 * (from + to) + 0.5 * corner;
  return segmentValid(problem, from, apex) && segmentValid(problem, apex, to);
}

}  // namespace handover
