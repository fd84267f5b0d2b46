// SPDX-License-Identifier: Apache-2.0
// libFuzzer's end of a target.
#include "target.hpp"

#include <cstddef>
#include <cstdint>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  handover::fuzz::run({reinterpret_cast<const char*>(data), size});
  return 0;
}
