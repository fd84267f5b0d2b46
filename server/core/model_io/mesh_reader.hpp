// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/decomposition/convex_decomposition.hpp"
#include "core/model/body_shapes.hpp"
#include "core/model_io/mesh_import.hpp"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace handover {

/// Reads STL, OBJ or DAE into convex shapes in the mesh's own frame, with units and node transforms
/// honoured and `scale` applied. The bodies of each node, whatever materials cut it into
/// (bodiesOf()): one that is convex is one shape, as it is; any other becomes what `divide` makes
/// of it.
/// @throws FileError naming the file and what is wrong with it.
BodyShapes readMeshBodies(const std::filesystem::path& file, const Eigen::Vector3d& scale,
                          const ConvexDecomposer& divide = convexParts);
/// The same with an importer that reads others, too: to make its child takes as long as a mesh.
BodyShapes readMeshBodies(const std::filesystem::path& file, const Eigen::Vector3d& scale,
                          const ConvexDecomposer& divide, MeshImporter& importer);

/// The shapes alone.
std::vector<Shape> readConvexMesh(const std::filesystem::path& file, const Eigen::Vector3d& scale,
                                  const ConvexDecomposer& divide = convexParts);

/// The meshes of one robot, or of one cell's objects, which are bounded together.
class MeshTotal {
 public:
  /// Counts a file; what is wrong if there are too many by now, else empty. A file that cannot be
  /// looked at counts nothing: its reader tells.
  std::string add(const std::filesystem::path& file);

 private:
  std::uintmax_t bytes_ = 0;
};

}  // namespace handover
