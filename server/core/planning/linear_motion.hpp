// SPDX-License-Identifier: Apache-2.0
// Solver of linear stages: approach, lift, place, retreat. The tool goes straight ahead.
#pragma once

#include "core/motion/straight.hpp"
#include "core/planning/collision_context.hpp"

#include <optional>

namespace handover {

JointPath reversed(JointPath path);

/// The straight line of the tool from its pose X_WT at q to another pose, if it exists and is free.
std::optional<JointPath> linearPath(const Manipulator& arm, const ArmVector& q, const Pose& X_WT,
                                    const Pose& X_WT_end, StateChecker& checker);

/// Straight back from a grasp, against its approach: the longest of the settings' distances that is
/// free. An approach is such a path reversed.
std::optional<JointPath> retreatPath(const Manipulator& arm, const ArmVector& q, const Pose& X_WT,
                                     StateChecker& checker, const LinearMotionSettings& settings);

/// Straight up with the object, likewise. A place is such a path reversed.
std::optional<JointPath> liftPath(const Manipulator& arm, const ArmVector& q, const Pose& X_WT,
                                  StateChecker& checker, const LinearMotionSettings& settings);

}  // namespace handover
