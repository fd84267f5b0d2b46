// SPDX-License-Identifier: Apache-2.0
// When the stages begin: those of one robot one after another, those of the two at the same time
// where holds allow it and nothing touches.
#pragma once

#include "core/handover/exchange.hpp"
#include "core/motion/timing.hpp"

#include <vector>

namespace handover {

/// A stage timed by itself.
struct TimedStage {
  const StagePath* stage = nullptr;
  TimedPath path;
  double early = 0;  ///< [s] of a retreat, in which contacts of the stage before may last
};

/// The start of each stage [s from the plan's start]. Receiver's reach and approach go on while the
/// giver lifts and carries, at the earliest from the lift on; its transfer and placing while the
/// giver retreats, once the giver's hand has left the object. Each of the two begins as early as
/// motions of both arms can be proven free of contact with each other; at the latest as if there
/// were one stage at a time.
/// @param stages  all fourteen, in order; each proven free while the other robot stands.
std::vector<double> startTimes(const CollisionContext& checkers,
                               const std::vector<TimedStage>& stages);

}  // namespace handover
