// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <charconv>
#include <cstdlib>
#include <optional>
#include <string>

namespace handover {

/// The largest DDS domain whose ports exist.
inline constexpr int kMaxDomain = 232;

/// A whole text that is a number in [0, kMaxDomain]; nullopt for anything else.
inline std::optional<int> parseDomain(const std::string& text) {
  int domain = -1;
  const char* last = text.data() + text.size();
  const auto [end, code] = std::from_chars(text.data(), last, domain);
  if (code != std::errc{} || end != last || domain < 0 || domain > kMaxDomain) return std::nullopt;
  return domain;
}

/// HANDOVER_DOMAIN where it is set and not empty. The text, for the caller to parse and complain
/// about.
inline std::optional<std::string> environmentDomain() {
  const char* text = std::getenv("HANDOVER_DOMAIN");
  if (text == nullptr || *text == '\0') return std::nullopt;
  return text;
}

}  // namespace handover
