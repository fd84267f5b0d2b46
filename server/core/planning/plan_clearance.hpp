// SPDX-License-Identifier: Apache-2.0
// How near a plan comes to things on its way, of the timed motions as they are scheduled.
#pragma once

#include "core/planning/schedule.hpp"

#include <handover/common/plan_event.hpp>

#include <vector>

namespace handover {

/// Nobody asks for more than this [m] (design §5, Quality).
inline constexpr double kMostClearance = 0.05;
/// What is reported is proven all along, and at most this less than the truth [m].
inline constexpr double kClearanceFineness = 0.0003;

/// Least distances over reach, carry and home, all movers where the schedule has them: of links
/// that these move to furniture; to other robots, and to other arms of the same robot (what is
/// attached counts with its robot); of the object in a hand to all but the hands of the chain. Left
/// out: standing pairs, hand against hand of holders that follow each other, and bodies that
/// nothing moves against each other. One entry each for furniture, robots, object; kMostClearance
/// without a pair where there is more room than that.
/// @pre one schedule entry per stage of `timed`, in order.
std::vector<ClearanceQuality> clearanceOf(const TransportProblem& problem,
                                          const TransportPath& path,
                                          const std::vector<TimedStage>& timed,
                                          const std::vector<ScheduledStage>& schedule);

}  // namespace handover
