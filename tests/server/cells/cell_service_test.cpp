// SPDX-License-Identifier: Apache-2.0
// The whole planning side without DDS: the butler cell from its files to sixteen stages.
#include "butler_service.hpp"
#include "core/kinematics/arm_kinematics.hpp"
#include "settings/roots.hpp"
#include "support/meshes.hpp"
#include "support/temporary_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <sstream>
#include <thread>

namespace handover::test {
namespace {

TEST(CellService, PlansTheNominalButlerInSixteenStages) {
  using enum StageAction;
  const std::vector<StageRef> expected{{0, kReach},   {0, kApproach}, {0, kGrasp},    {0, kLift},
                                       {0, kCarry},   {1, kReach},    {1, kApproach}, {1, kGrasp},
                                       {0, kRelease}, {0, kRetreat},  {0, kHome},     {1, kCarry},
                                       {1, kPlace},   {1, kRelease},  {1, kRetreat},  {1, kHome}};
  const Answer answer = ask(butlerRequest());
  ASSERT_TRUE(std::holds_alternative<Done>(answer.outcome)) << answer.outcome.index();
  const auto stages = answer.all<StageTrajectory>();
  ASSERT_EQ(stages.size(), expected.size());
  EXPECT_EQ(answer.all<Solution>().back().stage_count, expected.size());
  for (std::size_t i = 0; i < stages.size(); ++i) {
    EXPECT_EQ(stages[i].index, i);
    EXPECT_EQ((StageRef{stages[i].holder, stages[i].action}), expected[i]) << i;
    EXPECT_EQ(stages[i].robot, stages[i].holder == 0 ? "crichton" : "hubo") << i;
  }
}

TEST(CellService, FindsThatTheFreeHandTakesTheCup) {
  const Answer answer = ask(butlerRequest());
  ASSERT_TRUE(std::holds_alternative<Done>(answer.outcome));
  const auto arms = answer.all<ArmSelected>();
  ASSERT_EQ(arms.size(), 1u);
  ASSERT_EQ(arms[0].holders.size(), 2u);
  EXPECT_EQ(arms[0].holders[1], (ArmName{"hubo", "left"}));
  int looked_at = 0;
  for (const auto& score : arms[0].scores) {
    if (score.arm != ArmName{"hubo", "right"}) continue;
    ++looked_at;
    EXPECT_EQ(score.rejected, Cause::kHoldsObject);
    EXPECT_EQ(score.object, "tray");
  }
  EXPECT_EQ(looked_at, 1);
}

TEST(CellService, DexteritiesAreThoseOfTheConfigurationsReached) {
  const Answer answer = ask(butlerRequest());
  ASSERT_TRUE(std::holds_alternative<Done>(answer.outcome));
  const Solution solution = answer.all<Solution>().at(0);
  ModelCache models;
  const Cell cell =
      Cell::load(cellFile("butler", HANDOVER_SOURCE_DIR), HANDOVER_SOURCE_DIR, models);
  const auto at_end_of = [&](std::uint32_t holder, StageAction action) {
    for (const StageTrajectory& stage : answer.all<StageTrajectory>()) {
      if (stage.holder != holder || stage.action != action) continue;
      const ArmName& holding = solution.holders.at(holder).arm;
      const RobotModel& model = *models.at(holding.robot);
      const ArmId arm = model.findArm(holding.arm);
      const auto& dofs = model.arms.at(arm).dofs;
      ArmVector q(static_cast<Eigen::Index>(dofs.size()));
      for (std::size_t i = 0; i < dofs.size(); ++i) {
        const JointId joint = model.dof_joints.at(dofs[i]);
        const auto name =
            std::find(stage.joints.begin(), stage.joints.end(), model.joints.at(joint).name);
        q[static_cast<Eigen::Index>(i)] =
            stage.q.back().at(static_cast<std::size_t>(name - stage.joints.begin()));
      }
      return ArmKinematics(model, arm).manipulability(q);
    }
    return 0.0;
  };
  ASSERT_EQ(solution.holders.size(), 2u);
  const Dexterity &g = solution.holders[0].dexterity, &r = solution.holders[1].dexterity;
  EXPECT_NEAR(g.take, at_end_of(0, StageAction::kApproach), 1e-9);
  EXPECT_NEAR(g.give, at_end_of(0, StageAction::kCarry), 1e-9);
  EXPECT_NEAR(r.take, at_end_of(1, StageAction::kApproach), 1e-9);
  EXPECT_NEAR(r.give, at_end_of(1, StageAction::kPlace), 1e-9);
}

TEST(CellService, SaysWhyAReceiverSixMetresAwayCannot) {
  PlanRequest request = butlerRequest({{"robots.hubo.base.xyz", "[6, -0.3, 0.98]"}});
  request.wants_fix = false;
  const Answer answer = ask(request);
  const auto* failed = std::get_if<Failed>(&answer.outcome);
  ASSERT_NE(failed, nullptr);
  EXPECT_EQ(failed->reason, FailureReason::kNoCommonWorkspace);
  EXPECT_TRUE(failed->explanation.exhaustive);
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
  request.wants_fix = false;
  const Answer answer = ask(request);
  const auto* failed = std::get_if<Failed>(&answer.outcome);
  ASSERT_NE(failed, nullptr) << answer.outcome.index();
  EXPECT_EQ(failed->reason, GetParam().reason) << toString(failed->reason);
  EXPECT_FALSE(failed->explanation.text.empty());
  EXPECT_TRUE(failed->explanation.exhaustive);
  const auto said = answer.all<Failure>();  // as soon as it was known
  ASSERT_EQ(said.size(), 1u);
  EXPECT_EQ(said[0], (Failure{failed->reason, failed->explanation}));
  ASSERT_FALSE(failed->explanation.causes.empty());
  if (failed->explanation.causes.front().cause == Cause::kCollision) {
    EXPECT_FALSE(failed->explanation.causes.front().pair.second.empty());
  }
  bool named = GetParam().culprit.empty();
  for (const auto& cause : failed->explanation.causes) {
    EXPECT_GT(cause.count, 0u);
    named =
        named || cause.pair.first == GetParam().culprit || cause.pair.second == GetParam().culprit;
  }
  EXPECT_TRUE(named) << GetParam().culprit;
}

/// A lid on four walls, about the cup.
constexpr const char* kHood = R"({type: compound, parts: [
  {name: lid, pose: {xyz: [0, 0, 0.085]}, geometry: {type: box, size: [0.21, 0.21, 0.01]}},
  {name: front, pose: {xyz: [0.1, 0, 0]}, geometry: {type: box, size: [0.01, 0.21, 0.155]}},
  {name: back, pose: {xyz: [-0.1, 0, 0]}, geometry: {type: box, size: [0.01, 0.21, 0.155]}},
  {name: left, pose: {xyz: [0, 0.1, 0]}, geometry: {type: box, size: [0.21, 0.01, 0.155]}},
  {name: right, pose: {xyz: [0, -0.1, 0]}, geometry: {type: box, size: [0.21, 0.01, 0.155]}}]})";

