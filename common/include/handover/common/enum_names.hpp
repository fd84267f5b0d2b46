// SPDX-License-Identifier: Apache-2.0
// Names of enumerators, as files, the wire's texts and the command line spell them.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

namespace handover {

/// Specialised for each enumeration with names: `value` lists them from enumerator 0, which means
/// "unspecified" and never travels, without gaps.
template <typename Enum>
struct EnumNames;

template <typename Enum>
concept NamedEnum = requires {
  EnumNames<Enum>::value.size();
};

/// Whether the number is one of the enumerators, 0 included.
template <NamedEnum Enum>
constexpr bool known(Enum value) {
  return static_cast<std::size_t>(value) < EnumNames<Enum>::value.size();
}

/// "unspecified" for enumerator 0 and for numbers that are no enumerators.
template <NamedEnum Enum>
constexpr const char* toString(Enum value) {
  return known(value) ? EnumNames<Enum>::value[static_cast<std::size_t>(value)]
                      : EnumNames<Enum>::value[0];
}

/// The enumerator of a name; nullopt for unknown names and for "unspecified".
template <NamedEnum Enum>
constexpr std::optional<Enum> fromString(std::string_view name) {
  for (std::size_t i = 1; i < EnumNames<Enum>::value.size(); ++i) {
    if (name == EnumNames<Enum>::value[i]) return static_cast<Enum>(i);
  }
  return std::nullopt;
}

}  // namespace handover
