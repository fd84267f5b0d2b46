// SPDX-License-Identifier: Apache-2.0
#include "core/handover/handover_pose.hpp"

#include <algorithm>
#include <cmath>

namespace handover {
namespace {

constexpr double kLatticeEdge = 0.05;  // [m], design §7

}  // namespace

std::vector<LatticePoint> crossMaps(const PlacedMap& giver, const PlacedMap& receiver,
                                    double radius) {
  const Eigen::Vector3d midpoint = 0.5 * (giver.p_WShoulder + receiver.p_WShoulder);
  const auto first = [&](int axis) {
    return static_cast<int>(std::floor((midpoint[axis] - radius) / kLatticeEdge));
  };
  const auto last = [&](int axis) {
    return static_cast<int>(std::floor((midpoint[axis] + radius) / kLatticeEdge));
  };
  std::vector<LatticePoint> points;
  for (int i = first(0); i <= last(0); ++i) {
    for (int j = first(1); j <= last(1); ++j) {
      for (int k = first(2); k <= last(2); ++k) {
        const Eigen::Vector3d centre =
            kLatticeEdge * (Eigen::Vector3d(i, j, k) + Eigen::Vector3d::Constant(0.5));
        if ((centre - midpoint).squaredNorm() > radius * radius) continue;
        const double by_giver = giver(centre);
        if (by_giver <= 0) continue;
        const double by_receiver = receiver(centre);
        if (by_receiver <= 0) continue;
        points.push_back({centre, 0.5 * (by_giver + by_receiver)});
      }
    }
  }
  std::stable_sort(points.begin(), points.end(), [](const LatticePoint& a, const LatticePoint& b) {
    return a.manipulability > b.manipulability;
  });
  return points;
}

Eigen::Matrix3d handoverRotation(const Eigen::Matrix3d& R_WT_goal,
                                 const Eigen::Vector3d& approach_T,
                                 const Eigen::Vector3d& p_WShoulder_giver,
                                 const Eigen::Vector3d& p_WShoulder_receiver, double turn) {
  const Eigen::Vector3d approach_W = R_WT_goal * approach_T;
  const Eigen::Vector3d z_shoulder = (p_WShoulder_giver - p_WShoulder_receiver).normalized();
  const Eigen::Vector3d axis = approach_W.cross(z_shoulder);
  const double sine = axis.norm();
  const double cosine = approach_W.dot(z_shoulder);
  Eigen::Matrix3d R_least = Eigen::Matrix3d::Identity();
  if (sine > 1e-9) {
    R_least = Eigen::AngleAxisd(std::atan2(sine, cosine), axis / sine).toRotationMatrix();
  } else if (cosine < 0) {
    R_least = Eigen::AngleAxisd(M_PI, R_WT_goal.col(0)).toRotationMatrix();
  }
  return Eigen::AngleAxisd(turn, z_shoulder).toRotationMatrix() * R_least * R_WT_goal;
}

}  // namespace handover
