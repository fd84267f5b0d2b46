// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace handover {

/// The client's random 16-byte id of one request; the same id is the same request.
struct RequestId {
  std::array<std::uint8_t, 16> bytes{};

  // NOLINTNEXTLINE(modernize-use-nullptr): version 14 sees a null pointer in every defaulted <=>
  auto operator<=>(const RequestId&) const = default;

  /// A fresh random id (UUID version 4), from the operating system's entropy.
  static RequestId random();
  /// 32 lower-case hex digits.
  std::string hex() const;
  /// The inverse of hex(), upper case accepted; nullopt for anything else.
  static std::optional<RequestId> fromHex(std::string_view text);
};

}  // namespace handover
