// SPDX-License-Identifier: Apache-2.0
#include "arms.hpp"

#include <algorithm>

namespace handover::test {
namespace {

constexpr double kTurn = 2 * M_PI;

/// True for the LWA4 as its author's file writes it, with 1.57 for pi/2.
bool isRounded(const RobotModel& model) {
  return model.name == "lwa4" && std::abs(model.joints[0].X_PJ.linear()(2, 1)) < 1 - 1e-9;
}

class ClosedForm : public testing::TestWithParam<NamedArm> {
 protected:
  RobotModel model_ = GetParam().make();
  ArmKinematics arm_{model_, ArmId(0)};
};

std::vector<NamedArm> armsWithClosedForm(bool closed_form) {
  std::vector<NamedArm> arms;
  std::copy_if(kArms.begin(), kArms.end(), std::back_inserter(arms),
               [&](const NamedArm& arm) { return arm.closed_form == closed_form; });
  return arms;
}

INSTANTIATE_TEST_SUITE_P(ArmKinematics, ClosedForm, testing::ValuesIn(armsWithClosedForm(true)),
                         armName);

TEST_P(ClosedForm, SolvesWhatItReachesAndEveryAnswerIsRight) {
  // An arm whose file is rounded takes Newton's steps for each of its 200 answers.
  const int poses = isRounded(model_) ? 2'000 : 10'000;
  RandomConfigurations configurations(arm_, 11);
  int solved = 0;
  std::vector<ArmVector> out;
  for (int k = 0; k < poses; ++k) {
    const Pose X_AT = arm_.toolPose(configurations.next());
    out.clear();
    const IkCounts counts = arm_.solve(X_AT, {}, out);
    ASSERT_EQ(counts.solutions, out.size());
    solved += out.empty() ? 0 : 1;
    for (const ArmVector& q : out) {
      ASSERT_TRUE(arm_.withinLimits(q, 0));
      ASSERT_LT(poseDistance(arm_.toolPose(q), X_AT), 2e-9) << q.transpose();
    }
  }
  EXPECT_GE(solved, poses * 0.999);
  RecordProperty("solved", solved);
}

TEST_P(ClosedForm, WristReachContainsEveryPoseReachedAndNoneIsLeftOutThatHasAnAnswer) {
  RandomConfigurations configurations(arm_, 14);
  const WristReach reach = arm_.wristReach().value();
  const auto may_reach = [&](const Pose& X_AT) {
    return reach.contains((X_AT * reach.p_TWrist - reach.p_AShoulder).squaredNorm());
  };
  int told = 0;
  std::vector<ArmVector> out;
  for (int k = 0; k < 2'000; ++k) {
    Pose X_AT = arm_.toolPose(configurations.next());
    EXPECT_TRUE(may_reach(X_AT));
    X_AT.translation() += 0.6 * (X_AT.translation() - arm_.shoulder());
    if (may_reach(X_AT)) continue;
    ++told;
    EXPECT_EQ(arm_.solve(X_AT, {}, out).solutions, 0u);
  }
  EXPECT_GT(told, 100);
}

TEST_P(ClosedForm, NeverAnswersAPoseOutOfReach) {
  RandomConfigurations configurations(arm_, 12);
  std::vector<ArmVector> out;
  for (int k = 0; k < 200; ++k) {
    Pose X_AT = arm_.toolPose(configurations.next());
    X_AT.translation() = arm_.shoulder() +
                         (X_AT.translation() - arm_.shoulder()).normalized() * (arm_.reach() + 0.5);
    const IkCounts counts = arm_.solve(X_AT, {}, out);
    EXPECT_EQ(counts.solutions, 0u);
    EXPECT_GT(counts.no_ik, 0u);
  }
  EXPECT_TRUE(out.empty());
}

TEST_P(ClosedForm, RefusesPosesThatAreNotFinite) {
  std::vector<ArmVector> out;
  for (const double bad : {std::nan(""), double(INFINITY), -double(INFINITY), 1e300, -1e155}) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        Pose X_AT = arm_.toolPose(ArmVector::Zero(7));
        X_AT.matrix()(row, column) = bad;
        EXPECT_EQ(arm_.solve(X_AT, {}, out).solutions, 0u);
        ArmVector q;
        EXPECT_FALSE(arm_.trackPose(X_AT, ArmVector::Zero(7), 0.5, q));
      }
    }
  }
  EXPECT_TRUE(out.empty());
}

