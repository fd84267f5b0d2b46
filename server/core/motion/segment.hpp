// SPDX-License-Identifier: Apache-2.0
// The walk along one straight joint segment that planner and shortcutter share.
#pragma once

#include "core/motion/ikbirrt.hpp"

namespace handover {

/// Whether `to` is valid and so is the straight segment to it from a state that is known to be. No
/// allocation.
bool restOfSegmentValid(const MotionProblem& problem, const ArmVector& from, const ArmVector& to);

}  // namespace handover
