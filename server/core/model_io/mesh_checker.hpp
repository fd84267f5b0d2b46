// SPDX-License-Identifier: Apache-2.0
// A look at a mesh file's text before assimp reads it: assimp takes decimal commas, follows nodes
// that hold themselves until the stack ends, and needs minutes for polygons of 100 000 corners.
#pragma once

#include "core/model_io/file_fault.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace handover {

/// Of one file, instances counted each time.
inline constexpr std::size_t kMaxMeshTriangles = 500'000;
inline constexpr std::size_t kMaxMeshParts = 4096;

enum class MeshFormat { kStl, kObj, kDae };

/// The first faults of a mesh file, with their lines where it is a text.
std::vector<FileFault> meshFaults(const std::filesystem::path& file, MeshFormat format,
                                  const std::string& text);

}  // namespace handover
