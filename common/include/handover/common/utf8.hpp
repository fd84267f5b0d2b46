// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string_view>

namespace handover {

/// True for a byte that goes on with a UTF-8 character of several.
inline bool goesOn(char c) { return (static_cast<unsigned char>(c) & 0xC0u) == 0x80; }

/// Bytes of the UTF-8 character that a text begins with; 0: it begins with none, or is empty.
std::size_t characterSize(std::string_view text);

}  // namespace handover
