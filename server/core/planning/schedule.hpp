// SPDX-License-Identifier: Apache-2.0
// When each stage starts. Done one after the other stages are proven free; they overlap in time
// where precedence allows it and nothing touches.
#pragma once

#include "core/planning/stage_timing.hpp"

#include <vector>

namespace handover {

struct ScheduledStage {
  double start = 0;                  ///< [s] from the plan's start
  std::vector<StageProgress> after;  ///< by rising stage: precedence, and movers waited for
};

/// Starts for all stages, in their order. Stages that are joined start as one, as early as the
/// motions of every earlier stage still under way can be proven free of contact with theirs; at the
/// latest as if there were one mover at a time.
/// @param stages  all of a plan, in order; each proven free while all before it are done and none
///                after it has begun.
/// @param deadline  once it is over what comes back means nothing.
std::vector<ScheduledStage> scheduleStages(CollisionContext& context,
                                           const std::vector<TimedStage>& stages,
                                           const Deadline& deadline);

}  // namespace handover
