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

}  // namespace handover::verify
