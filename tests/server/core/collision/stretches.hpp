// SPDX-License-Identifier: Apache-2.0
// What every JointMotion promises of its stretches.
#pragma once

#include "core/collision/joint_motion.hpp"

#include <gtest/gtest.h>

namespace handover::test {

/// No state of the curve is farther from the stretch's line than it says.
/// @param at  s -> q(s).
template <typename StateAt>
void expectNearTheLine(const JointMotion& motion, double from, double to, const StateAt& at) {
  MotionInterval stretch;
  motion.stretch(from, to, stretch);
  EXPECT_TRUE(stretch.q_middle.isApprox(at(0.5 * (from + to)), 1e-12));
  for (int k = 0; k <= 20; ++k) {
    const double x = -1 + 0.1 * k;
    const Eigen::VectorXd off =
        at(0.5 * (from + to) + 0.5 * x * (to - from)) - stretch.q_middle - x * stretch.along;
    EXPECT_LE((off.cwiseAbs() - stretch.rest).maxCoeff(), 1e-12) << from << " " << to << " " << x;
  }
}

}  // namespace handover::test
