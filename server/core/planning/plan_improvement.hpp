// SPDX-License-Identifier: Apache-2.0
// Mode best: better plans than the first, as long as a count allows (design §7).
#pragma once

#include "core/planning/chain_search.hpp"

#include <cstdint>

namespace handover {

/// Goes on from the state's plan, which is sent already, with other grasps and handover poses of
/// its chain, the most promising first, and sends each plan that costs less than all before. What
/// it finds for a tuple depends on the request and the tuple alone. A deadline ends it.
/// @param search  the chain's, open.
/// @return the index of the best solution.
std::uint32_t improvePlan(SearchState& state, ChainSearch& search);

/// Mode all: the best plans that are found so, the state's among them, each with another pair of
/// grasps or another pose; sent in the order of their cost.
void rankPlans(SearchState& state, ChainSearch& search);

}  // namespace handover
