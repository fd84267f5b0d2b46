// SPDX-License-Identifier: Apache-2.0
#include "file_target.hpp"

namespace handover::fuzz {

std::vector<std::string> seeds() { return {testing::kTinyCell}; }

void run(std::string_view input) {
  checkWith("config/cells/test.yaml", input, "config/cells/test.yaml");
}

}  // namespace handover::fuzz
