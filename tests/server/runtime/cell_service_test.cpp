// SPDX-License-Identifier: Apache-2.0
// The whole planning side without DDS: the butler cell from its files to fourteen stages.
#include "runtime/cell_service.hpp"

#include "core/kinematics/arm_kinematics.hpp"
#include "settings/roots.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>

namespace handover {
namespace {

class Recorder : public StageSink {
 public:
  void emit(StagePayload payload) override {
    if (std::getenv("HANDOVER_TEST_VERBOSE") != nullptr) print(payload);
    stages.push_back(std::move(payload));
  }

  template <typename T>
  std::vector<T> all() const {
    std::vector<T> found;
    for (const auto& stage : stages) {
      if (const auto* payload = std::get_if<T>(&stage)) found.push_back(*payload);
    }
    return found;
  }

  std::vector<StagePayload> stages;

 private:
  static void printRejects(const std::vector<RejectCount>& rejects) {
    for (const auto& r : rejects) {
      std::fprintf(stderr, "      %u %s %s %s\n", r.count, r.cause.c_str(), r.pair.first.c_str(),
                   r.pair.second.c_str());
    }
  }

  void print(const StagePayload& payload) const {
    const double elapsed =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin_)
            .count();
    std::fprintf(stderr, "[%8.1f ms] ", elapsed);
    if (const auto* arms = std::get_if<ArmSelected>(&payload)) {
      std::fprintf(stderr, "arms: %s -> %s\n", arms->giver_arm.c_str(), arms->receiver_arm.c_str());
      for (const auto& s : arms->scores) {
        std::fprintf(stderr, "      %s/%s %.4f %s\n", s.robot.c_str(), s.arm.c_str(),
                     s.manipulability, s.rejected.c_str());
      }
    } else if (const auto* pruned = std::get_if<GraspsPruned>(&payload)) {
      std::fprintf(stderr, "grasps %s/%s: %u of %u\n", pruned->robot.c_str(), pruned->arm.c_str(),
                   pruned->kept, pruned->tested);
      printRejects(pruned->rejects);
    } else if (const auto* poses = std::get_if<HandoverCandidates>(&payload)) {
      std::fprintf(stderr, "poses: %u voxels, %u tried, %u kept, %u tuples\n", poses->voxels,
                   poses->poses_tried, poses->poses, poses->tuples);
      printRejects(poses->rejects);
    } else if (const auto* stage = std::get_if<StageTrajectory>(&payload)) {
      std::fprintf(stderr, "%s: %.2f s, %zu samples\n", toString(stage->kind), stage->t.back(),
                   stage->t.size());
    } else {
      std::fprintf(stderr, "payload %zu\n", payload.index());
    }
  }

  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

/// One service for all tests of the file; its cache lies in the build folder.
CellService& service() {
  static CellService instance(HANDOVER_SOURCE_DIR, {"butler"},
                              HANDOVER_BINARY_DIR "/test-cache/handover", {}, false);
  static const bool prepared = [] {
    instance.prepare(Deadline());
    return true;
  }();
  (void)prepared;
  return instance;
}

PlanRequest butlerRequest() {
  PlanRequest request;
  request.id = RequestId::random();
  request.client_id = "test";
  request.cell = "butler";
  return request;
}

void explainFailure(const Outcome& outcome) {
  if (const auto* failed = std::get_if<Failed>(&outcome)) {
    std::fprintf(stderr, "failed: %s: %s\n", toString(failed->reason),
                 failed->explanation.text.c_str());
    for (const auto& cause : failed->explanation.causes) {
      std::fprintf(stderr, "   %u %s %s %s\n", cause.count, cause.cause.c_str(),
                   cause.pair.first.c_str(), cause.pair.second.c_str());
    }
  }
  if (const auto* rejected = std::get_if<Rejected>(&outcome)) {
    for (const auto& fault : rejected->faults) {
      std::fprintf(stderr, "rejected: %s: %s\n", fault.field.c_str(), fault.message.c_str());
    }
  }
}

TEST(CellService, PlansTheNominalButlerInFourteenStages) {
  Recorder recorder;
  const Outcome outcome = service().plan(butlerRequest(), recorder, Deadline());
  explainFailure(outcome);
  ASSERT_TRUE(std::holds_alternative<Done>(outcome));
  const auto stages = recorder.all<StageTrajectory>();
  ASSERT_EQ(stages.size(), static_cast<std::size_t>(kStageCount));
  for (std::size_t i = 0; i < stages.size(); ++i) {
    EXPECT_EQ(stages[i].index, i);
    EXPECT_EQ(static_cast<std::size_t>(stages[i].kind), i + 1);
  }
}

TEST(CellService, FindsThatTheFreeHandTakesTheCup) {
  Recorder recorder;
  ASSERT_TRUE(std::holds_alternative<Done>(service().plan(butlerRequest(), recorder, Deadline())));
  const auto arms = recorder.all<ArmSelected>();
  ASSERT_EQ(arms.size(), 1u);
  EXPECT_EQ(arms[0].receiver_arm, "left");
  for (const auto& score : arms[0].scores) {
    if (score.robot == "hubo" && score.arm == "right") {
      EXPECT_EQ(score.rejected, "holds tray");
    }
  }
}

TEST(CellService, DexteritiesAreThoseOfTheConfigurationsReached) {
  Recorder recorder;
  ASSERT_TRUE(std::holds_alternative<Done>(service().plan(butlerRequest(), recorder, Deadline())));
  const Solution solution = recorder.all<Solution>().at(0);
  ModelCache models;
  const Cell cell =
      Cell::load(cellFile("butler", HANDOVER_SOURCE_DIR), HANDOVER_SOURCE_DIR, models);
  const auto at_end_of = [&](StageKind kind, const char* robot, const std::string& arm_name) {
    for (const StageTrajectory& stage : recorder.all<StageTrajectory>()) {
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

TEST(CellService, AnswersTheSameStagesTwice) {
  Recorder first, second;
  service().plan(butlerRequest(), first, Deadline());
  service().plan(butlerRequest(), second, Deadline());
  EXPECT_EQ(first.stages, second.stages);
}

TEST(CellService, SaysWhyAReceiverSixMetresAwayCannot) {
  PlanRequest request = butlerRequest();
  request.overrides.push_back({"robots.hubo.base.xyz", "[6, -0.3, 0.98]"});
  request.mode = SearchMode::kFirst;  // without a search for what would help
  Recorder recorder;
  const Outcome outcome = service().plan(request, recorder, Deadline());
  const auto* failed = std::get_if<Failed>(&outcome);
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
  PlanRequest request = butlerRequest();
  request.overrides = GetParam().overrides;
  request.mode = SearchMode::kFirst;
  Recorder recorder;
  const Outcome outcome = service().plan(request, recorder, Deadline());
  const auto* failed = std::get_if<Failed>(&outcome);
  ASSERT_NE(failed, nullptr) << outcome.index();
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
    PlanRequest request = butlerRequest();
    request.overrides.push_back(bad);
    Recorder recorder;
    const Outcome outcome = service().plan(request, recorder, Deadline());
    const auto* rejected = std::get_if<Rejected>(&outcome);
    ASSERT_NE(rejected, nullptr) << bad.path;
    ASSERT_FALSE(rejected->faults.empty());
    EXPECT_EQ(rejected->faults[0].field, bad.path);
  }
}

/// A request that needs grasps which no cache has, and thousands of them.
PlanRequest largeRequest() {
  PlanRequest request = butlerRequest();
  request.overrides.push_back({"objects.cup.grasps.crichton.right_hand", "9999"});
  return request;
}

TEST(CellService, DeadlineAndCancelEndTheMakingOfGrasps) {
  using namespace std::chrono_literals;
  service();
  Recorder recorder;
  const Outcome late =
      service().plan(largeRequest(), recorder, Deadline(std::chrono::steady_clock::now() + 50ms));
  const auto* failed = std::get_if<Failed>(&late);
  ASSERT_NE(failed, nullptr);
  EXPECT_EQ(failed->reason, FailureReason::kDeadline);

  const Deadline deadline;
  std::jthread cancel([&deadline] {
    std::this_thread::sleep_for(50ms);
    deadline.cancel();
  });
  EXPECT_TRUE(
      std::holds_alternative<Cancelled>(service().plan(largeRequest(), recorder, deadline)));
}

TEST(CellService, OneThatMakesGraspsHoldsUpNobodyElse) {
  service();
  const Deadline deadline;
  std::atomic<bool> ended = false;
  std::jthread large([&] {
    Recorder recorder;
    service().plan(largeRequest(), recorder, deadline);
    ended = true;
  });
  Recorder recorder;
  EXPECT_TRUE(std::holds_alternative<Done>(service().plan(butlerRequest(), recorder, Deadline())));
  EXPECT_FALSE(ended);
  deadline.cancel();
}

TEST(CellService, CancelledBeforehandSaysSo) {
  const Deadline deadline;
  deadline.cancel();
  Recorder recorder;
  EXPECT_TRUE(
      std::holds_alternative<Cancelled>(service().plan(butlerRequest(), recorder, deadline)));
}

}  // namespace
}  // namespace handover
