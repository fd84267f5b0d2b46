// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

namespace handover::verify {

/// @throws Unreadable unless `file` is a regular file; devices and pipes are never opened.
void requireFile(const std::filesystem::path& file);

/// The whole content of a regular file of at most `max_bytes`.
/// @throws Unreadable
std::string readFile(const std::filesystem::path& file, std::uint64_t max_bytes);

/// Folders that package:// names stand for, beyond those that are found.
using Packages = std::map<std::string, std::filesystem::path>;

/// The file that a URDF's mesh name means. package://NAME/REST is looked for, in this order: in the
/// folder that `packages` has for NAME; in a folder whose package.xml has that name, among the
/// URDF's own folders, what lies beside and below them within the root, ROS_PACKAGE_PATH and
/// AMENT_PREFIX_PATH; in a folder of that name above the URDF; below the root with and without
/// NAME. Other names are relative to the URDF.
/// @throws Unreadable when there is none, naming the places.
std::filesystem::path resolveUrdfMesh(const std::string& name, const std::filesystem::path& urdf,
                                      const std::filesystem::path& root, const Packages& packages);

}  // namespace handover::verify
