// SPDX-License-Identifier: Apache-2.0
// A mesh file as assimp reads it, in a child process, which it may crash.
#pragma once

#include "core/model_io/apart.hpp"

#include <handover/common/result.hpp>

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace handover {

/// Faces of one material.
struct MeshPiece {
  std::vector<std::array<float, 3>> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices of vertices, all there
};

struct MeshNode {
  std::string name;           ///< its mesh's, else its own
  Eigen::Matrix4d transform;  ///< of the node's coordinates to the file's
  std::vector<std::uint32_t> pieces;
};

struct ImportedMesh {
  std::vector<MeshPiece> pieces;
  std::vector<MeshNode> nodes;  ///< parents before children; those that have pieces
};

/// Reads mesh files, all in one child as long as none ends it. One thread at a time.
class MeshImporter {
 public:
  MeshImporter();

  /// Reads STL, OBJ or DAE, by the file's extension, from its text; or says what is wrong, after
  /// "cannot be read as a mesh".
  Result<ImportedMesh> read(const std::filesystem::path& file, const std::string& text);

 private:
  Apart import_;
};

}  // namespace handover
