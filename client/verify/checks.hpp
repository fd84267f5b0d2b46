// SPDX-License-Identifier: Apache-2.0
// The checks, in the order in which they are made.
#pragma once

#include "verify/motion.hpp"
#include "verify/report.hpp"
#include "verify/rules.hpp"
#include "verify/scene.hpp"

namespace handover::verify {

/// The start: q_start within limits and by the mimic laws, limits no wider than the URDF's, objects
/// where they are said to be.
void checkStart(const Scene& scene, Report& report);

/// Form of the stages: the fourteen in order, robots, joints, times, dependencies between stages.
/// @returns false when the motion as a whole has no meaning, so that nothing further can be
/// checked.
bool checkStructure(const Scene& scene, Report& report);

/// Every cubic against the limits, joins, rest at the ends, posture after retreats.
void checkTrajectories(const Scene& scene, Report& report);

/// Holds, O's way from start to goal, dexterities.
/// @returns false when a hold is missing, so that O's motion is unknown.
bool checkHolds(const Scene& scene, Report& report);
void checkObjectMotion(const Motion& motion, Report& report);
void checkDexterity(const Motion& motion, Report& report);

/// Both grasps: at least two finger links within 2 mm of O, two contact normals more than 120°
/// apart.
void checkGrasps(const Motion& motion, Report& report);

/// The file's may_touch against the table.
void checkClaims(const Scene& scene, const ContactRules& rules, Report& report);

/// All bodies along the whole motion.
void checkCollisions(const Motion& motion, const ContactRules& rules, Report& report);

}  // namespace handover::verify
