// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/decomposition/convex_decomposition.hpp"
#include "core/model/body_shapes.hpp"
#include "core/model_io/mesh_import.hpp"

#include <handover/common/geometry.hpp>

#include <filesystem>

namespace handover {

/// A geometry as convex shapes, with the surfaces that they only approach, in the geometry's own
/// frame. Mesh paths stand on `root`; `divide` is for bodies that are not convex.
/// @throws FileError when a mesh cannot be used.
BodyShapes bodyShapesOf(const Geometry& geometry, const std::filesystem::path& root,
                        const ConvexDecomposer& divide = convexParts);
/// The same with an importer that reads the meshes of others, too.
BodyShapes bodyShapesOf(const Geometry& geometry, const std::filesystem::path& root,
                        const ConvexDecomposer& divide, MeshImporter& importer);

/// Adds a part to what a link or an object is made of, at its pose there.
void append(BodyShapes part, const Pose& X_WholePart, BodyShapes& whole);

}  // namespace handover
