// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/model/robot_model.hpp"

namespace handover {

/// [rad or m] Positions in files may be outside the limits by this: the rounding of written
/// decimals.
inline constexpr double kWrittenLimitSlack = 1e-6;

/// Of a position read from a file, which is then clamped to the limits.
inline bool withinWrittenLimits(const Joint& joint, double position) {
  return position >= joint.lower - kWrittenLimitSlack &&
         position <= joint.upper + kWrittenLimitSlack;
}

}  // namespace handover
