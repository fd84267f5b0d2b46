// SPDX-License-Identifier: Apache-2.0
#include "sample_events.hpp"

#include <handover/client/answer.hpp>
#include <handover/client/plan_motion.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace handover::client {
namespace {

/// A joint on the curve q = t^5 - 2 t^3 + t, sampled as a stage.
StageTrajectory quinticStage() {
  StageTrajectory stage{.robot = "hubo", .joints = {"RSP"}, .start = 1};
  for (const double t : {0.0, 0.4, 1.5}) {
    stage.t.push_back(t);
    stage.q.push_back({std::pow(t, 5) - 2 * std::pow(t, 3) + t});
    stage.qd.push_back({5 * std::pow(t, 4) - 6 * t * t + 1});
    stage.qdd.push_back({20 * std::pow(t, 3) - 12 * t});
  }
  return stage;
}

PlanFile fileOf(std::vector<StageTrajectory> stages) {
  PlanFile file;
  file.scene = test::sampleScene();
  file.plan = Plan{test::sampleSolution(), std::move(stages)};
  return file;
}

TEST(SampleStage, IsExactOnAQuinticAndItsDerivatives) {
  const StageTrajectory stage = quinticStage();
  for (double t = 0; t <= 1.5; t += 0.01) {
    const JointState state = sampleStage(stage, 0, t);
    EXPECT_NEAR(state.q, std::pow(t, 5) - 2 * std::pow(t, 3) + t, 1e-12);
    EXPECT_NEAR(state.qd, 5 * std::pow(t, 4) - 6 * t * t + 1, 1e-11);
    EXPECT_NEAR(state.qdd, 20 * std::pow(t, 3) - 12 * t, 1e-10);
  }
}

TEST(SampleStage, GoesThroughItsSamplesAndHoldsItsEnds) {
  const StageTrajectory stage = quinticStage();
  for (std::size_t i = 0; i < stage.t.size(); ++i) {
    const JointState state = sampleStage(stage, 0, stage.t[i]);
    EXPECT_EQ(state, (JointState{stage.q[i][0], stage.qd[i][0], stage.qdd[i][0]}));
  }
  EXPECT_EQ(sampleStage(stage, 0, -1).q, stage.q.front()[0]);
  EXPECT_EQ(sampleStage(stage, 0, 9).q, stage.q.back()[0]);
}

TEST(PlanMotion, JointsStandBeforeAndAfterTheirStages) {
  const StageTrajectory stage = quinticStage();
  const PlanMotion motion(fileOf({stage}));
  EXPECT_EQ(motion.duration(), 2.5);
  // RSP and TSY of hubo; TSY is in no stage.
  EXPECT_THAT(motion.sample(0, 0.5),
              testing::ElementsAre(JointState{0.1, 0, 0}, JointState{-1.0 / 3.0, 0, 0}));
  EXPECT_EQ(motion.sample(0, 1.7)[0], sampleStage(stage, 0, 1.7 - 1));
  EXPECT_EQ(motion.sample(0, 3)[0], (JointState{stage.q[2][0], 0, 0}));
  EXPECT_EQ(motion.sample(1, 1.7)[0], (JointState{0.1, 0, 0}));  // another robot's
  EXPECT_THAT(motion.running(0.5), testing::IsEmpty());
  EXPECT_THAT(motion.running(1), testing::ElementsAre(0u));
  EXPECT_THAT(motion.running(2.5), testing::IsEmpty());
}

TEST(PlanMotion, TakesTheLastStageThatBeganWhateverTheOrderOfTheList) {
  StageTrajectory later = quinticStage(), earlier = quinticStage();
  later.start = 4;
  for (auto& row : later.q) row[0] += 10;
  const PlanMotion motion(fileOf({later, earlier}));
  EXPECT_EQ(motion.sample(0, 3.9)[0].q, earlier.q[2][0]);
  EXPECT_EQ(motion.sample(0, 4)[0].q, later.q[0][0]);
  EXPECT_THAT(motion.running(4.5), testing::ElementsAre(0u));
}

TEST(PlanMotion, PlaysAWholePlanOfThreeHolders) {
  Answer answer;
  for (const PlanEvent& event : test::sampleAnswer(RequestId{}, 0.001, 3)) answer.add(event);
  const PlanMotion motion(parsePlanFile(answer.text()));
  EXPECT_EQ(motion.plan().stages.size(), 23u);
  EXPECT_EQ(motion.duration(), 0.5 * 23);
  EXPECT_EQ(motion.sample(1, 0.25)[0].q, 0.05);  // crichton reaches
}

TEST(PlanMotion, RefusesWhatItCannotPlay) {
  EXPECT_THROW(PlanMotion({}), PlanFileError);
  PlanFile none = fileOf({});
  none.plan.reset();
  EXPECT_THROW(PlanMotion{none}, PlanFileError);
  StageTrajectory stage = quinticStage();
  stage.joints = {"elbow"};
  EXPECT_THROW(PlanMotion(fileOf({stage})), PlanFileError);
  stage = quinticStage();
  stage.robot = "nobody";
  EXPECT_THROW(PlanMotion(fileOf({stage})), PlanFileError);
}

}  // namespace
}  // namespace handover::client
