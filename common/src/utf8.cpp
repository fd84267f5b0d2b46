// SPDX-License-Identifier: Apache-2.0
#include <handover/common/utf8.hpp>

#include <algorithm>

namespace handover {
namespace {

/// By the first byte; 0: none begins with it.
std::size_t sizeBy(unsigned char first) {
  if (first < 0x80) return 1;
  if (first >= 0xC2 && first < 0xE0) return 2;
  if (first >= 0xE0 && first < 0xF0) return 3;
  return first >= 0xF0 && first < 0xF5 ? 4 : 0;
}

}  // namespace

std::size_t characterSize(std::string_view text) {
  if (text.empty()) return 0;
  const std::size_t size = sizeBy(static_cast<unsigned char>(text.front()));
  if (size == 0 || size > text.size()) return 0;
  const std::string_view rest = text.substr(1, size - 1);
  return std::all_of(rest.begin(), rest.end(), goesOn) ? size : 0;
}

}  // namespace handover
