// SPDX-License-Identifier: Apache-2.0
// The true surface of a link or an object, where convex parts only approach it.
#pragma once

#include "core/collision/collision_scene.hpp"
#include "core/collision/gjk.hpp"
#include "core/model/body_shapes.hpp"

#include <Eigen/Geometry>

#include <functional>
#include <optional>
#include <vector>

namespace handover {

/// Shapes that meet a body's surface exactly, and the triangles of its divided bodies, in a
/// hierarchy of boxes. In the body's frame B. Immutable; safe from any thread.
class SurfaceTree {
 public:
  struct Piece {
    RoundedCore rounded;
    int shape = -1;     ///< index in shapes(); -1: a triangle
    int body = -1;      ///< of the triangle: index in the divided bodies
    int triangle = -1;  ///< index in its body's surface
  };

  /// @param divided  of `shapes`; null: none.
  explicit SurfaceTree(const std::vector<Shape>& shapes, const DividedBodies* divided = nullptr);

  /// Those that meet the surface exactly.
  const std::vector<Shape>& shapes() const { return shapes_; }

  /// Distance of two surfaces up to `max`; nullopt if they are farther apart. 0 where they meet;
  /// what is wholly inside a divided body is as far from it as from its surface.
  static std::optional<BodyDistance> distance(const SurfaceTree& a, const Pose& X_WA,
                                              const SurfaceTree& b, const Pose& X_WB, double max);

  /// Calls visit(piece of a, piece of b, their distance) for every pair within `reach`.
  using NearVisit = std::function<void(const Piece&, const Piece&, const BodyDistance&)>;
  static void forEachNear(const SurfaceTree& a, const Pose& X_WA, const SurfaceTree& b,
                          const Pose& X_WB, double reach, const NearVisit& visit);

  /// Calls visit(triangle, share of the way) for every triangle that the way from `from` to `to`
  /// passes through, in no order.
  using CrossingVisit = std::function<void(const Piece&, double)>;
  void forEachCrossing(const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                       const CrossingVisit& visit) const;

 private:
  struct Node {
    Eigen::Vector3d middle, half;  ///< of its box
    int left = -1, right = -1;     ///< nodes
    int piece = -1;                ///< of a leaf
  };

  class Pair;

  int build(std::vector<int>& order, int first, int end, const std::vector<Node>& leaves);
  Pose poseOf(const Piece& piece, const Pose& X_WB) const;

  std::vector<Shape> shapes_;
  std::vector<Piece> pieces_;
  std::vector<Node> nodes_;
  int root_ = -1;
};

/// The outward normal of a triangle; zero for one of no area.
Eigen::Vector3d normalOf(const TriangleMesh& mesh, int triangle);

}  // namespace handover
