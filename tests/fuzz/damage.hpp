// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <random>
#include <string>

namespace handover::test {

/// The text with a few changes drawn from the generator: bytes changed, cut out or doubled, the end
/// cut off, lines left out, doubled or swapped, words and numbers replaced by such as readers
/// stumble over.
std::string damaged(std::string text, std::mt19937_64& generator);

/// `runs` times HANDOVER_FUZZ_FACTOR (default 1).
int fuzzRuns(int runs);

/// What one damaged file may take at most: ample, and far from for ever.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr std::chrono::seconds kMostTime{200};
#else
inline constexpr std::chrono::seconds kMostTime{20};
#endif

}  // namespace handover::test
