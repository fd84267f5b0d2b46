// SPDX-License-Identifier: Apache-2.0
// Geometry of an object as cell files, the wire and the plan file describe it.
#pragma once

#include <handover/common/pose.hpp>

#include <array>
#include <string>
#include <variant>
#include <vector>

namespace handover {

struct BoxGeometry {
  std::array<double, 3> size{};  ///< full edges [m]
  bool operator==(const BoxGeometry&) const = default;
};

struct SphereGeometry {
  double radius = 0;  ///< [m]
  bool operator==(const SphereGeometry&) const = default;
};

struct CylinderGeometry {
  double radius = 0;  ///< [m]
  double length = 0;  ///< [m], along z, centred
  bool operator==(const CylinderGeometry&) const = default;
};

struct MeshGeometry {
  std::string path;  ///< relative to the root of the installed share or of the repository
  std::array<double, 3> scale{1, 1, 1};
  bool operator==(const MeshGeometry&) const = default;
};

struct GeometryPart;

struct CompoundGeometry {
  std::vector<GeometryPart> parts;
  bool operator==(const CompoundGeometry&) const;
};

using Geometry =
    std::variant<BoxGeometry, SphereGeometry, CylinderGeometry, MeshGeometry, CompoundGeometry>;

/// A part of a compound; parts are never compounds themselves.
struct GeometryPart {
  PoseValue X_OS;
  Geometry geometry;
  bool operator==(const GeometryPart&) const = default;
};

inline bool CompoundGeometry::operator==(const CompoundGeometry& other) const {
  return parts == other.parts;
}

}  // namespace handover