TEST_P(ClosedForm, AnswersAtSingularConfigurationsAreFiniteAndRight) {
  // Every combination of stretched (or bent) elbow, straight shoulder and wrist, plain angles
  // elsewhere.
  RandomConfigurations configurations(arm_, 13);
  std::vector<ArmVector> out;
  int solved_stretched = 0, stretched = 0, solved_bent = 0, bent = 0;
  for (const double q4 : {0.0, 1e-9, 1e-5, -0.1949836, -1.0}) {
    for (const double q2 : {0.0, 1e-12, 1e-9, 1e-6, 1e-3}) {
      for (const double q6 : {0.0, -1e-12, 1e-9, 1e-6, 1e-3}) {
        ArmVector q = configurations.next();
        q[1] = q2;
        q[3] = q4;
        q[5] = q6;
        const Pose X_AT = arm_.toolPose(q);
        out.clear();
        IkQuery query;
        query.q_near = q;
        const IkCounts counts = arm_.solve(X_AT, query, out);
        EXPECT_EQ(counts.solutions, out.size());
        (q4 > -0.1 ? stretched : bent) += 1;
        (q4 > -0.1 ? solved_stretched : solved_bent) += out.empty() ? 0 : 1;
        for (const ArmVector& answer : out) {
          ASSERT_TRUE(answer.allFinite());
          ASSERT_TRUE(arm_.withinLimits(answer, 0));
          ASSERT_LT(poseDistance(arm_.toolPose(answer), X_AT), 2e-9);
        }
      }
    }
  }
  EXPECT_EQ(solved_bent, bent);
  // Straight to 1e-5 rad in elbow and wrist at once, an arm whose file is rounded is lost: its true
  // wrist point lies on the edge of what its rounded axes allow, and Newton's steps creep there.
  if (!isRounded(model_)) {
    EXPECT_GE(solved_stretched, stretched - 2);  // a joint's free angle may end beyond its limits
  }
}

TEST_P(ClosedForm, GivesTheSameAnswersEachTime) {
  RandomConfigurations configurations(arm_, 14);
  for (int k = 0; k < 50; ++k) {
    const Pose X_AT = arm_.toolPose(configurations.next());
    std::vector<ArmVector> first, second;
    arm_.solve(X_AT, {}, first);
    const ArmKinematics again(model_, ArmId(0));
    again.solve(X_AT, {}, second);
    ASSERT_EQ(first.size(), second.size());
    for (std::size_t i = 0; i < first.size(); ++i) EXPECT_EQ(first[i], second[i]);
  }
}

TEST_P(ClosedForm, AnswersOfFewSwivelSamplesAreThoseOfMoreToo) {
  // The sample order is spread evenly from the start: the angles of 8 are the first 8 of 32.
  RandomConfigurations configurations(arm_, 15);
  for (int k = 0; k < 100; ++k) {
    const Pose X_AT = arm_.toolPose(configurations.next());
    std::vector<ArmVector> few, many;
    IkQuery query;
    query.swivel_samples = 8;
    arm_.solve(X_AT, query, few);
    query.swivel_samples = 32;
    arm_.solve(X_AT, query, many);
    ASSERT_LE(few.size(), many.size());
    for (std::size_t i = 0; i < few.size(); ++i) EXPECT_EQ(few[i], many[i]);
  }
}

