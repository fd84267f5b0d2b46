// SPDX-License-Identifier: Apache-2.0
// The real program on right plans, and how it speaks.
#include "spoiled_plan.hpp"

#include <string>
#include <vector>

namespace handover::verify::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

struct Right {
  const char* name;
  PlanOptions options;
  std::size_t stages;
};

void PrintTo(const Right& right, std::ostream* out) { *out << right.name; }

class RightPlan : public testing::TestWithParam<Right> {};

TEST_P(RightPlan, Passes) {
  const GantryCell cell;
  const Json plan = cell.plan(GetParam().options);
  EXPECT_EQ(plan["plan"]["stages"].size(), GetParam().stages);
  const ProgramResult result = verify(cell, plan);
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_THAT(result.kinds, IsEmpty());
  EXPECT_TRUE(result.json["valid"]);
  // It looked.
  for (const char* pass : {"nominal", "in_turn", "late"}) {
    const bool used = std::string(pass) == "nominal" || GetParam().options.holders > 1;
    if (!used || (std::string(pass) == "late" && GetParam().options.slack == 0)) continue;
    EXPECT_GT(result.json["checks"][pass]["states"], 10) << pass;
    EXPECT_GT(result.json["checks"][pass]["pairs"], 10) << pass;
  }
}

PlanOptions with(const std::function<void(PlanOptions&)>& change) {
  PlanOptions options;
  change(options);
  return options;
}

INSTANTIATE_TEST_SUITE_P(
    All, RightPlan,
    testing::Values(
        Right{"TwoHolders", {}, 16}, Right{"OneHolder", with([](auto& o) { o.holders = 1; }), 9},
        Right{"ThreeHolders", with([](auto& o) { o.holders = 3; }), 23},
        Right{"EndsHeld", with([](auto& o) { o.ends_held = true; }), 12},
        Right{"StartsHeld", with([](auto& o) { o.held_at_start = true; }), 12},
        Right{"StartsAndEndsHeld", with([](auto& o) { o.held_at_start = o.ends_held = true; }), 8},
        Right{"OneHolderStartsHeld", with([](auto& o) {
                o.holders = 1;
                o.held_at_start = true;
              }),
              5},
        Right{"Suction", with([](auto& o) { o.suction = true; }), 16},
        Right{"SuctionOfThree", with([](auto& o) {
                o.suction = true;
                o.holders = 3;
              }),
              23},
        Right{"SuctionStartsHeld", with([](auto& o) { o.suction = o.held_at_start = true; }), 12},
        Right{"Upright", with([](auto& o) { o.upright = true; }), 16},
        Right{"Joined", with([](auto& o) { o.joined = true; }), 16},
        Right{"JoinedOfThree", with([](auto& o) {
                o.joined = true;
                o.holders = 3;
              }),
              23},
        Right{"NoSlack", with([](auto& o) { o.slack = 0; }), 16},
        Right{"MuchSlack", with([](auto& o) { o.slack = 3; }), 16}),
    [](const testing::TestParamInfo<Right>& entry) { return std::string(entry.param.name); });

using VerifyProgram = SpoiledPlan;

TEST_F(VerifyProgram, SpeaksPlainTextWithoutJson) {
  Json file = cell_.plan();
  cell_.write("plan.json", file.dump());
  const std::string arguments =
      (cell_.root() / "plan.json").string() + " --root " + cell_.root().string();
  EXPECT_EQ(run(arguments).output, "valid\n");
  file["scene"]["goal"]["X_WO"]["xyz"][1] = 0.01;
  cell_.write("plan.json", file.dump());
  const ProgramResult invalid = run(arguments);
  EXPECT_EQ(invalid.exit_code, 1);
  EXPECT_THAT(invalid.output, HasSubstr("stage 12 (r arm place) t="));
  EXPECT_THAT(invalid.output, HasSubstr(" state: the object ends away from the goal by 10 mm"));
}

TEST_F(VerifyProgram, FindsTheRootInTheEnvironment) {
  cell_.write("plan.json", cell_.plan().dump());
  const std::string plan = (cell_.root() / "plan.json").string();
  ASSERT_EQ(setenv("HANDOVER_ROOT", cell_.root().c_str(), 1), 0);
  EXPECT_EQ(run(plan).exit_code, 0);
  EXPECT_EQ(run(plan + " --root /nonexistent").exit_code, 2);  // what is said goes before it
  unsetenv("HANDOVER_ROOT");
  EXPECT_EQ(run(plan).exit_code, 2);
}

TEST_F(VerifyProgram, NamesStageTimeAndBodies) {
  const auto result = spoiled({}, [](Json& file) {
    Json post = boxObject("gate", {0.02, 0.02, 0.1}, {-0.15, 0, 0.25});
    file["scene"]["objects"].push_back(post);
  });
  ASSERT_FALSE(result.kinds.empty()) << result.output;
  const Json& first = result.json["violations"][0];
  EXPECT_EQ(first["stage"], 4);
  EXPECT_EQ(first["name"], "g arm carry");
  EXPECT_EQ(first["kind"], "contact");
  EXPECT_THAT(first["bodies"], testing::Contains("gate"));
  EXPECT_GT(first["time"].get<double>(), 1);
}

TEST_F(VerifyProgram, TakesAMirrorOfAnyHolderAsAnArmOfItsOwn) {
  // The same robot model twice, under two names: nothing is known of a robot by its name.
  expectValid([](Json& file) {
    std::string text = file.dump();
    for (std::size_t at = 0; (at = text.find("\"g", at)) != std::string::npos;) {
      const bool robot = text[at + 2] == '"' || text[at + 2] == '/';
      if (robot) text.replace(at, 2, "\"left one");
      ++at;
    }
    file = Json::parse(text);
  });
}

}  // namespace
}  // namespace handover::verify::test
