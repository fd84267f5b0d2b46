// SPDX-License-Identifier: Apache-2.0
#include "core/kinematics/damped_least_squares.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <limits>

namespace handover::kinematics {
namespace {

constexpr int kPolishSteps = 10;
constexpr int kTrackSteps = 30;
constexpr int kDescendSteps = 30;  // 99 of 100 that arrive need at most 25
// Joints with at least this range [rad] turn freely while descending: held at their limits, half of
// the starts that would go round through the gap between these get stuck there.
constexpr double kFullTurn = 6.0;
// Small against the square of every singular value worth using: only keeps the factorisation alive.
constexpr double kFloor = 1e-13;

using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxJoints, kMaxJoints>;

/// The shortest dq that does `e` in the least-squares sense, damped.
ArmVector leastStep(const ArmJacobian& J, const Vector6& e, double damping) {
  if (J.cols() < 6) {
    Square H = J.transpose() * J;
    H.diagonal().array() += damping;
    const ArmVector g = J.transpose() * e;
    return H.llt().solve(g);
  }
  Eigen::Matrix<double, 6, 6> H = J * J.transpose();
  H.diagonal().array() += damping;
  const Vector6 y = H.llt().solve(e);
  return J.transpose() * y;
}

}  // namespace

bool polish(const Chain& chain, const Pose& X_AT, ArmVector& q) {
  // Far below the tolerance, so that answers repeat to the last places whatever the start was.
  constexpr double kGood = 1e-12;
  Vector6 error = poseError(X_AT, chain.toolPose(q));
  if (withinTolerance(error, kGood)) return true;
  ArmJacobian J;
  chain.toolPose(q, J);
  for (int step = 0; step < kPolishSteps; ++step) {
    const ArmVector next = q + leastStep(J, error, kFloor);
    const Vector6 next_error = poseError(X_AT, chain.toolPose(next, J));
    if (!(next_error.squaredNorm() < error.squaredNorm())) break;
    q = next;
    error = next_error;
    if (withinTolerance(error, kGood)) break;
  }
  return withinTolerance(error, kPoseTolerance);
}

bool track(const Chain& chain, const Pose& X_AT, const ArmVector& q_near, ArmVector& q) {
  constexpr double kLongestStep = 0.5;  // rad or m, of any joint
  constexpr double kSettled = 1e-7;
  const int n = chain.dofs();
  std::array<bool, kMaxJoints> locked{};
  q = q_near.cwiseMax(chain.lower).cwiseMin(chain.upper);
  ArmJacobian J;
  double moved = kLongestStep;
  for (int step = 0; step < kTrackSteps; ++step) {
    const Vector6 error = poseError(X_AT, chain.toolPose(q, J));
    // After a dozen steps along the null space what is left of its motion is of no use to anyone.
    if (withinTolerance(error, kPoseTolerance) && (moved < kSettled || step > 12)) return true;
    ArmVector back = q_near - q;
    for (int i = 0; i < n; ++i) {
      if (!locked[i]) continue;
      J.col(i).setZero();
      back[i] = 0;
    }
    const Vector6 rest = error - J * back;
    ArmVector dq = back + leastStep(J, rest, kFloor);
    const double longest = dq.cwiseAbs().maxCoeff();
    if (!std::isfinite(longest)) return false;
    if (longest > kLongestStep) dq *= kLongestStep / longest;
    const ArmVector next = (q + dq).cwiseMax(chain.lower).cwiseMin(chain.upper);
    for (int i = 0; i < n; ++i) {
      if (next[i] != q[i] + dq[i]) locked[i] = true;
    }
    moved = (next - q).cwiseAbs().maxCoeff();
    q = next;
  }
  return false;
}

bool descend(const Chain& chain, const Pose& X_AT, ArmVector& q) {
  constexpr double kLongestStep = 1.0;  // rad or m, of any joint
  constexpr double kSlow = 0.9;         // of the squared error left after a step
  constexpr int kMostSlow = 3;          // steps in a row
  const int n = chain.dofs();
  ArmVector lower = chain.lower, upper = chain.upper;
  for (int i = 0; i < n; ++i) {
    if (chain.prismatic(i) || upper[i] - lower[i] < kFullTurn) continue;
    lower[i] = -std::numeric_limits<double>::infinity();
    upper[i] = std::numeric_limits<double>::infinity();
  }
  ArmJacobian J;
  Vector6 error = poseError(X_AT, chain.toolPose(q, J));
  double factor = 1e-2;  // damping per squared error
  int slow = 0;
  for (int step = 0; step < kDescendSteps; ++step) {
    const double cost = error.squaredNorm();
    if (withinTolerance(error, kPoseTolerance)) return true;
    // Joints that the gradient pushes into their limit take no part in this step.
    const ArmVector gradient = J.transpose() * error;
    ArmJacobian free_J = J;
    for (int i = 0; i < n; ++i) {
      const bool pushed =
          (q[i] <= lower[i] && gradient[i] < 0) || (q[i] >= upper[i] && gradient[i] > 0);
      if (pushed) free_J.col(i).setZero();
    }
    ArmVector dq = leastStep(free_J, error, factor * cost + kFloor);
    const double longest = dq.cwiseAbs().maxCoeff();
    if (longest > kLongestStep) dq *= kLongestStep / longest;
    const ArmVector next = (q + dq).cwiseMax(lower).cwiseMin(upper);
    ArmJacobian next_J;
    const Vector6 next_error = poseError(X_AT, chain.toolPose(next, next_J));
    const double next_cost = next_error.squaredNorm();
    if (next_cost < cost) {
      slow = next_cost > kSlow * cost ? slow + 1 : 0;
      if (slow > kMostSlow) return false;
      q = next;
      J = next_J;
      error = next_error;
      factor = std::max(factor * 0.2, 1e-8);
    } else {
      factor *= 6;
      if (!(factor * cost < 1e4)) return false;
    }
  }
  return withinTolerance(error, kPoseTolerance);
}

}  // namespace handover::kinematics
