// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "support/sanitized.hpp"

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
inline constexpr std::chrono::seconds kMostTime{kSanitized ? 200 : 20};

}  // namespace handover::test
