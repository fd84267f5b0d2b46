// SPDX-License-Identifier: Apache-2.0
// Triangle meshes: read from files, made from primitives, and asked what is inside them.
#pragma once

#include "verify/geometry.hpp"
#include "verify/pose.hpp"

#include <array>
#include <filesystem>
#include <optional>
#include <vector>

namespace handover::verify {

using Triangle = std::array<int, 3>;

struct Mesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Triangle> triangles;

  void append(const Mesh& other);
  void transform(const Pose& X);
};

/// Every triangle of the file, one mesh for each of its parts (parts may share corners and still be
/// solids of their own; those of one node that only materials cut apart are one), node transforms
/// and units honoured, axes as in the file.
/// @throws Unreadable when it is no mesh or has no triangle.
std::vector<Mesh> readMesh(const std::filesystem::path& file, const Eigen::Vector3d& scale);

Mesh boxMesh(const Eigen::Vector3d& size);
/// Around the true shape, never inside it: off by 0.06 % of the radius.
Mesh cylinderMesh(double radius, double length);
/// Around the true shape, never inside it: off by at most 0.2 % of the radius.
Mesh sphereMesh(double radius);

/// A connected piece of a mesh, its vertices welded and its triangles turned outwards where it is
/// closed.
struct Shell {
  /// The sphere or cylinder that the triangles enclose.
  struct Round {
    Pose X_BS = Pose::Identity();
    double radius = 0;
    double length = 0;  ///< along z of S, centred; 0: a sphere
  };

  Mesh mesh;
  bool closed = false;  ///< every edge has exactly two triangles
  Eigen::AlignedBox3d box;
  std::optional<Round> round;

  /// Whether the point is in the solid that a closed shell bounds; false for an open one.
  bool contains(const Eigen::Vector3d& point) const;
  /// How far a point inside is from the surface. @pre contains(point).
  double depth(const Eigen::Vector3d& point) const;
  /// A point of the triangles moved onto the true surface, where that is round.
  Eigen::Vector3d onSurface(const Eigen::Vector3d& point) const;
  /// The outward normal of the true surface at a point of a triangle whose normal is given.
  Eigen::Vector3d normalAt(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const;
};

std::vector<Shell> shellsOf(const Mesh& mesh);

/// The point of the triangle that is nearest.
Eigen::Vector3d nearestOnTriangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                  const Eigen::Vector3d& b, const Eigen::Vector3d& c);

}  // namespace handover::verify
