// SPDX-License-Identifier: Apache-2.0
// How far space is from a mesh's solid, on a grid of voxels.
#pragma once

#include "core/decomposition/convex_hull.hpp"

#include <handover/common/deadline.hpp>

#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

namespace handover::decomposition {

/// The solid of a mesh is its surface with everything that cannot be reached from outside without
/// passing through the surface, by steps of one voxel: the inside of a closed surface whichever
/// way its triangles are wound, the material between two walls, hidden cavities; not the cavity of
/// a cup. Openings narrower than about two voxels count as closed. An open sheet has no inside.
class SignedDistanceGrid {
 public:
  /// Cells that the grid of this box would have.
  static double cells(const Eigen::AlignedBox3d& box, double voxel);

  /// `reach` [m] is what holds() will tell. @pre 0.9 voxel < reach <= 4 voxel. Where the deadline
  /// is over afterwards, the grid is unfinished and says nothing.
  SignedDistanceGrid(const std::vector<std::array<Eigen::Vector3d, 3>>& triangles,
                     const Eigen::AlignedBox3d& box, double voxel, double reach,
                     const Deadline& deadline = {});

  double voxel() const { return voxel_; }

  /// True when no point of `hull` is farther than the reach from the solid; certain. False also
  /// when that cannot be told at this voxel size.
  bool holds(const Hull& hull) const;

  enum class Side { kOutside, kInside, kUnclear };

  /// Of the voxel's middle; unclear within half a voxel of the surface.
  Side side(const Eigen::Vector3i& cell) const;
  Eigen::Vector3i cellAt(const Eigen::Vector3d& p) const;
  Eigen::Vector3d middle(const Eigen::Vector3i& cell) const;

 private:
  void addTriangle(const std::array<Eigen::Vector3d, 3>& t);
  void addPiece(const std::array<Eigen::Vector3d, 3>& t);
  void turnInsideNegative(const Deadline& deadline);

  std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(size_.y()) +
            static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size_.x()) +
           static_cast<std::size_t>(x);
  }

  double voxel_;
  int most_;  ///< 1/24 voxel: middles farther from the solid may not lie in a hull that holds
  Eigen::Vector3d origin_;  ///< middle of cell (0, 0, 0)
  Eigen::Vector3i size_;
  /// Distance of the middles from the surface in 1/24 voxel, never too small; negative inside,
  /// never too deep.
  std::vector<std::int8_t> distance_;
};

}  // namespace handover::decomposition
