// SPDX-License-Identifier: Apache-2.0
// Convex parts of meshes, kept in the cache folder.
#pragma once

#include "core/decomposition/convex_decomposition.hpp"

#include <handover/common/deadline.hpp>

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace handover {

/// A ConvexDecomposer that makes each mesh's parts once and keeps them in parts/HASH.parts of a
/// folder. A file that is damaged or of another mesh is made again, with a word to the log; a
/// folder that cannot be written costs the making again in the next process. Safe from any thread.
class DecompositionCache {
 public:
  /// What is being done ("dividing meshes: 12 of 55") and the share of it that is.
  using Progress = std::function<void(const std::string& what, double fraction)>;

  /// `force`: make everything anew, whatever the folder holds, but each mesh once. An empty folder
  /// name: nothing is kept on disk. `until`: what the call without a deadline is given up at.
  DecompositionCache(const std::filesystem::path& folder, bool force, Progress progress = {},
                     const Deadline& until = {});
  ~DecompositionCache();

  Result<std::vector<TriangleMesh>> operator()(const TriangleMesh& mesh) const;
  /// The same, given up with kDeadline when the deadline passes or is cancelled.
  Result<std::vector<TriangleMesh>> parts(const TriangleMesh& mesh, const Deadline& deadline) const;
  /// What needs no dividing: parts that were made before, refusals that were or that cost nothing
  /// to find. nullopt: it has to be divided first.
  std::optional<Result<std::vector<TriangleMesh>>> known(const TriangleMesh& mesh) const;

  /// Runs `load`, which gets its parts from this cache, so that faults which cost nothing to find
  /// come before any mesh is divided: in a first round meshes without parts get a box for them, and
  /// what convexParts() refuses at once is refused; if there were such meshes, and `load` found no
  /// fault (true), it runs again, from the start, with the true parts. What it throws ends it.
  void loadInRounds(const std::function<bool()>& load) const;

 private:
  struct Data;
  std::shared_ptr<Data> data_;
};

}  // namespace handover
