// SPDX-License-Identifier: Apache-2.0
// The nearest fix of a real cell is true: it plans, and nothing much cheaper does.
#include "cells/cell_service.hpp"
#include "cells/nearest_fix.hpp"
#include "support/recorder.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

namespace handover {
namespace {

class NearestFixOfACell : public testing::Test {
 protected:
  Outcome plan(const std::vector<Override>& overrides, bool wants_fix = true) {
    PlanRequest request;
    request.cell = "butler";
    request.overrides = overrides;
    request.wants_fix = wants_fix;
    recorder_ = {};
    return service_.planAlone(request, recorder_, Deadline());
  }

  /// The receiver as the last plan's scene had it.
  SceneRobot hubo() const {
    for (const PlanEventPayload& payload : recorder_.events) {
      const auto* scene = std::get_if<SceneSnapshot>(&payload);
      if (scene == nullptr) continue;
      for (const RobotSnapshot& robot : scene->robots) {
        if (robot.name != "hubo") continue;
        SceneRobot placed;
        placed.name = robot.name;
        placed.X_WB = toPose(robot.X_WB);
        return placed;
      }
    }
    throw std::runtime_error("no scene");
  }

  CellService service_{HANDOVER_SOURCE_DIR,
                       {"butler"},
                       std::filesystem::path(HANDOVER_BINARY_DIR "/test-cache/handover"),
                       {},
                       false};
  test::Recorder recorder_;
};

TEST_F(NearestFixOfACell, PlansAndNothingMuchCheaperDoes) {
  const Override far{"robots.hubo.base.xyz", "[1.75, 0, 0.98]"};
  const Outcome outcome = plan({far});
  const auto* failed = std::get_if<Failed>(&outcome);
  ASSERT_NE(failed, nullptr);
  ASSERT_EQ(failed->explanation.nearest_fix.size(), 1u) << failed->explanation.fix_text;
  const Override fix = failed->explanation.nearest_fix[0];
  EXPECT_EQ(recorder_.all<Fix>(), (std::vector<Fix>{{{fix}, failed->explanation.fix_text}}));
  const SceneRobot robot = hubo();

  EXPECT_TRUE(std::holds_alternative<Done>(plan({far, fix}))) << fix.value;

  constexpr int kFar = 6, kTurns = 4;
  double cost = -1;
  std::vector<BaseMove> moves;
  for (int i = -kFar; i <= kFar; ++i) {
    for (int j = -kFar; j <= kFar; ++j) {
      for (int turn = -kTurns; turn <= kTurns; ++turn) {
        const BaseMove move{i, j, turn};
        if (overrideOf(move, robot).value == fix.value) cost = move.cost();
        moves.push_back(move);
      }
    }
  }
  ASSERT_GT(cost, 0) << fix.value;
  ASSERT_LT(cost, BaseMove({kFar, 0, 0}).cost());
  ASSERT_LT(cost, BaseMove({0, 0, kTurns}).cost());
  int cheaper = 0;
  for (const BaseMove& move : moves) {
    if (move.cost() >= 0.5 * cost) continue;  // of those nearer quick plans miss some
    ++cheaper;
    const Override change = overrideOf(move, robot);
    EXPECT_FALSE(std::holds_alternative<Done>(plan({far, change}, false))) << change.value;
  }
  EXPECT_GT(cheaper, 3);
}

}  // namespace
}  // namespace handover
