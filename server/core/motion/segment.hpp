// SPDX-License-Identifier: Apache-2.0
// The walk along one straight joint segment that planner and shortcutter share.
#pragma once

#include "core/motion/ikbirrt.hpp"

namespace handover {

/// segmentValid() for a `from` that is known to be valid. No allocation.
bool restOfSegmentValid(const MotionProblem& problem, const ArmVector& from, const ArmVector& to);

}  // namespace handover
