// SPDX-License-Identifier: Apache-2.0
#include "file_target.hpp"

namespace handover::fuzz {

std::vector<std::string> seeds() {
  return {
      "version: 1\ncells: [test]\ndomain: 3\nthreads: 2\nlimits: {queue: 5, deadline_s: 2.5}\n"};
}

void run(std::string_view input) { checkWith("handoverd.yaml", input, "handoverd.yaml"); }

}  // namespace handover::fuzz
