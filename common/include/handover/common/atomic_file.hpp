// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <handover/common/result.hpp>

#include <cstddef>
#include <filesystem>
#include <span>

namespace handover {

/// Writes a whole file: to a temporary name beside it, synced, renamed. Others see the old file or
/// the new one, after a loss of power too, and no signal to this thread leaves the temporary one.
/// Makes its folder. kIo with the reason.
Result<void> writeFileAtomically(const std::filesystem::path& file,
                                 std::span<const std::byte> bytes);

/// Whether a file could be written so, in a folder that is there. kIo with the reason.
Result<void> canWriteBeside(const std::filesystem::path& file);

}  // namespace handover
