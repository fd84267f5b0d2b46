// SPDX-License-Identifier: Apache-2.0
// Convex parts of meshes, kept in the cache folder.
#pragma once

#include "core/decomposition/convex_decomposition.hpp"

#include <filesystem>

namespace handover {

/// A ConvexDecomposer that makes each mesh's parts once and keeps them in parts/HASH.parts of a
/// folder. A file that is damaged or of another mesh is made again, with a word to the log; a
/// folder that cannot be written costs the making each time. Safe from any thread.
class DecompositionCache {
 public:
  /// `force`: make everything anew, whatever the folder holds.
  DecompositionCache(const std::filesystem::path& folder, bool force);

  Result<std::vector<TriangleMesh>> operator()(const TriangleMesh& mesh) const;

 private:
  std::filesystem::path folder_;
  bool force_;
};

}  // namespace handover
