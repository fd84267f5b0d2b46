// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace handover::test {

/// The text of a plan file's members "scene" and "plan": what has to be the same each time.
inline std::string planMember(const std::string& text) {
  const auto begin = text.find("\"scene\":"), end = text.find("\n  \"quality\":");
  return begin < end && end != std::string::npos ? text.substr(begin, end - begin) : "";
}

}  // namespace handover::test
