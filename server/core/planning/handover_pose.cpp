// SPDX-License-Identifier: Apache-2.0
#include "core/planning/handover_pose.hpp"

#include <handover/common/plan_event.hpp>

#include <algorithm>
#include <cmath>

namespace handover {
namespace {

// A direction on the border of two bins counts to both, as planar arms have them [rad].
constexpr double kBesides = 0.01;

/// Calls visit(centre) for the lattice points within `radius` of the shoulders' midpoint.
template <typename Visit>
void forEachPoint(const PlacedMap& giver, const PlacedMap& receiver, double radius,
                  const Visit& visit) {
  const Eigen::Vector3d midpoint = 0.5 * (giver.p_WShoulder + receiver.p_WShoulder);
  const auto first = [&](int axis) {
    return static_cast<int>(std::floor((midpoint[axis] - radius) / kLatticeEdge));
  };
  const auto last = [&](int axis) {
    return static_cast<int>(std::floor((midpoint[axis] + radius) / kLatticeEdge));
  };
  for (int i = first(0); i <= last(0); ++i) {
    for (int j = first(1); j <= last(1); ++j) {
      for (int k = first(2); k <= last(2); ++k) {
        const Eigen::Vector3d centre =
            kLatticeEdge * (Eigen::Vector3d(i, j, k) + Eigen::Vector3d::Constant(0.5));
        if ((centre - midpoint).squaredNorm() <= radius * radius) visit(centre);
      }
    }
  }
}

/// Whether the predicate holds for the voxel of the point or one of the 26 round it.
template <typename Predicate>
bool anyVoxelNear(const PlacedMap& placed, const Eigen::Vector3d& p_W, const Predicate& holds) {
  const Eigen::Vector3d p_A = placed.X_WA.inverse() * p_W;
  for (int n = 0; n < 27; ++n) {
    const Eigen::Vector3i step(n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1);
    const ReachabilityVoxel* voxel =
        placed.map->find(p_A + placed.map->voxelSize() * step.cast<double>());
    if (voxel != nullptr && holds(*voxel)) return true;
  }
  return false;
}

}  // namespace

bool PlacedMap::near(const Eigen::Vector3d& p_W) const {
  return anyVoxelNear(*this, p_W, [](const ReachabilityVoxel&) { return true; });
}

std::uint64_t PlacedMap::binsNear(const Eigen::Vector3d& p_W) const {
  std::uint64_t bins = 0;
  anyVoxelNear(*this, p_W, [&](const ReachabilityVoxel& voxel) {
    bins |= voxel.directions;
    return false;
  });
  return bins;
}

std::uint64_t PlacedMap::binsOf(const Eigen::Vector3d& approach_W) const {
  const Eigen::Vector3d approach_A = X_WA.linear().transpose() * approach_W;
  const Eigen::Vector3d u = kBesides * approach_A.unitOrthogonal();
  const Eigen::Vector3d v = approach_A.cross(u);
  std::uint64_t bins = 0;
  for (const Eigen::Vector3d& beside :
       {Eigen::Vector3d::Zero().eval(), u, v, (-u).eval(), (-v).eval()}) {
    bins |= std::uint64_t{1} << directionBin((approach_A + beside).normalized());
  }
  return bins;
}

bool PlacedMap::near(const Eigen::Vector3d& p_W, const Eigen::Vector3d& approach_W) const {
  const std::uint64_t bins = binsOf(approach_W);
  return anyVoxelNear(*this, p_W, [bins](const ReachabilityVoxel& voxel) {
    return (voxel.directions & bins) != 0;
  });
}

std::vector<LatticePoint> crossMaps(const PlacedMap& giver, const PlacedMap& receiver,
                                    double radius) {
  std::vector<LatticePoint> points;
  forEachPoint(giver, receiver, radius, [&](const Eigen::Vector3d& centre) {
    const double by_giver = giver(centre);
    if (by_giver <= 0) return;
    const double by_receiver = receiver(centre);
    if (by_receiver <= 0) return;
    points.push_back({centre, 0.5 * (by_giver + by_receiver)});
  });
  std::stable_sort(points.begin(), points.end(), [](const LatticePoint& a, const LatticePoint& b) {
    return a.manipulability > b.manipulability;
  });
  return points;
}

std::vector<LatticePoint> receiverPoints(const PlacedMap& giver, const PlacedMap& receiver,
                                         double radius, double reach_g) {
  std::vector<LatticePoint> points;
  forEachPoint(giver, receiver, radius, [&](const Eigen::Vector3d& centre) {
    if (giver(centre) > 0 && receiver(centre) > 0) return;
    if ((centre - giver.X_WA.translation()).norm() > reach_g) return;
    if (receiver.near(centre)) points.push_back({centre, 0});
  });
  return points;
}

namespace {

/// The tilt that an offset asks for.
Eigen::AngleAxisd tiltOf(const Eigen::Vector3d& z_shoulder, const ApproachOffset& offset) {
  const Eigen::Vector3d across =
      Eigen::AngleAxisd(offset.azimuth, z_shoulder) * z_shoulder.unitOrthogonal();
  return Eigen::AngleAxisd(offset.tilt, across);
}

}  // namespace

Eigen::Vector3d handoverApproach(const Eigen::Vector3d& p_WShoulder_giver,
                                 const Eigen::Vector3d& p_WShoulder_receiver,
                                 const ApproachOffset& offset) {
  const Eigen::Vector3d z_shoulder = (p_WShoulder_giver - p_WShoulder_receiver).normalized();
  return offset.tilt == 0 ? z_shoulder : tiltOf(z_shoulder, offset) * z_shoulder;
}

Eigen::Matrix3d handoverRotation(const Eigen::Matrix3d& R_WT_goal,
                                 const Eigen::Vector3d& approach_T,
                                 const Eigen::Vector3d& p_WShoulder_giver,
                                 const Eigen::Vector3d& p_WShoulder_receiver,
                                 const ApproachOffset& offset) {
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
  Eigen::Matrix3d R_turned =
      Eigen::AngleAxisd(offset.turn, z_shoulder).toRotationMatrix() * R_least * R_WT_goal;
  if (offset.tilt == 0) return R_turned;
  return tiltOf(z_shoulder, offset).toRotationMatrix() * R_turned;
}

}  // namespace handover
