// SPDX-License-Identifier: Apache-2.0
// Timing contestants side by side: noise hits them alike.
#pragma once

#include <functional>
#include <vector>

namespace handover::bench {

/// Runs every contestant once unmeasured, then `rounds` times in turn, each round beginning with
/// another one. Returns each one's median time of a round [s].
std::vector<double> medianRounds(int rounds, const std::vector<std::function<void()>>& contestants);

/// The value below which `part` in [0, 1] of them lie, between neighbours in proportion. @pre not
/// empty.
double quantile(std::vector<double> values, double part);

}  // namespace handover::bench
