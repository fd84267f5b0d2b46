// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>
#include <vector>

namespace handover {

/// A finite decimal number, or nullopt; "+1", "-.5" and "1e-3" are numbers, " 1", "1 2", "0x1" and
/// "nan" are not. The process's locale does not matter.
std::optional<double> parseNumber(std::string_view text);

/// The parts of a text between spaces; other white space belongs to the parts, as in urdfdom.
std::vector<std::string_view> splitWords(std::string_view text);

}  // namespace handover
