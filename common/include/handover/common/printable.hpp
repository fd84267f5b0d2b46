// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace handover {

/// Foreign text as part of one line: control characters and bytes that are no UTF-8 as \xNN, ends
/// of lines as \n; the rest as it is.
std::string printable(std::string_view text);

}  // namespace handover
