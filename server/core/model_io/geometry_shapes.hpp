// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/decomposition/convex_decomposition.hpp"
#include "core/model/shape.hpp"

#include <handover/common/geometry.hpp>

#include <filesystem>
#include <vector>

namespace handover {

/// The convex shapes of a geometry, in the geometry's own frame. Mesh paths stand on `root`;
/// `divide` is for those that are not convex.
/// @throws FileError when a mesh cannot be used.
std::vector<Shape> shapesOf(const Geometry& geometry, const std::filesystem::path& root,
                            const ConvexDecomposer& divide = convexParts);

}  // namespace handover