const Override kInWorld{"tasks.serve.goal.frame", "world"};

INSTANTIATE_TEST_SUITE_P(
    Butler, CellServiceFailure,
    testing::Values(
        Hopeless{"CupInTheCarton",
                 {{"objects.cup.pose.xyz", "[0.35, -0.80, 0.80]"}},
                 FailureReason::kStartInCollision,
                 "milk_carton"},
        Hopeless{"CartonInTheOtherCup",
                 {{"objects.milk_carton.pose.xyz", "[0.47, -0.67, 0.8126]"}},
                 FailureReason::kStartInCollision,
                 "coffee_cup"},
        Hopeless{"CartonAsLargeAsTheRoom",
                 {{"objects.milk_carton.geometry.scale", "[60, 60, 60]"}},
                 FailureReason::kStartInCollision,
                 "milk_carton"},
        Hopeless{"CupFarAway",
                 {{"objects.cart_left.pose.xyz", "[-2.6, -2.35, 0.01]"},
                  {"objects.cup.pose.xyz", "[-2, -2, 0.903]"}},
                 FailureReason::kStartUnreachable,
                 "crichton/right"},
        Hopeless{"CupAboveTheCart",
                 {{"objects.cup.pose.xyz", "[-0.20, -0.70, 0.908]"}},
                 FailureReason::kStartUnsupported,
                 "cart_left"},
        Hopeless{"GoalAboveTheTray",
                 {{"tasks.serve.goal.xyz", "[0, 0, 0.087]"}},
                 FailureReason::kGoalUnsupported,
                 "tray"},
        Hopeless{"GoalInTheTable",
                 {kInWorld, {"tasks.serve.goal.xyz", "[0.5, 0, 0.69]"}},
                 FailureReason::kGoalInCollision,
                 "table"},
        Hopeless{"GoalFarAway",
                 {kInWorld, {"tasks.serve.goal.xyz", "[3, 3, 1]"}, {"tasks.serve.end", "hold"}},
                 FailureReason::kGoalUnreachable,
                 "hubo/left"},
        Hopeless{"CupUnderAHood",
                 {{"objects.milk_carton.geometry", kHood},
                  {"objects.milk_carton.pose.xyz", "[-0.20, -0.70, 0.91]"}},
                 FailureReason::kNoGraspAtStart,
                 "milk_carton"}),
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

/// The text of a Wavefront file.
std::string objOf(const TriangleMesh& mesh) {
  std::ostringstream text;
  for (const Eigen::Vector3d& v : mesh.vertices) text << "v " << v.transpose() << "\n";
  for (const auto& t : mesh.triangles) {
    text << "f " << t[0] + 1 << " " << t[1] + 1 << " " << t[2] + 1 << "\n";
  }
  return text.str();
}

TEST(CellService, AMeshThatARequestBringsIsDividedBeforeItIsPlanned) {
  butlerService();  // its maps and grasps are kept
  const TemporaryFolder root, cache;
  const std::filesystem::path source = HANDOVER_SOURCE_DIR, binary = HANDOVER_BINARY_DIR;
  for (const char* folder : {"robots", "config"}) {
    std::filesystem::create_directory_symlink(source / folder, root / folder);
  }
  for (const char* folder : {"maps", "grasps"}) {
    std::filesystem::create_directory_symlink(binary / "test-cache/handover" / folder,
                                              cache / folder);
  }
  root.write("angle.obj", objOf(angleMesh()));
  CellService service(root.path(), {"butler"}, cache.path(), {}, false);
  service.prepareAll(Deadline());
  const PlanRequest request =
      butlerRequest({{"objects.milk_carton.geometry", "{type: mesh, path: angle.obj}"},
                     {"objects.milk_carton.pose.xyz", "[3, 3, 0.5]"}});
  Recorder recorder;
  const auto alone = [] { return false; };
  EXPECT_FALSE(service.plan(*service.served(), request, recorder, Deadline(), alone));
  EXPECT_TRUE(recorder.events.empty());
  const Deadline passed(Deadline::Clock::now());
  service.prepare(*service.served(), request, passed);
  EXPECT_FALSE(service.plan(*service.served(), request, recorder, Deadline(), alone));
  service.prepare(*service.served(), request, Deadline());
  EXPECT_TRUE(service.plan(*service.served(), request, recorder, Deadline(), alone));
  EXPECT_FALSE(std::filesystem::is_empty(cache / "parts"));
}

TEST(CellService, AStartInTheCartIsToldBeforeGraspsAreMade) {
  Recorder recorder;
  const PlanRequest request = butlerRequest({{"objects.cup.geometry.scale", "[1.234, 1.2, 1.2]"}});
  const auto outcome = butlerService().plan(*butlerService().served(), request, recorder,
                                            Deadline(), [] { return false; });
  ASSERT_TRUE(outcome);
  const auto* failed = std::get_if<Failed>(&*outcome);
  ASSERT_NE(failed, nullptr);
  EXPECT_EQ(failed->reason, FailureReason::kStartInCollision);
  EXPECT_EQ(recorder.all<SceneSnapshot>().size(), 1u);
  EXPECT_EQ(recorder.all<Failure>().size(), 1u);
}

TEST(CellService, AChainOfTheRequestIsHeldAgainstTheArmThatHasTheObject) {
  const auto faultsOf = [](std::vector<std::string> chain) -> std::vector<Fault> {
    PlanRequest request = butlerRequest({{"tasks.serve.start", "{held_by: hubo/left}"}});
    request.chain = std::move(chain);
    const Answer answer = ask(request, Deadline(Deadline::Clock::now()));
    const auto* rejected = std::get_if<Rejected>(&answer.outcome);
    return rejected == nullptr ? std::vector<Fault>() : rejected->faults;
  };
  EXPECT_TRUE(faultsOf({"hubo/left"}).empty());
  EXPECT_TRUE(faultsOf({"hubo"}).empty());
  EXPECT_TRUE(faultsOf({"auto"}).empty());
  ASSERT_EQ(faultsOf({"crichton/right", "hubo/left"}).size(), 1u);
  EXPECT_EQ(faultsOf({"crichton/right", "hubo/left"})[0].field, "chain");
  ASSERT_EQ(faultsOf({}).size(), 1u);  // the task's own chain begins with Crichton
  EXPECT_EQ(faultsOf({})[0].field, "tasks.serve.chain");
}

TEST(CellService, AHandThatIsHalfClosedAtTheStartOpensOnTheWay) {
  std::vector<Override> closed;
  for (const std::string finger : {"1", "2", "3"}) {
    closed.push_back({"robots.hubo.joints.LF" + finger + "1", "0"});
    closed.push_back({"robots.hubo.joints.LF" + finger + "2", "1.1"});
    closed.push_back({"robots.hubo.joints.LF" + finger + "3", "1.1"});
  }
  const Answer answer = ask(butlerRequest(closed));
  ASSERT_TRUE(std::holds_alternative<Done>(answer.outcome)) << answer.outcome.index();
  const auto stages = answer.all<StageTrajectory>();
  const auto reach = std::find_if(stages.begin(), stages.end(), [](const StageTrajectory& stage) {
    return stage.holder == 1 && stage.action == StageAction::kReach;
  });
  ASSERT_NE(reach, stages.end());
  EXPECT_THAT(reach->joints, testing::IsSupersetOf({"LF11", "LF12", "LF13"}));
}

TEST(CellService, AnArmSaidToHoldTheObjectThatHoldsSomethingElseIsNamedSo) {
  PlanRequest request = butlerRequest({{"tasks.serve.start", "{held_by: hubo/right}"}});
  request.chain = {"hubo/right", "crichton"};
  request.wants_fix = false;
  const Answer answer = ask(request);
  const auto* failed = std::get_if<Failed>(&answer.outcome);
  ASSERT_NE(failed, nullptr) << answer.outcome.index();
  EXPECT_EQ(failed->reason, FailureReason::kNoGrasp);
  EXPECT_EQ(failed->explanation.text, "hubo/right cannot hold cup at the start: it holds tray.");
  EXPECT_EQ(failed->explanation.causes,
            (std::vector<CauseCount>{{Cause::kHoldsObject, {"hubo/right", "tray"}, {}, 1}}));
}

TEST(CellService, CancelledBeforehandSaysSo) {
  const Deadline deadline;
  deadline.cancel();
  EXPECT_TRUE(std::holds_alternative<Cancelled>(ask(butlerRequest(), deadline).outcome));
}

}  // namespace
}  // namespace handover::test
