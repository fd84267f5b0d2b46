// SPDX-License-Identifier: Apache-2.0
#include <handover/common/request_id.hpp>

#include <random>

namespace handover {
namespace {

int hexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

}  // namespace

RequestId RequestId::random() {
  std::random_device entropy;
  RequestId id;
  for (auto& byte : id.bytes) byte = static_cast<std::uint8_t>(entropy() & 0xFFu);
  id.bytes[6] = static_cast<std::uint8_t>((id.bytes[6] & 0x0Fu) | 0x40u);
  id.bytes[8] = static_cast<std::uint8_t>((id.bytes[8] & 0x3Fu) | 0x80u);
  return id;
}

std::string RequestId::hex() const {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  text.reserve(32);
  for (const auto byte : bytes) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 0x0F];
  }
  return text;
}

std::optional<RequestId> RequestId::fromHex(std::string_view text) {
  if (text.size() != 32) return std::nullopt;
  RequestId id;
  for (std::size_t i = 0; i < 16; ++i) {
    const int high = hexDigit(text[2 * i]);
    const int low = hexDigit(text[2 * i + 1]);
    if (high < 0 || low < 0) return std::nullopt;
    id.bytes[i] = static_cast<std::uint8_t>(high * 16 + low);
  }
  return id;
}

}  // namespace handover
