// SPDX-License-Identifier: Apache-2.0
// What `handoverd check FILE ...` does.
#pragma once

#include "core/model_io/file_fault.hpp"

#include <filesystem>
#include <vector>

namespace handover {

/// Every fault of these files. What a file is, its content decides: cell, robot or daemon settings
/// (YAML), URDF, SRDF (checked against the URDF of the same name beside it), or a mesh. Paths
/// inside stand on `root`.
std::vector<FileFault> checkFiles(const std::vector<std::filesystem::path>& files,
                                  const std::filesystem::path& root);

}  // namespace handover
