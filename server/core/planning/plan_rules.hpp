// SPDX-License-Identifier: Apache-2.0
// The rules of a plan (design §5), computed anew from the values that are about to be sent: what
// breaks one is a fault of ours and never leaves as done. Contacts of motions, also late ones, are
// not among them: the continuous checker has proven these.
#pragma once

#include "core/planning/plan_assembly.hpp"

#include <string>
#include <vector>

namespace handover {

/// Every rule that the plan breaks, in words; empty: none. Samples and limits, joints from stage to
/// stage, the object's way and tilt, straight lines, grips, order, dexterity.
/// @param world  of the problem's collision scene; its poses are changed.
std::vector<std::string> brokenRules(const TransportProblem& problem, const TransportPlan& plan,
                                     CollisionWorld& world);

}  // namespace handover
