// SPDX-License-Identifier: Apache-2.0
// Random convex shapes and poses for the collision tests, the same ones for the same seed.
#pragma once

#include "core/model/shape.hpp"

#include <cstdint>
#include <random>

namespace handover::test {

class RandomShapes {
 public:
  explicit RandomShapes(std::uint64_t seed) : random_(seed) {}

  double uniform(double lower, double upper);
  Eigen::Vector3d direction();
  Pose pose(double reach);
  BoxShape box();
  SphereShape sphere();
  CylinderShape cylinder();
  /// A closed hull of 4 to 24 random vertices, with its outward triangles.
  ConvexShape hull();
  /// Any of them, X_BS = identity.
  Shape any();

 private:
  std::mt19937_64 random_;
};

/// The outward triangles of the hull of points in general position.
std::vector<std::array<int, 3>> hullTriangles(const std::vector<Eigen::Vector3d>& points);

}  // namespace handover::test
