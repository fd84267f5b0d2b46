// SPDX-License-Identifier: Apache-2.0
#include "core/grasp/thinning.hpp"

#include <algorithm>
#include <cmath>

namespace handover {
namespace {

constexpr double kMetresPerRadian = 0.08;
constexpr double kFar = 1e3;  // [m], before anything is chosen

double angleBetween(const Pose& a, const Pose& b) {
  return rotationAngle(a.linear().transpose() * b.linear());
}

double poseDistance(const Pose& a, const Pose& b) {
  return std::hypot((a.translation() - b.translation()).norm(),
                    kMetresPerRadian * angleBetween(a, b));
}

}  // namespace

bool tooClose(const Grasp& a, const Grasp& b, double spacing, double angle) {
  return (a.X_OT.translation() - b.X_OT.translation()).norm() < spacing &&
         angleBetween(a.X_OT, b.X_OT) < angle;
}

std::vector<Grasp> thin(const std::vector<Grasp>& grasps, int wanted) {
  if (static_cast<int>(grasps.size()) <= wanted) return grasps;
  std::vector<double> weight(grasps.size());
  std::vector<double> nearest(grasps.size(), kFar);
  std::vector<bool> chosen(grasps.size(), false);
  for (std::size_t i = 0; i < grasps.size(); ++i)
    weight[i] = std::sqrt(std::max(0.0, grasps[i].quality));
  for (int k = 0; k < wanted; ++k) {
    std::size_t best = grasps.size();
    for (std::size_t i = 0; i < grasps.size(); ++i) {
      if (chosen[i]) continue;
      if (best == grasps.size() || nearest[i] * weight[i] > nearest[best] * weight[best]) best = i;
    }
    chosen[best] = true;
    for (std::size_t i = 0; i < grasps.size(); ++i) {
      if (chosen[i]) continue;
      nearest[i] = std::min(nearest[i], poseDistance(grasps[i].X_OT, grasps[best].X_OT));
    }
  }
  std::vector<Grasp> kept;
  for (std::size_t i = 0; i < grasps.size(); ++i) {
    if (chosen[i]) kept.push_back(grasps[i]);
  }
  return kept;
}

}  // namespace handover
