// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <handover/common/result.hpp>

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace handover {

/// All bytes of a plain file (or of a link to one), at most `most_mib` MiB of them. Never waits:
/// a pipe or a device is refused. The error's detail says what is wrong, without the file's name:
/// kNotFound, kInvalidInput (no plain file, too large) or kIo.
Result<std::string> readFileText(const std::filesystem::path& file, std::uint64_t most_mib);

/// The first line that holds something that is no UTF-8 text (a NUL neither); 0: there is none.
int lineOfBadText(std::string_view text);

/// Fit for one line of a report: control characters as '?', at most 300 bytes.
std::string oneLine(std::string text);

}  // namespace handover
