// SPDX-License-Identifier: Apache-2.0
// What can touch: a robot's link or an object, as FCL sees it.
#pragma once

#include "verify/geometry.hpp"
#include "verify/mesh.hpp"
#include "verify/pose.hpp"

#include <functional>
#include <memory>
#include <vector>

namespace handover::verify {

/// Reads the parts of a mesh that a geometry names.
using MeshSource = std::function<std::vector<Mesh>(const MeshFile&)>;

/// An immutable solid in its own frame. Boxes and meshes are triangles in one tree; spheres and
/// cylinders are kept as they are, beside triangles that enclose them and decide "apart" first.
class Body {
 public:
  Body(const std::vector<PlacedGeometry>& geometry, const MeshSource& meshes);
  ~Body();
  Body(Body&&) noexcept;
  Body& operator=(Body&&) noexcept;

  const Eigen::AlignedBox3d& box() const { return box_; }

  Eigen::Vector3d centre() const { return box_.center(); }

  double radius() const { return radius_; }  ///< about centre()

  const std::vector<Shell>& shells() const { return shells_; }

  struct Data;

  const Data& data() const { return *data_; }

 private:
  Eigen::AlignedBox3d box_;
  double radius_ = 0;
  std::vector<Shell> shells_;
  std::unique_ptr<const Data> data_;
};

struct Clearance {
  bool touching = false;  ///< surfaces meet, or one lies inside a closed part of the other
  /// Not touching: a lower bound of the distance, exact for boxes and meshes that are nearer than
  /// was asked for, less by the enclosing triangles for curved shapes (then it may be 0).
  double distance = 0;
};

/// Looks closer than boxes around the bodies only when those are nearer than `near`.
Clearance clearance(const Body& a, const Pose& X_WA, const Body& b, const Pose& X_WB, double near);

/// How deep the deepest of many points of one body's surface is in the other: never more than the
/// true depth, and less by about half a millimetre at most. Stops above `enough`.
double depthAtLeast(const Body& a, const Pose& X_WA, const Body& b, const Pose& X_WB,
                    double enough);

/// Whether moving `b` by `distance` in one of 26 directions parts the two.
bool partedBy(const Body& a, const Pose& X_WA, const Body& b, const Pose& X_WB, double distance);

}  // namespace handover::verify
