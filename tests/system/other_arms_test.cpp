// SPDX-License-Identifier: Apache-2.0
// Arms that the planner was not made for, as giver and receiver: six joints, seven with offsets,
// sliding fingers, no group states, no disabled pairs. By the real programs, like the butler.
#include "served_cells.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace handover::test {
namespace {

const std::string kRoot = HANDOVER_SOURCE_DIR "/tests/support";

struct Robot {
  const char* name;
  std::size_t arm_joints, hand_joints;
};

constexpr Robot kUr{"ur", 6, 2};
constexpr Robot kIiwa{"iiwa", 7, 1};  // one finger mimics the other
constexpr Robot kPanda{"panda", 7, 2};

struct Task {
  const char* cell;
  const char* task;
  Robot giver, receiver;
};

std::ostream& operator<<(std::ostream& out, const Task& task) {
  return out << task.cell << ' ' << task.task;
}

class OtherArms : public ServedCells, public testing::WithParamInterface<Task> {};

INSTANTIATE_TEST_SUITE_P(
    System, OtherArms,
    testing::Values(Task{"exchange", "to_iiwa", kUr, kIiwa}, Task{"exchange", "to_ur", kIiwa, kUr},
                    Task{"offset", "to_panda", kUr, kPanda}, Task{"offset", "to_ur", kPanda, kUr}),
    [](const auto& shown) {
      return std::string(shown.param.giver.name) + "_" + shown.param.receiver.name;
    });

TEST_P(OtherArms, PlanIsCompleteAndVerified) {
  const Task& task = GetParam();
  serve("--cell " + kRoot + "/config/cells/" + task.cell + ".yaml", kRoot);
  const Finished planned = run(ctl(std::string("plan --cell ") + task.cell + " --task " +
                                   task.task + " --output " + file("p.json")),
                               {}, 240s);
  ASSERT_EQ(planned.status, 0) << planned.out << planned.err;

  const auto plan = nlohmann::json::parse(textOf(file("p.json")))["plan"];
  ASSERT_EQ(plan["holders"].size(), 2u);
  EXPECT_EQ(plan["holders"][0]["robot"], task.giver.name);
  EXPECT_EQ(plan["holders"][1]["robot"], task.receiver.name);
  ASSERT_EQ(plan["stages"].size(), 16u);
  for (const auto& stage : plan["stages"]) {
    const std::string action = stage["action"];
    const bool fingers = action == "grasp" || action == "release";
    const Robot& robot = stage["holder"] == 0 ? task.giver : task.receiver;
    EXPECT_EQ(stage["robot"], robot.name);
    // Fingers may go with the arm on its way to the object and home.
    if (action == "reach" || action == "home") continue;
    EXPECT_EQ(stage["joints"].size(), fingers ? robot.hand_joints : robot.arm_joints) << action;
  }

  expectValid("p.json", "--root " + kRoot);
  stop();
}

// Least squares tell slowly that there is no configuration; a request that fails asks for
// thousands.
TEST_F(ServedCells, ArmWithoutAClosedFormIsSoonToldThatTheOtherIsTooFar) {
  serve("--cell " + kRoot + "/config/cells/exchange.yaml", kRoot);
  for (const char* task : {"to_iiwa", "to_ur"}) {
    // One second in fact.
    const Finished failed = run(ctl(std::string("plan --cell exchange --no-fix --task ") + task +
                                    " --set robots.iiwa.base.xyz=[2.1,0,0.75]" +
                                    " --set objects.iiwa_table.pose.xyz=[2.35,0,0.725]"),
                                {}, 60s);
    EXPECT_EQ(failed.status, 10) << failed.out << failed.err;
    EXPECT_THAT(failed.out, testing::HasSubstr("no_handover_pose"));
  }
  stop();
}

}  // namespace
}  // namespace handover::test
