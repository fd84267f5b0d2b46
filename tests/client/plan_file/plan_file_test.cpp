// SPDX-License-Identifier: Apache-2.0
// What goes into a plan file comes out of it, and what is no plan file is refused by field.
#include "any_events.hpp"
#include "property.hpp"
#include "sample_events.hpp"
#include "temporary_folder.hpp"

#include <handover/client/answer.hpp>
#include <handover/client/plan_file.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <functional>

namespace handover::client {
namespace {

using Json = nlohmann::ordered_json;

Answer answerOf(const std::vector<PlanEvent>& events) {
  Answer answer;
  for (const PlanEvent& event : events) answer.add(event);
  return answer;
}

/// What the file keeps of a plan.
Plan kept(const Answer& answer) {
  Plan plan{*answer.solution(), {}};
  plan.solution.index = 0;
  for (Holder& holder : plan.solution.holders) holder.grasp = 0;
  if (!plan.solution.quality) plan.solution.cost = 0;
  for (const StageTrajectory* stage : answer.trajectories()) {
    plan.stages.push_back(*stage);
    plan.stages.back().solution = 0;
  }
  return plan;
}

/// An arm left out is the robot's name alone; a single thing stands first.
Failure kept(Failure failure) {
  for (CauseCount& cause : failure.explanation.causes) {
    auto& [first, second] = cause.pair;
    if (first.empty()) std::swap(first, second);
  }
  return failure;
}

TEST(PlanFile, IsReadBackAsItWasWrittenWhateverIsDrawn) {
  EXPECT_TRUE(test::holds("answers", 60, [] {
    const std::vector<PlanEvent> events = test::anyAnswer();
    const Answer answer = answerOf(events);
    RC_ASSERT(answer.hasPlan());
    const PlanFile file = parsePlanFile(answer.text());
    RC_ASSERT(file.scene == std::get<SceneSnapshot>(events[1].payload));
    RC_ASSERT(file.plan == kept(answer));
    RC_ASSERT(file.complete == std::get<Done>(*answer.outcome()).complete);
    RC_ASSERT(file.scene_revision == std::get<Accepted>(events[0].payload).scene_revision);
    RC_ASSERT(!file.failure);
  }));
}

TEST(PlanFile, KeepsWhyThereIsNoPlan) {
  EXPECT_TRUE(test::holds("failures", 200, [] {
    const PlanEvent event = test::anyEvent();
    const auto* outcome = std::get_if<Outcome>(&event.payload);
    const auto* failed = outcome == nullptr ? nullptr : std::get_if<Failed>(outcome);
    if (failed == nullptr) return;
    const PlanFile file = parsePlanFile(answerOf({event}).text());
    RC_ASSERT(!file.scene && !file.plan && !file.complete);
    RC_ASSERT(file.failure == kept(Failure{failed->reason, failed->explanation}));
  }));
}

TEST(PlanFile, ReadsPlansOfOneTwoAndThreeHolders) {
  const test::TemporaryFolder folder;
  for (std::uint32_t holders = 1; holders <= 3; ++holders) {
    const Answer answer = answerOf(test::sampleAnswer(RequestId{}, 0.001, holders));
    const PlanFile file = readPlanFile(folder.write("plan.json", answer.text()));
    ASSERT_TRUE(file.plan);
    EXPECT_EQ(*file.plan, kept(answer));
    EXPECT_EQ(file.plan->solution.holders.size(), holders);
  }
}

struct BadFile {
  const char* where;
  std::function<void(Json&)> spoil;
};

class PlanFileFaults : public testing::TestWithParam<BadFile> {};

TEST_P(PlanFileFaults, NameTheField) {
  Json json = Json::parse(answerOf(test::sampleAnswer(RequestId{})).text());
  GetParam().spoil(json);
  try {
    (void)parsePlanFile(json.dump());
    FAIL() << GetParam().where;
  } catch (const PlanFileError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr(GetParam().where));
  }
}

INSTANTIATE_TEST_SUITE_P(
    Each, PlanFileFaults,
    testing::Values(
        BadFile{"/format: is not", [](Json& f) { f["format"] = "handover-plan/1"; }},
        BadFile{"/format: is missing", [](Json& f) { f.erase("format"); }},
        BadFile{"/scene: is missing", [](Json& f) { f["scene"] = nullptr; }},
        BadFile{"/plan/stages: must be a list", [](Json& f) { f["plan"]["stages"] = 3; }},
        BadFile{"/plan/stages/2/action: unknown name 'nap'",
                [](Json& f) { f["plan"]["stages"][2]["action"] = "nap"; }},
        BadFile{"/plan/stages/2/index: is out of order",
                [](Json& f) { f["plan"]["stages"][2]["index"] = 3; }},
        BadFile{"/plan/stages/2/holder: is not in the plan",
                [](Json& f) { f["plan"]["stages"][2]["holder"] = 2; }},
        BadFile{"/plan/stages/5/q/1: must be a list of finite numbers",
                [](Json& f) { f["plan"]["stages"][5]["q"][1][0] = "x"; }},
        BadFile{"trajectory.qdd has a row that does not fit",
                [](Json& f) { f["plan"]["stages"][5]["qdd"][1].push_back(0.5); }},
        BadFile{"trajectory.t must rise", [](Json& f) { f["plan"]["stages"][5]["t"][1] = 0.0; }},
        BadFile{"solution.X_WO_handovers must have",
                [](Json& f) { f["plan"]["handovers"].clear(); }},
        BadFile{"/plan/holders/0/gripper",
                [](Json& f) { f["plan"]["holders"][0].erase("gripper"); }},
        BadFile{"scene.start.X_WO.quat_wxyz is off unit length",
                [](Json& f) {
                  f["scene"]["start"]["X_WO"]["quat_wxyz"] = {2, 0, 0, 0};
                }},
        BadFile{"/scene/goal/rest: must be", [](Json& f) { f["scene"]["goal"]["rest"] = "all"; }},
        BadFile{"/scene/robots/0/limits/TSY: must have 5",
                [](Json& f) { f["scene"]["robots"][0]["limits"]["TSY"].push_back(1); }},
        BadFile{"/scene/seed: must be a whole", [](Json& f) { f["scene"]["seed"] = -1; }},
        BadFile{"/plan/stages/5/robot: is not in the scene",
                [](Json& f) { f["scene"]["robots"][0]["name"] = "other"; }},
        BadFile{"/complete: must be true or false", [](Json& f) { f["complete"] = 1; }}));

TEST(PlanFile, RefusesWhatIsNoFileOrNoJson) {
  EXPECT_THROW((void)parsePlanFile("{"), PlanFileError);
  EXPECT_THROW((void)parsePlanFile("[]"), PlanFileError);
  EXPECT_THROW((void)readPlanFile("/dev/zero"), PlanFileError);
  EXPECT_THROW((void)readPlanFile("/nowhere/plan.json"), PlanFileError);
}

TEST(JsonLine, IsOneLineOfJsonWhateverIsDrawn) {
  EXPECT_TRUE(test::holds("events", 200, [] {
    const PlanEvent event = test::anyEvent();
    const std::string line = jsonLine(event);
    RC_ASSERT(line.find('\n') == std::string::npos);
    const auto json = nlohmann::json::parse(line);
    RC_ASSERT(json["type"] == payloadName(event.payload));
    RC_ASSERT(json["sequence"] == event.sequence);
    RC_ASSERT(json["request_id"] == event.request_id.hex());
  }));
}

}  // namespace
}  // namespace handover::client