TEST_P(ClosedForm, VisitingGivesTheSameAnswersUntilOneHasEnough) {
  RandomConfigurations configurations(arm_, 20);
  for (int k = 0; k < 100; ++k) {
    const Pose X_AT = arm_.toolPose(configurations.next());
    std::vector<ArmVector> all, first;
    arm_.solve(X_AT, {}, all);
    const std::size_t wanted = std::min<std::size_t>(all.size(), 3);
    if (wanted == 0) continue;
    const IkCounts counts = arm_.visit(X_AT, {}, [&](const ArmVector& q) {
      first.push_back(q);
      return first.size() < wanted;
    });
    EXPECT_EQ(counts.solutions, wanted);
    ASSERT_EQ(first.size(), wanted);
    for (std::size_t i = 0; i < wanted; ++i) EXPECT_EQ(first[i], all[i]);
  }
}

TEST_P(ClosedForm, BranchesOfOneSwivelAngleDiffer) {
  RandomConfigurations configurations(arm_, 16);
  std::size_t most = 0;
  for (int k = 0; k < 500; ++k) {
    const Pose X_AT = arm_.toolPose(configurations.next());
    std::vector<ArmVector> out;
    IkQuery query;
    query.swivel_samples = 1;
    query.swivel_offset = kTurn * configurations.fraction();
    const IkCounts counts = arm_.solve(X_AT, query, out);
    EXPECT_LE(out.size(), 8u);
    EXPECT_LE(counts.solutions + counts.limits, 8u);
    most = std::max(most, out.size());
    for (std::size_t i = 0; i < out.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) EXPECT_GT((out[i] - out[j]).norm(), 1e-6);
    }
  }
  EXPECT_GE(most, 2u);
}

TEST(ArmKinematics, GivesEveryWindingWithinTheLimits) {
  const ArmKinematics arm(lwa4TwoTurnArm(), ArmId(0));
  RandomConfigurations configurations(arm, 17);
  for (int k = 0; k < 100; ++k) {
    const Pose X_AT = arm.toolPose(configurations.next());
    IkQuery query;
    query.swivel_samples = 2;
    std::vector<ArmVector> nearest, all;
    arm.solve(X_AT, query, nearest);
    query.all_windings = true;
    const IkCounts counts = arm.solve(X_AT, query, all);
    EXPECT_EQ(counts.solutions, all.size());
    std::size_t expected = 0;
    for (const ArmVector& q : nearest) {
      std::size_t copies = 1;
      for (const int i : {0, 2, 4, 6}) {
        std::size_t within = 0;
        for (int turns = -3; turns <= 3; ++turns) {
          const double copy = q[i] + kTurn * turns;
          within += copy >= arm.lower()[i] && copy <= arm.upper()[i] ? 1 : 0;
        }
        copies *= within;
      }
      EXPECT_GE(copies, 16u);  // four joints of two turns
      expected += copies;
    }
    EXPECT_EQ(all.size(), expected);
    for (const ArmVector& q : all) {
      EXPECT_TRUE(arm.withinLimits(q, 0));
      EXPECT_LT(poseDistance(arm.toolPose(q), X_AT), 2e-9);
    }
  }
}

TEST(ArmKinematics, PrefersTheWindingNearestToTheGivenConfiguration) {
  const ArmKinematics arm(lwa4TwoTurnArm(), ArmId(0));
  RandomConfigurations configurations(arm, 18);
  for (int k = 0; k < 200; ++k) {
    IkQuery query;
    query.q_near = configurations.next();
    std::vector<ArmVector> out;
    arm.solve(arm.toolPose(configurations.next()), query, out);
    for (const ArmVector& q : out) {
      for (const int i : {0, 2, 4, 6}) {
        for (const double turn : {-kTurn, kTurn}) {
          const double other = q[i] + turn;
          if (other < arm.lower()[i] || other > arm.upper()[i]) continue;
          EXPECT_LE(std::abs(q[i] - query.q_near[i]), std::abs(other - query.q_near[i]) + 1e-9);
        }
      }
    }
  }
}

