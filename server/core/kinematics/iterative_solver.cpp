// SPDX-License-Identifier: Apache-2.0
#include "core/kinematics/iterative_solver.hpp"

#include "core/kinematics/damped_least_squares.hpp"
#include "core/kinematics/joint_revolutions.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace handover::kinematics {
namespace {

constexpr std::size_t kTable = 4096;
constexpr int kStartsPerSample = 2;  // of the query's swivel samples: then as many answers come
constexpr double kSame = 0.01;       // answers nearer than this in every joint are one [rad or m]
// Part of the reach that counts as much as a radian: measured on arms of six and seven joints, and
// flat about it.
constexpr double kRadian = 0.3;

/// Position over `length`, then the quaternion.
std::array<float, 7> numbersOf(const Pose& X, double length) {
  const Eigen::Vector3d p = X.translation() / length;
  const Eigen::Quaterniond quat(X.linear());
  std::array<float, 7> numbers{};
  for (int i = 0; i < 3; ++i) numbers[static_cast<std::size_t>(i)] = static_cast<float>(p[i]);
  for (int i = 0; i < 4; ++i) {
    numbers[static_cast<std::size_t>(i) + 3] = static_cast<float>(quat.coeffs()[i]);
  }
  return numbers;
}

/// Whole turns of turning joints aside.
bool alreadyFound(const Chain& chain, const std::vector<ArmVector>& found, const ArmVector& q) {
  return std::any_of(found.begin(), found.end(), [&](const ArmVector& other) {
    for (int i = 0; i < chain.dofs(); ++i) {
      double apart = q[i] - other[i];
      if (!chain.prismatic(i)) apart -= kTurn * std::nearbyint(apart / kTurn);
      if (std::abs(apart) >= kSame) return false;
    }
    return true;
  });
}

}  // namespace

IterativeSolver::IterativeSolver(const Chain& chain) {
  std::mt19937_64 generator(20141118);
  std::vector<Pose> X_AT;
  double farthest = 0;
  for (std::size_t k = 0; k < kTable; ++k) {
    ArmVector q(chain.dofs());
    for (int i = 0; i < chain.dofs(); ++i) {
      // 53-bit fractions of the generator, the same everywhere.
      const double fraction = static_cast<double>(generator() >> 11) * 0x1p-53;
      q[i] = chain.lower[i] + fraction * (chain.upper[i] - chain.lower[i]);
    }
    X_AT.push_back(chain.toolPose(q));
    farthest = std::max(farthest, X_AT.back().translation().norm());
    configurations_.push_back(std::move(q));
  }
  length_ = std::max(kRadian * farthest, 1e-6);
  for (const Pose& X : X_AT) {
    const auto numbers = numbersOf(X, length_);
    for (std::size_t i = 0; i < numbers.size(); ++i) poses_[i].push_back(numbers[i]);
  }
}

std::vector<int> IterativeSolver::nearest(const Pose& X_AT, std::size_t count) const {
  const auto wanted = numbersOf(X_AT, length_);
  std::array<float, kTable> distance;
  for (std::size_t k = 0; k < kTable; ++k) {
    float squared = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const float d = poses_[i][k] - wanted[i];
      squared += d * d;
    }
    float cosine = 0;  // of half the angle between the rotations
    for (std::size_t i = 3; i < 7; ++i) cosine += poses_[i][k] * wanted[i];
    distance[k] = squared + 4 * (1 - cosine * cosine);
  }
  std::vector<int> order(kTable);
  for (std::size_t k = 0; k < kTable; ++k) order[k] = static_cast<int>(k);
  count = std::min(count, kTable);
  const auto middle = order.begin() + static_cast<std::ptrdiff_t>(count);
  std::partial_sort(order.begin(), middle, order.end(), [&](int a, int b) {
    const float d_a = distance[static_cast<std::size_t>(a)];
    const float d_b = distance[static_cast<std::size_t>(b)];
    return d_a != d_b ? d_a < d_b : a < b;
  });
  order.resize(count);
  return order;
}

IkCounts IterativeSolver::visit(const Chain& chain, const Pose& X_AT, const IkQuery& query,
                                const ArmVector& q_near, const ArmKinematics::Take& take) const {
  IkCounts counts;
  if (X_AT.translation().norm() > chain.reach() + 1e-9) {
    counts.no_ik = 1;
    return counts;
  }
  std::vector<ArmVector> found;
  /// False when the caller has had enough.
  const auto start = [&](ArmVector q) {
    if (!descend(chain, X_AT, q)) {
      ++counts.no_ik;
      return true;
    }
    if (alreadyFound(chain, found, q)) return true;
    found.push_back(q);
    const CopiesTaken taken = forEachEquivalent(chain, query, q_near, q, take);
    counts.solutions += static_cast<std::uint32_t>(taken.count);
    if (taken.count == 0) ++counts.limits;
    return taken.go_on;
  };
  const int starts = kStartsPerSample * query.swivel_samples;
  if (starts <= 0 || !start(q_near.cwiseMax(chain.lower).cwiseMin(chain.upper))) return counts;
  for (const int k : nearest(X_AT, static_cast<std::size_t>(starts - 1))) {
    if (!start(configurations_[static_cast<std::size_t>(k)])) break;
  }
  return counts;
}

}  // namespace handover::kinematics
