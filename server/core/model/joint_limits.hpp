// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/model/robot_model.hpp"

#include <cstdio>
#include <string>

namespace handover {

/// [rad or m] Positions in files may be outside the limits by this: the rounding of written
/// decimals.
inline constexpr double kWrittenLimitSlack = 1e-6;

/// Of a position read from a file, which is then clamped to the limits.
inline bool withinWrittenLimits(const Joint& joint, double position) {
  return position >= joint.lower - kWrittenLimitSlack &&
         position <= joint.upper + kWrittenLimitSlack;
}

/// A position beside a joint's limits, for messages: "0.046 is not from 0 to 0.045".
inline std::string besideLimits(const Joint& joint, double position) {
  char text[112];
  std::snprintf(text, sizeof(text), "%.9g is not from %.9g to %.9g", position, joint.lower,
                joint.upper);
  return text;
}

}  // namespace handover
