// SPDX-License-Identifier: Apache-2.0
// A robot small enough to work out by hand where it touches.
#pragma once

#include "core/model/scene.hpp"

#include <memory>

namespace handover::test {

/// Seen from above, in the plane z = 0, at q = 0 (metres):
///
///   base: box 0.2 x 0.2 x 0.2 round the origin; head: box of 0.1 fixed on it, its middle at (0, 0,
///   0.3) left arm:  joint at (0.15, 0) about z, `left_upper` from x 0.15 to 0.45 (0.04 square);
///              joint at (0.50, 0) about z, `left_lower` from x 0.50 to 0.80;
///              `left_palm` fixed at x 0.85: box 0.06 x 0.16 x 0.04, with fingers `left_finger_a`
///              (slides along +y) and `left_finger_b` (mimics it along -y): boxes 0.1 x 0.02 x 0.04
///              with their middles at x 0.95, y = +-(0.02 + q)
///   right arm: the same turned by 180 degrees about z.
///
/// dofs: left 0, 1, left hand 2; right 3, 4, right hand 5.
std::shared_ptr<RobotModel> twoArmRobot();

/// That robot at X_WB = identity and q = 0 (fingers 0.02 open), and no object.
Scene twoArmScene();

SceneObject boxObject(const std::string& name, const Eigen::Vector3d& size,
                      const Eigen::Vector3d& p_WO);

}  // namespace handover::test
