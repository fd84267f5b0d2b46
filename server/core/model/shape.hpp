// SPDX-License-Identifier: Apache-2.0
// Convex collision shapes: what every geometry of a robot's link or of an object becomes when
// loaded.
#pragma once

#include <handover/common/pose.hpp>

#include <Eigen/Core>

#include <array>
#include <variant>
#include <vector>

namespace handover {

struct BoxShape {
  Eigen::Vector3d size;  ///< full edges [m]
};

struct SphereShape {
  double radius = 0;
};

struct CylinderShape {
  double radius = 0, length = 0;  ///< along z, centred
};

/// The convex hull of its vertices, with the outward triangles of that hull.
struct ConvexShape {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<int, 3>> triangles;
};

struct Shape {
  Pose X_BS = Pose::Identity();  ///< of the shape in its body (link or object) frame
  std::variant<BoxShape, SphereShape, CylinderShape, ConvexShape> geometry;
};

}  // namespace handover
