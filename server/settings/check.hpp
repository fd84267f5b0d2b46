// SPDX-License-Identifier: Apache-2.0
// What `handoverd check FILE ...` does.
#pragma once

#include "core/decomposition/convex_decomposition.hpp"
#include "core/model_io/file_fault.hpp"

#include <filesystem>
#include <vector>

namespace handover {

struct CheckReport {
  std::vector<FileFault> faults;
  std::vector<FileFault> warnings;  ///< what looks like a slip, of files without a fault
  std::vector<FileFault> facts;     ///< what they are made of
};

/// Every fault of these files. What a file is, its content decides: cell, robot or daemon settings
/// (YAML), URDF, SRDF (checked against the URDF of the same name beside it), or a mesh. Paths
/// inside stand on `root`; `divide` is for meshes that are not convex.
CheckReport checkFiles(const std::vector<std::filesystem::path>& files,
                       const std::filesystem::path& root,
                       const ConvexDecomposer& divide = convexParts);

}  // namespace handover