TEST(ArmKinematics, KnowsBothElbowSignsOfTheHuboArmNearFullStretch) {
  const ArmKinematics arm(huboArm(1), ArmId(0));
  const Eigen::Vector3d S = arm.shoulder();
  RandomConfigurations configurations(arm, 19);
  // Of equal distance S-W: elbow angles mirrored about -0.19498; the upper limit is 0.2.
  constexpr double kMirror = -0.1949836;
  const auto elbowsAt = [&](double elbow) {
    std::pair<int, int> found{0, 0};
    for (int k = 0; k < 200; ++k) {
      ArmVector q = configurations.next();
      q[3] = elbow;
      std::vector<ArmVector> out;
      arm.solve(arm.toolPose(q), {}, out);
      for (const ArmVector& answer : out) {
        const double offset = std::abs(answer[3] - kMirror) - std::abs(elbow - kMirror);
        EXPECT_NEAR(offset, 0, 1e-5);
        ++(answer[3] > kMirror ? found.first : found.second);
      }
    }
    return found;
  };
  const auto [above_near, below_near] = elbowsAt(kMirror - 0.3);  // 0.105 is within the limits too
  EXPECT_GT(above_near, 100);
  EXPECT_GT(below_near, 100);
  const auto [above_far, below_far] = elbowsAt(kMirror - 0.5);  // 0.305 is not
  EXPECT_EQ(above_far, 0);
  EXPECT_GT(below_far, 100);

  // |SW| = 0.6138 at EP = 0, and 0.61673 at most.
  ArmVector q = ArmVector::Zero(7);
  const auto wristDistance = [&] {
    const Pose X_AT = arm.toolPose(q);
    return (X_AT * Eigen::Vector3d(0, 0, 0.1575) - S).norm();
  };
  EXPECT_NEAR(wristDistance(), 0.6138, 1e-6);
  q[3] = kMirror;
  EXPECT_NEAR(wristDistance(), 0.61673, 1e-5);
}

TEST(ArmKinematics, CountsWhatFallsToTheLimits) {
  RobotModel model = lwa4Arm();
  model.joints[3].lower = 0.1;  // no elbow angle of this pose lies in the limits
  model.joints[3].upper = 0.2;
  const Pose X_AT =
      ArmKinematics(lwa4Arm(), ArmId(0)).toolPose(degrees({10, 20, 30, 60, 50, 60, 70}));
  std::vector<ArmVector> out;
  IkQuery query;
  query.swivel_samples = 4;
  const IkCounts counts = ArmKinematics(model, ArmId(0)).solve(X_AT, query, out);
  EXPECT_EQ(counts.solutions, 0u);
  EXPECT_EQ(counts.no_ik, 0u);
  EXPECT_EQ(counts.limits, 4u * 8u);
}

TEST(ArmKinematics, RefusesNearConfigurationsOfTheWrongSize) {
  const ArmKinematics arm(lwa4Arm(), ArmId(0));
  IkQuery query;
  query.q_near = ArmVector::Zero(6);
  std::vector<ArmVector> out;
  EXPECT_THROW(arm.solve(Pose::Identity(), query, out), std::invalid_argument);
}

class Iterative : public ClosedForm {};

INSTANTIATE_TEST_SUITE_P(ArmKinematics, Iterative, testing::ValuesIn(armsWithClosedForm(false)),
                         armName);

TEST_P(Iterative, SolvesWhatItReachesAndEveryAnswerIsRight) {
  constexpr int kPoses = 2'500;
  RandomConfigurations configurations(arm_, 21);
  int solved = 0, solved_soon = 0;
  std::size_t answers = 0;
  for (int k = 0; k < kPoses; ++k) {
    const Pose X_AT = arm_.toolPose(configurations.next());
    std::vector<ArmVector> out;
    IkQuery query;
    query.swivel_samples = 8;  // as grasps are pruned
    const IkCounts counts = arm_.solve(X_AT, query, out);
    ASSERT_EQ(counts.solutions, out.size());
    solved_soon += out.empty() ? 0 : 1;
    answers += out.size();
    for (std::size_t i = 0; i < out.size(); ++i) {
      ASSERT_TRUE(arm_.withinLimits(out[i], 0));
      ASSERT_LT(poseDistance(arm_.toolPose(out[i]), X_AT), 2e-9);
      for (std::size_t j = 0; j < i; ++j) EXPECT_GT((out[i] - out[j]).norm(), 0.01);
    }
    if (out.empty()) arm_.solve(X_AT, {}, out);
    solved += out.empty() ? 0 : 1;
  }
  EXPECT_GE(solved_soon, kPoses * 0.99);
  EXPECT_GE(solved, kPoses * 0.999);
  RecordProperty("solved_soon", solved_soon);
  RecordProperty("solved", solved);
  RecordProperty("answers", static_cast<int>(answers));
}

