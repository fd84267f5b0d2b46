// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <handover/common/random.hpp>

#include <cstdint>

namespace handover::dense {

/// The numbers 0 ... size - 1 in a random order, each once, without a list of them: a Feistel
/// network over the next power of four, walked past what lies beyond the size.
class RandomOrder {
 public:
  RandomOrder(std::uint64_t size, std::uint64_t seed) : size_(size), seed_(seed) {
    while (half_ < 31 && (std::uint64_t{1} << (2 * half_)) < size) ++half_;
  }

  /// @pre i < size.
  std::uint64_t operator()(std::uint64_t i) const {
    do i = once(i);
    while (i >= size_);
    return i;
  }

 private:
  std::uint64_t once(std::uint64_t i) const {
    const std::uint64_t mask = (std::uint64_t{1} << half_) - 1;
    std::uint64_t left = i >> half_, right = i & mask;
    for (std::uint64_t round = 0; round < 4; ++round) {
      const std::uint64_t mixed =
          left ^ (SeededRandom::mix(SeededRandom::mix(seed_ + round) ^ right) & mask);
      left = right;
      right = mixed;
    }
    return left << half_ | right;
  }

  std::uint64_t size_, seed_;
  int half_ = 1;  ///< bits of each half
};

}  // namespace handover::dense
