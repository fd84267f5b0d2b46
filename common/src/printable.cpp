// SPDX-License-Identifier: Apache-2.0
#include <handover/common/printable.hpp>

namespace handover {
namespace {

/// How many bytes a character takes by its first one; 0: it cannot start one.
std::size_t sizeOf(unsigned char first) {
  if (first < 0x80) return 1;
  if (first >= 0xC2 && first <= 0xDF) return 2;
  if (first >= 0xE0 && first <= 0xEF) return 3;
  return first >= 0xF0 && first <= 0xF4 ? 4 : 0;
}

/// The size of the character that the text starts with; 0: it is none, or one that controls.
std::size_t plainCharacter(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const std::size_t size = sizeOf(byte(0));
  if (size > text.size()) return 0;
  for (std::size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xC0u) != 0x80) return 0;
  }
  const bool controls = byte(0) < 0x20 || byte(0) == 0x7F || (byte(0) == 0xC2 && byte(1) < 0xA0);
  return controls ? 0 : size;
}

void escape(unsigned char byte, std::string& line) {
  static constexpr std::string_view kDigits = "0123456789abcdef";
  if (byte == '\n') {
    line += "\\n";
    return;
  }
  line += "\\x";
  line += kDigits[byte >> 4];
  line += kDigits[byte & 0x0Fu];
}

}  // namespace

std::string printable(std::string_view text) {
  std::string line;
  line.reserve(text.size());
  while (!text.empty()) {
    const std::size_t size = plainCharacter(text);
    if (size == 0) escape(static_cast<unsigned char>(text[0]), line);
    line += text.substr(0, size);
    text.remove_prefix(size == 0 ? 1 : size);
  }
  return line;
}

}  // namespace handover
