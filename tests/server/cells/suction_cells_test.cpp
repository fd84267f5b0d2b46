// SPDX-License-Identifier: Apache-2.0
// A cup takes, gives, receives and puts down: planned whole, and checked by the verifier.
#include "cells/cell_service.hpp"
#include "support/recorder.hpp"
#include "support/verified.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <variant>
#include <vector>

namespace handover::test {
namespace {

const std::string kRoot = HANDOVER_SOURCE_DIR "/tests/support";

CellService& service() {
  static CellService instance(kRoot, {"suction"},
                              std::filesystem::path(HANDOVER_BINARY_DIR "/test-cache/handover"), {},
                              false);
  static const bool prepared = [] {
    instance.prepareAll(Deadline());
    return true;
  }();
  (void)prepared;
  return instance;
}

PlanRequest requestFor(const std::string& task) {
  PlanRequest request;
  request.id = RequestId::random();
  request.client_id = "test";
  request.cell = "suction";
  request.task = task;
  request.wants_fix = false;
  return request;
}

struct SuctionTask {
  const char* name;
  std::vector<bool> cups;  // by holder: is its gripper a cup
};

class Suction : public testing::TestWithParam<SuctionTask> {};

INSTANTIATE_TEST_SUITE_P(Cell, Suction,
                         testing::Values(SuctionTask{"alone", {true}},
                                         SuctionTask{"fingers_to_cup", {false, true}},
                                         SuctionTask{"cup_to_fingers", {true, false}},
                                         SuctionTask{"cup_to_cup", {true, true}}),
                         [](const auto& shown) { return std::string(shown.param.name); });

TEST_P(Suction, IsPlannedAndVerified) {
  Recorder recorder;
  const Outcome outcome = service().planAlone(requestFor(GetParam().name), recorder, Deadline());
  ASSERT_TRUE(verified(recorder.events, outcome, kRoot));

  const Solution solution = allOf<Solution>(recorder.events).back();
  ASSERT_EQ(solution.holders.size(), GetParam().cups.size());
  for (std::size_t k = 0; k < solution.holders.size(); ++k) {
    const auto* cup = std::get_if<SuctionGripper>(&solution.holders[k].gripper);
    ASSERT_EQ(cup != nullptr, GetParam().cups[k]);
    if (cup == nullptr) continue;
    EXPECT_EQ(cup->cup_link, "cup");
    EXPECT_EQ(cup->radius, 0.02);
  }
  for (const StageTrajectory& stage : allOf<StageTrajectory>(recorder.events)) {
    const bool gripper =
        stage.action == StageAction::kGrasp || stage.action == StageAction::kRelease;
    if (!gripper || !GetParam().cups.at(stage.holder)) continue;
    EXPECT_TRUE(stage.joints.empty());
    EXPECT_EQ(stage.t, (std::vector<double>{0, 0.3}));  // engage_s
    EXPECT_EQ(stage.q, (std::vector<std::vector<double>>{{}, {}}));
  }
}

TEST(SuctionFailure, SaysWhyACupHoldsTheObjectNowhere) {
  PlanRequest request = requestFor("alone");
  request.overrides = {{"objects.box.geometry", "{type: sphere, radius: 0.07}"}};
  Recorder recorder;
  const Outcome outcome = service().planAlone(request, recorder, Deadline());
  const auto* failed = std::get_if<Failed>(&outcome);
  ASSERT_NE(failed, nullptr);
  EXPECT_EQ(failed->reason, FailureReason::kNoGrasp);
  EXPECT_THAT(failed->explanation.text,
              testing::HasSubstr("cup_a/arm has no grasp that fits: a cup of radius 20 mm seals at "
                                 "none of 1500 places"));
}

}  // namespace
}  // namespace handover::test
