// SPDX-License-Identifier: Apache-2.0
#include "core/kinematics/joint_revolutions.hpp"

#include <algorithm>

namespace handover::kinematics {
namespace {

constexpr double kSlack = 1e-9;

/// Copies beyond these are of no use, and limits of 1e6 turns must not make as many answers.
constexpr double kMostCopies = 64;

}  // namespace

CopiesTaken forEachEquivalent(const Chain& chain, const IkQuery& query, const ArmVector& q_near,
                              const ArmVector& q, const ArmKinematics::Take& take) {
  const int n = chain.dofs();
  std::array<Windings, kMaxJoints> w;
  for (int i = 0; i < n; ++i) {
    if (chain.prismatic(i)) {
      const bool inside = q[i] >= chain.lower[i] - kSlack && q[i] <= chain.upper[i] + kSlack;
      w[i] = inside ? Windings{0, 0} : Windings{};
    } else {
      w[i] = windings(q[i], chain.lower[i], chain.upper[i], kSlack);
    }
    if (w[i].none()) return {};
    const double nearest =
        std::clamp(std::nearbyint((q_near[i] - q[i]) / kTurn), w[i].first, w[i].last);
    if (chain.prismatic(i) || !query.all_windings) {
      w[i].first = w[i].last = chain.prismatic(i) ? 0 : nearest;
    } else {
      w[i].first = std::max(w[i].first, nearest - kMostCopies);
      w[i].last = std::min(w[i].last, nearest + kMostCopies);
    }
  }

  CopiesTaken taken;
  std::array<double, kMaxJoints> turns{};
  for (int i = 0; i < n; ++i) turns[i] = w[i].first;
  for (int joint = n - 1; joint >= 0;) {
    ArmVector copy = q;
    for (int i = 0; i < n; ++i) copy[i] += kTurn * turns[i];
    copy = copy.cwiseMax(chain.lower).cwiseMin(chain.upper);
    ++taken.count;
    if (!take(copy)) {
      taken.go_on = false;
      break;
    }
    for (joint = n - 1; joint >= 0; --joint) {
      if (++turns[joint] <= w[joint].last) break;
      turns[joint] = w[joint].first;
    }
  }
  return taken;
}

}  // namespace handover::kinematics
