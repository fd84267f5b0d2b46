// SPDX-License-Identifier: Apache-2.0
#include "arms.hpp"

#include <Eigen/LU>

namespace handover::test {
namespace {

class Follow : public testing::TestWithParam<NamedArm> {
 protected:
  RobotModel model_ = GetParam().make();
  ArmKinematics arm_{model_, ArmId(0)};
};

std::vector<NamedArm> armsOfSixOrMore() {
  std::vector<NamedArm> arms = kArms;
  std::erase_if(arms,
                [](const NamedArm& arm) { return ArmKinematics(arm.make(), ArmId(0)).dofs() < 6; });
  return arms;
}

INSTANTIATE_TEST_SUITE_P(ArmKinematics, Follow, testing::ValuesIn(armsOfSixOrMore()), armName);

TEST_P(Follow, KeepsToStraightLinesWithoutJumps) {
  // 10 cm in 20 steps from random configurations that are not nearly singular.
  constexpr double kMaxStep = 0.1;
  RandomConfigurations configurations(arm_, 31);
  int lines = 0, finished = 0;
  while (lines < 500) {
    const ArmVector q_start = configurations.next();
    const Eigen::Vector3d direction(configurations.fraction() - 0.5,
                                    configurations.fraction() - 0.5,
                                    configurations.fraction() - 0.5);
    const Pose X_start = arm_.toolPose(q_start);
    Pose X_end = X_start;
    X_end.translation() += 0.1 * direction.normalized();
    if (arm_.manipulability(q_start) < 0.01) continue;
    ++lines;
    ArmVector q = q_start;
    bool on = true;
    for (int step = 1; step <= 20 && on; ++step) {
      Pose X_AT = X_start;
      X_AT.translation() += (X_end.translation() - X_start.translation()) * (step / 20.0);
      ArmVector next;
      on = arm_.trackPose(X_AT, q, kMaxStep, next);
      if (!on) break;
      ASSERT_TRUE(arm_.withinLimits(next, 0));
      ASSERT_LE((next - q).cwiseAbs().maxCoeff(), kMaxStep);
      ASSERT_LT(poseDistance(arm_.toolPose(next), X_AT), 2e-9);
      q = next;
    }
    finished += on ? 1 : 0;
  }
  // The rest runs into limits or the end of the reach.
  EXPECT_GE(finished, lines * 0.6);
  RecordProperty("finished", finished);
}

TEST_P(Follow, StaysWhereItIsWhenThePoseIsReached) {
  RandomConfigurations configurations(arm_, 32);
  for (int k = 0; k < 200; ++k) {
    const ArmVector q = configurations.next();
    ArmVector same;
    ASSERT_TRUE(arm_.trackPose(arm_.toolPose(q), q, 1e-3, same));
    EXPECT_LT((same - q).norm(), 1e-6);
  }
}

TEST_P(Follow, RefusesStepsThatAreTooLong) {
  RandomConfigurations configurations(arm_, 33);
  int refused = 0;
  for (int k = 0; k < 100; ++k) {
    const ArmVector q = configurations.next();
    Pose X_AT = arm_.toolPose(q);
    X_AT.translation().z() += 0.02;
    ArmVector next = ArmVector::Constant(1, 7.0);
    if (!arm_.trackPose(X_AT, q, 1e-4, next)) {
      ++refused;
      EXPECT_EQ(next.size(), 1);  // untouched
    }
  }
  EXPECT_EQ(refused, 100);
}

TEST(ArmKinematics, FollowMovesRedundantJointsAsLittleAsPossible) {
  // The step is orthogonal to the null space at its end: no other answer nearby is nearer.
  const ArmKinematics arm(lwa4Arm(), ArmId(0));
  RandomConfigurations configurations(arm, 34);
  int tested = 0;
  for (int k = 0; k < 200; ++k) {
    const ArmVector q = configurations.next();
    if (arm.manipulability(q) < 0.02) continue;
    Pose X_AT = arm.toolPose(q);
    X_AT.translation().x() += 0.01;
    ArmVector next;
    if (!arm.trackPose(X_AT, q, 0.2, next)) continue;
    bool at_limit = false;
    for (int i = 0; i < 7; ++i) at_limit |= next[i] == arm.lower()[i] || next[i] == arm.upper()[i];
    if (at_limit) continue;
    const Eigen::MatrixXd J = arm.jacobian(next);
    const Eigen::VectorXd null = Eigen::FullPivLU<Eigen::MatrixXd>(J).kernel().col(0).normalized();
    EXPECT_LT(std::abs(null.dot(Eigen::VectorXd(next - q))), 1e-5);
    ++tested;
  }
  EXPECT_GT(tested, 50);
}

TEST(ArmKinematics, FollowHoldsAJointAtItsLimit) {
  // A redundant arm goes on with its other joints when one of them is at its end.
  RobotModel model = lwa4Arm();
  const ArmVector q = degrees({10, 40, 20, 60, -30, 50, 15});
  model.joints[2].lower = q[2];
  model.joints[2].upper = q[2];
  const ArmKinematics arm(model, ArmId(0));
  Pose X_AT = arm.toolPose(q);
  X_AT.translation() += Eigen::Vector3d(0.01, -0.01, 0.02);
  ArmVector next;
  ASSERT_TRUE(arm.trackPose(X_AT, q, 0.3, next));
  EXPECT_EQ(next[2], q[2]);
  EXPECT_LT(poseDistance(arm.toolPose(next), X_AT), 2e-9);
}

}  // namespace
}  // namespace handover::test
