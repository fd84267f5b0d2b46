// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/model/shape.hpp"

#include <filesystem>
#include <vector>

namespace handover {

/// Reads STL, OBJ or DAE into convex shapes in the mesh's own frame, one per mesh node, with units
/// and node transforms honoured and `scale` applied. A node that is not convex is refused.
/// @throws FileError naming the file and what is wrong with it.
std::vector<Shape> readConvexMesh(const std::filesystem::path& file, const Eigen::Vector3d& scale);

}  // namespace handover
