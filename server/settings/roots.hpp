// SPDX-License-Identifier: Apache-2.0
// Where config/, robots/ and meshes are found.
#pragma once

#include <filesystem>
#include <string>

namespace handover {

/// The root that relative PATHs stand on: `given` (the --root option), else HANDOVER_ROOT, else
/// searched from the running program's folder upwards: share/handover, or a folder with
/// config/cells and robots.
/// @throws FileError when there is none, or the given one is not a folder.
std::filesystem::path findRoot(const std::string& given = "");

/// The file of a cell: config/cells/NAME.yaml below the root for a name; anything with a '/' or
/// ending in .yaml is a file itself.
std::filesystem::path cellFile(const std::string& name_or_file, const std::filesystem::path& root);

/// robots/NAME/NAME.yaml below the root.
std::filesystem::path robotFile(const std::string& model, const std::filesystem::path& root);

/// The cache folder: `given`, else $XDG_CACHE_HOME/handover, else ~/.cache/handover; relative paths
/// in the environment do not count. Never a folder of the temporary directory: that is anybody's.
/// @throws std::runtime_error that names what to set when there is none of them.
std::filesystem::path cacheFolder(const std::string& given);

}  // namespace handover
