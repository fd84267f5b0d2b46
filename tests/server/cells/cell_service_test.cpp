// SPDX-License-Identifier: Apache-2.0
// The whole planning side without DDS: the butler cell from its files to fourteen stages.
#include "butler_service.hpp"
#include "core/kinematics/arm_kinematics.hpp"
#include "settings/roots.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

namespace handover::test {
namespace {

TEST(CellService, PlansTheNominalButlerInFourteenStages) {
  const Answer answer = ask(butlerRequest());
  ASSERT_TRUE(std::holds_alternative<Done>(answer.outcome)) << answer.outcome.index();
  const auto stages = answer.all<StageTrajectory>();
  ASSERT_EQ(stages.size(), static_cast<std::size_t>(kStageCount));
  for (std::size_t i = 0; i < stages.size(); ++i) {
    EXPECT_EQ(stages[i].index, i);
    EXPECT_EQ(static_cast<std::size_t>(stages[i].kind), i + 1);
  }
}

TEST(CellService, FindsThatTheFreeHandTakesTheCup) {
  const Answer answer = ask(butlerRequest());
  ASSERT_TRUE(std::holds_alternative<Done>(answer.outcome));
  const auto arms = answer.all<ArmSelected>();
  ASSERT_EQ(arms.size(), 1u);
  EXPECT_EQ(arms[0].receiver_arm, "left");
  for (const auto& score : arms[0].scores) {
    if (score.robot == "hubo" && score.arm == "right") {
      EXPECT_EQ(score.rejected, "holds tray");
    }
  }
}

TEST(CellService, DexteritiesAreThoseOfTheConfigurationsReached) {
  const Answer answer = ask(butlerRequest());
  ASSERT_TRUE(std::holds_alternative<Done>(answer.outcome));
  const Solution solution = answer.all<Solution>().at(0);
  ModelCache models;
  const Cell cell =
      Cell::load(cellFile("butler", HANDOVER_SOURCE_DIR), HANDOVER_SOURCE_DIR, models);
  const auto at_end_of = [&](StageKind kind, const char* robot, const std::string& arm_name) {
    for (const StageTrajectory& stage : answer.all<StageTrajectory>()) {
      if (stage.kind != kind) continue;
      const RobotModel& model = *models.at(robot);
      const int arm = model.findArm(arm_name);
      const auto& dofs = model.arms.at(static_cast<std::size_t>(arm)).dofs;
      ArmVector q(static_cast<Eigen::Index>(dofs.size()));
      for (std::size_t i = 0; i < dofs.size(); ++i) {
        const auto joint =
            static_cast<std::size_t>(model.dof_joints.at(static_cast<std::size_t>(dofs[i])));
        const auto name =
            std::find(stage.joints.begin(), stage.joints.end(), model.joints.at(joint).name);
        q[static_cast<Eigen::Index>(i)] =
            stage.q.back().at(static_cast<std::size_t>(name - stage.joints.begin()));
      }
      return ArmKinematics(model, arm).manipulability(q);
    }
    return 0.0;
  };
  const Dexterity& d = solution.dexterity;
  const std::string &g = solution.giver_arm, &r = solution.receiver_arm;
  EXPECT_NEAR(d.giver_pick, at_end_of(StageKind::kGiverApproach, "crichton", g), 1e-9);
  EXPECT_NEAR(d.giver_handover, at_end_of(StageKind::kGiverTransfer, "crichton", g), 1e-9);
  EXPECT_NEAR(d.receiver_handover, at_end_of(StageKind::kReceiverApproach, "hubo", r), 1e-9);
  EXPECT_NEAR(d.receiver_place, at_end_of(StageKind::kReceiverPlace, "hubo", r), 1e-9);
}

TEST(CellService, SaysWhyAReceiverSixMetresAwayCannot) {
  PlanRequest request = butlerRequest({{"robots.hubo.base.xyz", "[6, -0.3, 0.98]"}});
  request.mode = SearchMode::kFirst;  // without a search for what would help
  const Answer answer = ask(request);
  const auto* failed = std::get_if<Failed>(&answer.outcome);
  ASSERT_NE(failed, nullptr);
  EXPECT_EQ(failed->reason, FailureReason::kNoCommonWorkspace);
  EXPECT_FALSE(failed->explanation.text.empty());
}

struct Hopeless {
  const char* name;
  std::vector<Override> overrides;
  FailureReason reason;
  std::string culprit;  // one of the causes names it; empty: no pair is asked for
};

class CellServiceFailure : public testing::TestWithParam<Hopeless> {};

TEST_P(CellServiceFailure, NamesTheFilterThatEmptied) {
  PlanRequest request = butlerRequest(GetParam().overrides);
  request.mode = SearchMode::kFirst;
  const Answer answer = ask(request);
  const auto* failed = std::get_if<Failed>(&answer.outcome);
  ASSERT_NE(failed, nullptr) << answer.outcome.index();
  EXPECT_EQ(failed->reason, GetParam().reason) << toString(failed->reason);
  EXPECT_FALSE(failed->explanation.text.empty());
  bool named = GetParam().culprit.empty();
  for (const auto& cause : failed->explanation.causes) {
    EXPECT_GT(cause.count, 0u);
    named =
        named || cause.pair.first == GetParam().culprit || cause.pair.second == GetParam().culprit;
  }
  EXPECT_TRUE(named) << GetParam().culprit;
}

const Override kInWorld{"tasks.serve.goal.frame", "world"};

INSTANTIATE_TEST_SUITE_P(
    Butler, CellServiceFailure,
    testing::Values(Hopeless{"CupInTheCarton",
                             {{"objects.cup.pose.xyz", "[0.35, -0.80, 0.80]"}},
                             FailureReason::kStartInCollision,
                             "milk_carton"},
                    Hopeless{"CupFarAway",
                             {{"objects.cup.pose.xyz", "[-2, -2, 1]"}},
                             FailureReason::kStartUnreachable,
                             "crichton/right"},
                    Hopeless{"GoalInTheTable",
                             {kInWorld, {"tasks.serve.goal.xyz", "[0.5, 0, 0.69]"}},
                             FailureReason::kGoalInCollision,
                             "table"},
                    Hopeless{"GoalFarAway",
                             {kInWorld, {"tasks.serve.goal.xyz", "[3, 3, 1]"}},
                             FailureReason::kGoalUnreachable,
                             "hubo/left"},
                    Hopeless{"CupUnderATable",
                             {{"objects.table.pose.xyz", "[-0.5, -1.2, 0.36]"}},
                             FailureReason::kNoGraspAtStart,
                             "table"}),
    [](const auto& one) { return one.param.name; });

TEST(CellService, RejectsWhatIsNotFiniteOrUnknown) {
  for (const Override& bad : {Override{"robots.hubo.base.xyz", "[.nan, 0, 0]"},
                              Override{"robots.nobody.base.xyz", "[0, 0, 0]"},
                              Override{"objects.cup.pose.xyz", "north"}}) {
    const Answer answer = ask(butlerRequest({bad}));
    const auto* rejected = std::get_if<Rejected>(&answer.outcome);
    ASSERT_NE(rejected, nullptr) << bad.path;
    ASSERT_FALSE(rejected->faults.empty());
    EXPECT_EQ(rejected->faults[0].field, bad.path);
  }
}

/// A request that needs grasps which no cache has, and thousands of them.
PlanRequest largeRequest() {
  return butlerRequest({{"objects.cup.grasps.crichton.right_hand", "9999"}});
}

TEST(CellService, DeadlineAndCancelEndTheMakingOfGrasps) {
  using namespace std::chrono_literals;
  butlerService();
  const Answer late = ask(largeRequest(), Deadline(std::chrono::steady_clock::now() + 50ms));
  const auto* failed = std::get_if<Failed>(&late.outcome);
  ASSERT_NE(failed, nullptr);
  EXPECT_EQ(failed->reason, FailureReason::kDeadline);

  const Deadline deadline;
  std::jthread cancel([&deadline] {
    std::this_thread::sleep_for(50ms);
    deadline.cancel();
  });
  EXPECT_TRUE(std::holds_alternative<Cancelled>(ask(largeRequest(), deadline).outcome));
}

TEST(CellService, OneThatMakesGraspsHoldsUpNobodyElse) {
  butlerService();
  const Deadline deadline;
  std::atomic<bool> ended = false;
  std::jthread large([&] {
    ask(largeRequest(), deadline);
    ended = true;
  });
  EXPECT_TRUE(std::holds_alternative<Done>(ask(butlerRequest()).outcome));
  EXPECT_FALSE(ended);
  deadline.cancel();
}

TEST(CellService, CancelledBeforehandSaysSo) {
  const Deadline deadline;
  deadline.cancel();
  EXPECT_TRUE(std::holds_alternative<Cancelled>(ask(butlerRequest(), deadline).outcome));
}

}  // namespace
}  // namespace handover::test
