// SPDX-License-Identifier: Apache-2.0
#include "core/collision/arm_self_collision.hpp"

#include "small_robots.hpp"

#include <gtest/gtest.h>

namespace handover::test {
namespace {

ArmVector arm(double first, double second) {
  ArmVector q(2);
  q << first, second;
  return q;
}

TEST(ArmSelfCollision, SeesTheTorsoAndNotTheOtherArm) {
  const auto model = twoArmRobot();
  ArmSelfCollision left(*model, ArmId(0), RobotVector::Zero(model->dofs()));
  EXPECT_FALSE(left.touches(arm(0, 0)));
  EXPECT_FALSE(left.touches(arm(1.5, 0.5)));
  EXPECT_TRUE(left.touches(arm(0, 3.05)));  // folded onto itself and into the base
  // Round the base, past its corner, its hand is where the right arm stands: that arm can move
  // away.
  const ArmVector behind = arm(2.2, 1.25);
  RobotVector q = RobotVector::Zero(model->dofs());
  EXPECT_FALSE(ArmSelfCollision(*model, ArmId(0), q).touches(behind));
}

TEST(ArmSelfCollision, OpensTheHand) {
  const auto model = twoArmRobot();
  RobotVector shut = RobotVector::Zero(model->dofs());
  ArmSelfCollision from_shut(*model, ArmId(0), shut);
  shut[2] = 0.05;
  ArmSelfCollision from_open(*model, ArmId(0), shut);
  for (double second = 2.0; second < 3.1; second += 0.01) {
    EXPECT_EQ(from_shut.touches(arm(0.4, second)), from_open.touches(arm(0.4, second)));
  }
}

TEST(ArmSelfCollision, RefusesAnArmThatIsNotThere) {
  const auto model = twoArmRobot();
  EXPECT_THROW(ArmSelfCollision(*model, ArmId(2), RobotVector::Zero(model->dofs())),
               std::invalid_argument);
  EXPECT_THROW(ArmSelfCollision(*model, ArmId(0), RobotVector::Zero(1)), std::invalid_argument);
}

}  // namespace
}  // namespace handover::test
