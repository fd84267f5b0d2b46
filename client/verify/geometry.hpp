// SPDX-License-Identifier: Apache-2.0
// Geometry as the plan file and URDF collision elements describe it.
#pragma once

#include "verify/pose.hpp"

#include <string>
#include <variant>
#include <vector>

namespace handover::verify {

struct Box {
  Eigen::Vector3d size;  ///< full edges [m]
};

struct Sphere {
  double radius;
};

struct Cylinder {
  double radius, length;  ///< along z, centred
};

struct MeshFile {
  std::string path;  ///< plan file: relative to the root; URDF: as written there
  Eigen::Vector3d scale;
};

struct PlacedGeometry;

struct Compound {
  std::vector<PlacedGeometry> parts;
};

using Geometry = std::variant<Box, Sphere, Cylinder, MeshFile, Compound>;

struct PlacedGeometry {
  Pose X_BS = Pose::Identity();  ///< of the shape in its body's frame
  Geometry geometry;
};

}  // namespace handover::verify
