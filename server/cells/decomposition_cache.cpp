// SPDX-License-Identifier: Apache-2.0
#include "cells/decomposition_cache.hpp"

#include "core/decomposition/decomposition_file.hpp"

#include <handover/common/log.hpp>

namespace handover {

DecompositionCache::DecompositionCache(const std::filesystem::path& folder, bool force)
    : folder_(folder / "parts"), force_(force) {}

Result<std::vector<TriangleMesh>> DecompositionCache::operator()(const TriangleMesh& mesh) const {
  const std::uint64_t hash = partsHash(mesh);
  const std::filesystem::path file = folder_ / fmt::format("{:016x}.parts", hash);
  const auto log = logger("parts");
  if (!force_) {
    auto known = readPartsFile(file, hash);
    if (known) return known;
    if (known.error().code != ErrorCode::kNotFound) {
      log->warn("{}; it is made again", known.error().detail);
    }
  }
  auto parts = convexParts(mesh);
  if (!parts) return parts;
  if (const auto written = writePartsFile(*parts, hash, file); !written) {
    log->warn("{}; the parts are not kept", written.error().detail);
  }
  return parts;
}

}  // namespace handover
