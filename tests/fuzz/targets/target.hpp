// SPDX-License-Identifier: Apache-2.0
// A reader of foreign bytes as fuzzers see it; each file of this folder is one.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace handover::fuzz {

/// Good inputs, from which fuzzing starts.
std::vector<std::string> seeds();

/// Reads any input. @throws std::logic_error where the reader breaks a promise; what it refuses is
/// no exception.
void run(std::string_view input);

}  // namespace handover::fuzz
