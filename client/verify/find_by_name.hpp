// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

namespace handover::verify {

/// The place of the first entry of that name; -1 when there is none.
template <typename Named>
int findByName(const std::vector<Named>& entries, std::string_view name) {
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (entries[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

}  // namespace handover::verify
