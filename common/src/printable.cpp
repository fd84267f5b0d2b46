// SPDX-License-Identifier: Apache-2.0
#include <handover/common/printable.hpp>
#include <handover/common/utf8.hpp>

namespace handover {
namespace {

/// The size of the character that the text starts with; 0: it is none, or one that controls.
std::size_t plainCharacter(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const bool controls =
      byte(0) < 0x20 || byte(0) == 0x7F || (byte(0) == 0xC2 && text.size() > 1 && byte(1) < 0xA0);
  return controls ? 0 : characterSize(text);
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
