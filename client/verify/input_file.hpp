// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace handover::verify {

/// @throws Unreadable unless `file` is a regular file; devices and pipes are never opened.
void requireFile(const std::filesystem::path& file);

/// The whole content of a regular file of at most `max_bytes`.
/// @throws Unreadable
std::string readFile(const std::filesystem::path& file, std::uint64_t max_bytes);

/// The file that a URDF's mesh name means: package://NAME/REST is looked for below the root with
/// and without NAME and beside the URDF's own folders; other names are relative to the URDF.
/// @throws Unreadable when there is none.
std::filesystem::path resolveUrdfMesh(const std::string& name, const std::filesystem::path& urdf,
                                      const std::filesystem::path& root);

}  // namespace handover::verify
