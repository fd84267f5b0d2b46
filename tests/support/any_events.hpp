// SPDX-License-Identifier: Apache-2.0
// Drawn requests and events: every member, every variant, numbers of any size, names with
// whatever a text may hold. To be called within a property (see property.hpp).
#pragma once

#include <handover/common/plan_event.hpp>
#include <handover/common/status.hpp>

#include <vector>

namespace handover::test {

PlanRequest anyRequest();
DaemonStatus anyStatus();

/// An event that passes check(); its payload stands for itself and refers to nothing.
PlanEvent anyEvent();

/// A whole answer of a few solutions, the last one final: the names that stages and objects refer
/// to are those of its scene, as a plan file must have them.
std::vector<PlanEvent> anyAnswer();

}  // namespace handover::test
