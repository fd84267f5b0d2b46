// SPDX-License-Identifier: Apache-2.0
// The part of a mesh's solid inside a box: the triangles cut to it, and the corners of the box
// that are inside.
#pragma once

#include "core/decomposition/signed_distance_grid.hpp"

#include <utility>
#include <vector>

namespace handover::decomposition {

using Triangle = std::array<Eigen::Vector3d, 3>;

/// The hull of the points is the hull of solid and box together: an extreme point of it lies on
/// the surface, or is a corner of the box.
class MeshPiece {
 public:
  /// The whole mesh.
  MeshPiece(std::vector<Triangle> triangles, const Eigen::AlignedBox3d& box);

  /// The parts below and above a plane across an axis of the box; a triangle in the plane goes
  /// below.
  std::pair<MeshPiece, MeshPiece> cut(int axis, double at) const;

  /// Empty where nothing of the solid is within.
  std::vector<Eigen::Vector3d> points(const SignedDistanceGrid& grid) const;

  /// Draws the box in to `box`, which holds everything.
  void shrink(const Eigen::AlignedBox3d& box) { box_ = box_.intersection(box); }

  const Eigen::AlignedBox3d& box() const { return box_; }

  const std::vector<Triangle>& triangles() const { return triangles_; }

 private:
  bool insideSolid(const Eigen::Vector3d& corner, const SignedDistanceGrid& grid) const;

  std::vector<Triangle> triangles_;
  Eigen::AlignedBox3d box_;
};

}  // namespace handover::decomposition
