// SPDX-License-Identifier: Apache-2.0
#include "file_target.hpp"

namespace handover::fuzz {

std::vector<std::string> seeds() { return {testing::kTinyUrdf}; }

void run(std::string_view input) {
  checkWith("robots/tiny/tiny.urdf", input, "robots/tiny/tiny.yaml");
}

}  // namespace handover::fuzz
