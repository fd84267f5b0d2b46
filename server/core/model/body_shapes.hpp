// SPDX-License-Identifier: Apache-2.0
// What a link or an object is made of: convex shapes, and the true surface where these only
// approach it.
#pragma once

#include "core/decomposition/triangle_mesh.hpp"
#include "core/model/shape.hpp"

#include <cstdint>
#include <memory>
#include <vector>

namespace handover {

/// A body that was divided into convex parts, which cover its surface and reach a little outside.
struct DividedBody {
  TriangleMesh surface;    ///< as given, in the frame of the whole; outward where it is closed
  int open_edges = 0;      ///< 0: closed
  std::uint64_t hash = 0;  ///< of the surface as it was divided
  int first_shape = 0;     ///< its parts among the shapes of the whole
  int shape_count = 0;
};

using DividedBodies = std::vector<DividedBody>;

/// Shapes of which those of no divided body meet the surface exactly.
struct BodyShapes {
  std::vector<Shape> shapes;
  DividedBodies divided;
};

}  // namespace handover
