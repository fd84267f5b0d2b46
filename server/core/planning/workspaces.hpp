// SPDX-License-Identifier: Apache-2.0
// Where the arms of a failed request reach, as a picture needs it.
#pragma once

#include "core/planning/transport_problem.hpp"

#include <handover/common/plan_event.hpp>

namespace handover {

/// Horizontal slices of the reachability maps of every arm that could be a holder: those that the
/// chain's places name, or all without a chain; at most bounds::kSlices, none twice. The plane goes
/// through the object where the search came farthest, else through its start or goal where the
/// failure is about that, else through the middle of the shoulders of the first and last holder.
Workspaces workspacesOf(const TransportProblem& problem, const Failed& failed);

}  // namespace handover
