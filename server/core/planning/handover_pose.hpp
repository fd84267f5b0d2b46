// SPDX-License-Identifier: Apache-2.0
// Where in space the object changes hands ([paper] §IV-B, Alg. 3 GetHandoverPose).
#pragma once

#include "core/reachability/reachability_map.hpp"

#include <handover/common/pose.hpp>

#include <vector>

namespace handover {

/// An arm's map placed in the world.
struct PlacedMap {
  const ReachabilityMap* map = nullptr;
  Pose X_WA = Pose::Identity();
  Eigen::Vector3d p_WShoulder = Eigen::Vector3d::Zero();

  /// The map's entry at a world point; 0 = not reached.
  double operator()(const Eigen::Vector3d& p_W) const { return (*map)(X_WA.inverse() * p_W); }

  /// True when the voxel of the point, or one of the 26 round it, is reached.
  bool near(const Eigen::Vector3d& p_W) const;
  /// And with the tool's approach axis in the same of the map's 64 bins, or one next to it if it
  /// lies on the border. Of the poses that an arm reaches 0.4 % at most are missed, of those that
  /// it does not reach 9 in 10 are told.
  bool near(const Eigen::Vector3d& p_W, const Eigen::Vector3d& approach_W) const;

  /// The two halves of that, for many directions at one point: they have a bit in common.
  /// The bins that the voxels of the point and round it were reached with.
  std::uint64_t binsNear(const Eigen::Vector3d& p_W) const;
  /// The bins of a direction: its own, and those next to it if it lies on the border.
  std::uint64_t binsOf(const Eigen::Vector3d& approach_W) const;
};

/// A point of the world lattice that both arms reach.
struct LatticePoint {
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
  double manipulability = 0;  ///< mean of both maps' entries
};

/// Lattice points (cells of kLatticeEdge anchored at the world's origin, their centres) within
/// `radius` of the shoulders' midpoint that both arms reach: best mean manipulability first, ties
/// by lattice index.
std::vector<LatticePoint> crossMaps(const PlacedMap& giver, const PlacedMap& receiver,
                                    double radius);

/// The other lattice points within `radius` of the midpoint where the receiver's tool can be: it
/// reaches their voxel or one next to it (maps have holes where few samples fell). The giver has to
/// come only as near as `reach_g` [m], as the object lies between the hands. By rising lattice
/// index; manipulability 0.
std::vector<LatticePoint> receiverPoints(const PlacedMap& giver, const PlacedMap& receiver,
                                         double radius, double reach_g);

/// From the paper's orientation [rad]: first a turn about z_shoulder; then the approach axis is
/// tilted away from z_shoulder, in the direction that the azimuth chooses.
struct ApproachOffset {
  double turn = 0, tilt = 0, azimuth = 0;
};

/// The receiver's approach axis at the handover, whatever its grasp: z_shoulder with the offset's
/// tilt.
Eigen::Vector3d handoverApproach(const Eigen::Vector3d& p_WShoulder_giver,
                                 const Eigen::Vector3d& p_WShoulder_receiver,
                                 const ApproachOffset& offset);

/// The receiver's hand orientation at the handover: the least rotation that turns its approach axis
/// at the goal, R_WT_goal * approach_T, onto z_shoulder = giver's - receiver's shoulder; if
/// antiparallel, half a turn about the hand's x axis. Then the offset from it, if any.
/// @pre approach_T unit; the shoulders differ.
Eigen::Matrix3d handoverRotation(const Eigen::Matrix3d& R_WT_goal,
                                 const Eigen::Vector3d& approach_T,
                                 const Eigen::Vector3d& p_WShoulder_giver,
                                 const Eigen::Vector3d& p_WShoulder_receiver,
                                 const ApproachOffset& offset = {});

}  // namespace handover
