// SPDX-License-Identifier: Apache-2.0
// The file that keeps the convex parts of one mesh: a header, then for every part its sizes, its
// vertices, its triangles. Little-endian.
#pragma once

#include "core/decomposition/triangle_mesh.hpp"

#include <handover/common/result.hpp>

#include <cstdint>
#include <filesystem>
#include <vector>

namespace handover {

/// Hash of all that decides a mesh's parts: its triangles, and the version of the method.
std::uint64_t partsHash(const TriangleMesh& mesh);

/// Temporary name, synced, renamed.
Result<void> writePartsFile(const std::vector<TriangleMesh>& parts, std::uint64_t hash,
                            const std::filesystem::path& file);

/// kNotFound: no file; kInvalidInput: not ours, damaged, of another mesh or version (the detail
/// says what). What is read is in order: closed numbering, finite vertices.
Result<std::vector<TriangleMesh>> readPartsFile(const std::filesystem::path& file,
                                                std::uint64_t expected_hash);

}  // namespace handover