TEST_P(Iterative, GivesTheSameAnswersEachTime) {
  RandomConfigurations configurations(arm_, 22);
  const Pose X_AT = arm_.toolPose(configurations.next());
  std::vector<ArmVector> first, second;
  arm_.solve(X_AT, {}, first);
  arm_.solve(X_AT, {}, second);
  EXPECT_EQ(first, second);
}

TEST_P(Iterative, VisitingEndsWhenOneHasEnough) {
  RandomConfigurations configurations(arm_, 23);
  for (int k = 0; k < 20; ++k) {
    const Pose X_AT = arm_.toolPose(configurations.next());
    std::vector<ArmVector> all, first;
    arm_.solve(X_AT, {}, all);
    const IkCounts counts = arm_.visit(X_AT, {}, [&](const ArmVector& q) {
      first.push_back(q);
      return false;
    });
    EXPECT_EQ(counts.solutions, first.size());
    ASSERT_EQ(first.size(), std::min<std::size_t>(all.size(), 1));
    if (!first.empty()) {
      EXPECT_EQ(first[0], all[0]);
    }
  }
}

TEST_P(Iterative, RefusesPosesOutOfReachOrNotFinite) {
  std::vector<ArmVector> out;
  Pose X_AT = Pose::Identity();
  X_AT.translation().x() = arm_.reach() + 1;
  EXPECT_EQ(arm_.solve(X_AT, {}, out).no_ik, 1u);
  X_AT.translation().x() = std::nan("");
  EXPECT_EQ(arm_.solve(X_AT, {}, out).no_ik, 1u);
  X_AT.translation().x() = 1e300;
  EXPECT_EQ(arm_.solve(X_AT, {}, out).no_ik, 1u);
  EXPECT_TRUE(out.empty());
}

TEST(ArmKinematics, OffersShoulderElbowAndWristOfSixJointsBothWays) {
  // Such an arm has up to eight configurations for a pose; few poses allow fewer than four.
  const ArmKinematics arm(ur5eArm(), ArmId(0));
  RandomConfigurations configurations(arm, 24);
  constexpr int kPoses = 500;
  int several = 0;
  std::size_t answers = 0;
  for (int k = 0; k < kPoses; ++k) {
    std::vector<ArmVector> out;
    arm.solve(arm.toolPose(configurations.next()), {}, out);
    EXPECT_LE(out.size(), 8u);
    several += out.size() >= 4 ? 1 : 0;
    answers += out.size();
    for (std::size_t i = 0; i < out.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {  // not the same posture a turn farther
        ArmVector apart = out[i] - out[j];
        for (double& angle : apart) angle = std::remainder(angle, kTurn);
        EXPECT_GT(apart.cwiseAbs().maxCoeff(), 0.009);
      }
    }
  }
  EXPECT_GE(several, kPoses * 0.9);
  RecordProperty("answers", static_cast<int>(answers));
}

TEST(ArmKinematics, FindsTheOneElbowThatAPlanarPoseAllows) {
  const ArmKinematics arm(planarArm(), ArmId(0));
  ArmVector q(2);
  q << 0.4, 1.1;
  std::vector<ArmVector> out;
  arm.solve(arm.toolPose(q), {}, out);
  ASSERT_EQ(out.size(), 1u);  // the other elbow turns the tool, which the pose does not allow
  EXPECT_NEAR((out[0] - q).norm(), 0, 1e-7);
}

}  // namespace
}  // namespace handover::test
