// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>

namespace handover::view {

/// The plan file, or a file that it names, cannot be shown.
class Unreadable : public std::runtime_error {
 public:
  /// @param where a JSON pointer into the plan file, or a file's path.
  Unreadable(const std::string& where, const std::string& what)
      : std::runtime_error(where + ": " + what) {}
};

}  // namespace handover::view
