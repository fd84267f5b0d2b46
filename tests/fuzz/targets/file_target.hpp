// SPDX-License-Identifier: Apache-2.0
// Targets that are one file of a small root, read as `handoverd check` does.
#pragma once

#include "server/settings/tiny_root.hpp"
#include "settings/check.hpp"
#include "target.hpp"

namespace handover::fuzz {

/// Puts the input in the place of a file and checks one, which finds faults or does not.
inline void checkWith(const std::string& file, std::string_view input, const std::string& checked) {
  static const testing::TinyRoot root;
  root.write(file, std::string(input));
  (void)checkFiles({root.path() / checked}, root.path());
}

}  // namespace handover::fuzz
