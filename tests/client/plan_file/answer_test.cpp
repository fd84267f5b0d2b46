// SPDX-License-Identifier: Apache-2.0
#include "plan_file/json_writer.hpp"
#include "plan_text.hpp"
#include "sample_events.hpp"

#include <handover/client/answer.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>

namespace handover::client {
namespace {

Answer answerOf(const std::vector<PlanEvent>& events) {
  Answer answer;
  for (const PlanEvent& event : events) answer.add(event);
  return answer;
}

std::vector<std::string> keysOf(const Json& json) {
  std::vector<std::string> keys;
  for (auto it = json.begin(); it != json.end(); ++it) keys.push_back(it.key());
  return keys;
}

TEST(JsonWriter, WritesDoublesShortestExactAndAsDoubles) {
  EXPECT_EQ(compact(Json{0.1, 1.0, -0.0, 1.0 / 3.0, 1e300, 5e-324, 1234.0}),
            "[0.1, 1.0, -0.0, 0.3333333333333333, 1e+300, 5e-324, 1234.0]");
  EXPECT_EQ(compact(Json{1, 18446744073709551615ull, true, nullptr, "a\"b\n"}),
            "[1, 18446744073709551615, true, null, \"a\\\"b\\n\"]");
  for (const double value : {0.1 + 0.2, 1.7976931348623157e308, -2.2250738585072014e-308}) {
    EXPECT_EQ(std::strtod(compact(Json(value)).c_str(), nullptr), value);
  }
}

TEST(JsonWriter, RefusesNumbersThatAreNotFinite) {
  EXPECT_THROW(compact(Json(std::numeric_limits<double>::quiet_NaN())), std::logic_error);
}

TEST(Answer, IsTheGoldenTextForTheSampleAnswer) {
  const std::string text = answerOf(test::sampleAnswer(RequestId{})).text();
  const std::string path = HANDOVER_SOURCE_DIR "/tests/client/plan_file/golden_plan.json";
  if (std::getenv("HANDOVER_REFRESH_GOLDEN") != nullptr) std::ofstream(path) << text;
  std::ifstream file(path);
  std::stringstream golden;
  golden << file.rdbuf();
  EXPECT_EQ(text, golden.str());
}

TEST(Answer, HasTheKeysOfTheFormatInOrder) {
  using testing::ElementsAre;
  const Json file = Json::parse(answerOf(test::sampleAnswer(RequestId{}, 0.001, 3)).text());
  EXPECT_EQ(file["format"], "handover-plan/2");
  EXPECT_THAT(keysOf(file), ElementsAre("format", "scene", "plan", "quality", "complete", "timing",
                                        "funnel", "explanation"));
  const Json &scene = file["scene"], &plan = file["plan"];
  EXPECT_THAT(keysOf(scene), ElementsAre("cell", "task", "seed", "scene_hash", "object", "robots",
                                         "objects", "start", "goal", "upright"));
  EXPECT_THAT(keysOf(scene["robots"][0]),
              ElementsAre("name", "urdf", "urdf_sha256", "srdf", "yaml", "yaml_sha256", "X_WB",
                          "q_start", "limits", "resting"));
  EXPECT_EQ(compact(scene["robots"][0]["limits"]),
            "{\"RSP\": [-1.0, 1.0, 1.0, 0.8, 8.0], \"TSY\": [null, null, 0.5, 0.25, 2.5]}");
  EXPECT_THAT(keysOf(scene["objects"][0]),
              ElementsAre("name", "geometry", "X_WO", "attached_to", "resting"));
  EXPECT_TRUE(scene["objects"][2]["attached_to"].is_null());
  EXPECT_THAT(keysOf(scene["start"]), ElementsAre("X_WO", "held_by", "rest"));
  EXPECT_THAT(keysOf(scene["goal"]), ElementsAre("X_WO", "end", "rest"));
  EXPECT_THAT(keysOf(plan), ElementsAre("holders", "handovers", "stages", "slack_s"));
  EXPECT_THAT(keysOf(plan["holders"][0]),
              ElementsAre("robot", "arm", "tool_link", "gripper", "hand", "X_OT", "dexterity"));
  EXPECT_THAT(keysOf(plan["holders"][2]["hand"]), ElementsAre("cup_link", "axis", "radius"));
  EXPECT_EQ(plan["handovers"].size(), 2u);
  EXPECT_THAT(keysOf(plan["stages"][1]),
              ElementsAre("index", "holder", "action", "robot", "joints", "start", "t", "q", "qd",
                          "qdd", "holding", "may_touch", "after"));
  EXPECT_EQ(compact(plan["stages"][1]["after"]), "[[0, 0.5]]");
  EXPECT_THAT(
      keysOf(file["quality"]),
      ElementsAre("duration_s", "bound_s", "object_s", "idle_s", "clearance", "tilt_deg",
                  "object_turn_deg", "limit_margin", "grip", "jerk_share", "cost", "terms"));
  EXPECT_TRUE(file["quality"]["clearance"][1]["pair"].is_null());
  EXPECT_TRUE(file["explanation"].is_null());
  EXPECT_EQ(file["timing"]["scene_revision"], 7);
  EXPECT_EQ(scene["seed"].get<std::uint64_t>(), 18446744073709551615ull);
}

TEST(Answer, SaysWhereTheObjectStartsAndEndsInAHand) {
  auto events = test::sampleAnswer(RequestId{}, 0.001, 1);
  auto& scene = std::get<SceneSnapshot>(events[1].payload);
  scene.start.held_by = ArmName{"hubo", "left"};
  scene.start.rest = {};
  scene.goal = {scene.goal.X_WO, TransportEnd::kHold, {.none = true, .objects = {}}};
  scene.upright.reset();
  const Json file = Json::parse(answerOf(events).text())["scene"];
  EXPECT_EQ(file["start"]["held_by"], "hubo/left");
  EXPECT_EQ(file["start"]["rest"], Json::array());
  EXPECT_EQ(file["goal"]["end"], "hold");
  EXPECT_EQ(file["goal"]["rest"], "none");
  EXPECT_TRUE(file["upright"].is_null());
}

TEST(Answer, HasAsManyStagesAsItsSolutionSays) {
  for (const auto& [holders, stages] : {std::pair{1u, 9u}, {2u, 16u}, {3u, 23u}}) {
    const auto events = test::sampleAnswer(RequestId{}, 0.001, holders);
    EXPECT_TRUE(answerOf(events).hasPlan());
    const Json plan = Json::parse(answerOf(events).text())["plan"];
    EXPECT_EQ(plan["stages"].size(), stages);
    EXPECT_EQ(plan["holders"].size(), holders);
    EXPECT_EQ(plan["handovers"].size(), holders - 1);
  }
}

TEST(Answer, SceneAndPlanDoNotDependOnTimes) {
  const RequestId one = RequestId::random(), two = RequestId::random();
  const std::string fast = answerOf(test::sampleAnswer(one, 0.001)).text();
  const std::string slow = answerOf(test::sampleAnswer(two, 0.7)).text();
  EXPECT_NE(fast, slow);
  EXPECT_FALSE(test::planMember(fast).empty());
  EXPECT_EQ(test::planMember(fast), test::planMember(slow));
}

TEST(Answer, TakesTheFirstPlanFromTheFirstWholeSolution) {
  const Answer answer = answerOf(test::sampleAnswer(RequestId{}, 1.0));
  // 5 events before, a solution, 16 trajectories.
  EXPECT_EQ(answer.firstPlanSeconds(), 22.0);
  EXPECT_EQ(answer.firstCost(), 14.5);
  EXPECT_EQ(answer.solution()->index, 1u);
}

TEST(Answer, SaysHowMuchOverlapSaves) {
  auto events = test::sampleAnswer(RequestId{});
  // One after another.
  std::map<std::uint32_t, double> now;
  for (PlanEvent& it : events) {
    auto* stage = std::get_if<StageTrajectory>(&it.payload);
    if (stage == nullptr) continue;
    stage->start = now[stage->solution];
    now[stage->solution] += stage->t.back();
  }
  const MotionTime sequential = answerOf(events).motionTime();
  EXPECT_EQ(sequential.motion_s, 8.0);
  EXPECT_EQ(sequential.overlap_saves_s, 0.0);
  for (PlanEvent& it : events) {
    auto* stage = std::get_if<StageTrajectory>(&it.payload);
    if (stage != nullptr && stage->index >= 5) stage->start -= 0.25;
  }
  const Answer answer = answerOf(events);
  EXPECT_EQ(answer.motionTime(), (MotionTime{7.75, 0.25}));
  const Json timing = Json::parse(answer.text())["timing"];
  EXPECT_EQ(timing["motion_s"], 7.75);
  EXPECT_EQ(timing["overlap_saves_s"], 0.25);
}

TEST(Answer, HasNoPlanWithoutEveryStage) {
  auto events = test::sampleAnswer(RequestId{});
  events.erase(events.end() - 3);
  const Answer answer = answerOf(events);
  EXPECT_FALSE(answer.hasPlan());
  EXPECT_FALSE(answer.writable());
  EXPECT_THROW((void)answer.text(), std::logic_error);
  EXPECT_FALSE(answerOf({events.begin(), events.end() - 1}).hasPlan());
}

TEST(Answer, BeginsAnewWithAnotherAnswerId) {
  const auto whole = test::sampleAnswer(RequestId{});
  Answer answer;
  for (std::size_t i = 0; i < 15; ++i) answer.add(whole[i]);
  auto failed = test::sampleFailedAnswer(RequestId{});
  for (PlanEvent& event : failed) event.answer_id = {7};
  for (const PlanEvent& event : failed) answer.add(event);
  EXPECT_EQ(answer.text(), answerOf(failed).text());
  // Not joined: the stages of the first answer and those of the second.
  Answer halves;
  for (std::size_t i = 0; i < 15; ++i) halves.add(whole[i]);
  for (std::size_t i = 15; i < whole.size(); ++i) {
    PlanEvent event = whole[i];
    event.answer_id = {7};
    halves.add(event);
  }
  EXPECT_FALSE(halves.hasPlan());
}

TEST(Answer, ExplainsAFailure) {
  using testing::ElementsAre;
  const Answer answer = answerOf(test::sampleFailedAnswer(RequestId{}));
  EXPECT_FALSE(answer.hasPlan());
  ASSERT_TRUE(answer.writable());
  const Json file = Json::parse(answer.text());
  EXPECT_TRUE(file["plan"].is_null());
  EXPECT_TRUE(file["quality"].is_null());
  EXPECT_EQ(file["complete"], false);
  EXPECT_EQ(file["scene"]["cell"], "butler");
  const Json& why = file["explanation"];
  EXPECT_THAT(keysOf(why), ElementsAre("reason", "text", "filter", "exhaustive", "causes",
                                       "nearest_fix", "fix_text", "farthest"));
  EXPECT_EQ(why["reason"], "no_grasp_at_goal");
  EXPECT_EQ(why["exhaustive"], true);
  EXPECT_EQ(compact(why["causes"][0]),
            R"({"cause": "collision", "pair": ["hubo/Body_LWR", "tray"], "count": 300})");
  EXPECT_EQ(compact(why["causes"][1]), R"({"cause": "no_ik", "pair": null, "count": 68})");
  EXPECT_EQ(why["causes"][2]["about"], "hubo/right");
  EXPECT_EQ(why["causes"][3]["stage"]["action"], "place");
  EXPECT_EQ(compact(why["nearest_fix"]),
            R"([{"path": "robots.hubo.base.xyz", "value": "[1.1, -0.3, 0.98]"}])");
  EXPECT_THAT(keysOf(why["farthest"]), ElementsAre("X_WO", "tools", "stage"));
  const Json& workspaces = file["funnel"]["workspaces"];
  EXPECT_EQ(workspaces["z"], 1.025);
  EXPECT_EQ(workspaces["edge"], 0.05);
  EXPECT_EQ(
      compact(workspaces["slices"][0]),
      R"({"robot": "crichton", "arm": "right", "tool_link": "grasp_link_0", )"
      R"("first": [0.025, -0.075], "columns": 3, "scores": [0.0, 0.25, 0.5, 0.125, 0.0, 0.0]})");
}

TEST(Answer, AFailureHasACauseEvenBeforeItsScene) {
  const Answer answer = answerOf(test::sampleEvents(
      RequestId{},
      {test::sampleAccepted(), Outcome{Failed{FailureReason::kDeadline, {.text = "It passed."}}}}));
  const Json file = Json::parse(answer.text());
  EXPECT_TRUE(file["scene"].is_null());
  EXPECT_EQ(compact(file["explanation"]["causes"]),
            R"([{"cause": "deadline", "pair": null, "count": 1}])");
  EXPECT_TRUE(file["explanation"]["nearest_fix"].is_null());
  EXPECT_TRUE(file["explanation"]["farthest"].is_null());
}

TEST(Answer, NeitherRejectionNorCancelIsAFile) {
  for (const Outcome& outcome :
       {Outcome{Cancelled{CancelCause::kAsked}}, Outcome{Rejected{RejectionReason::kBusy, {}}}}) {
    EXPECT_FALSE(answerOf(test::sampleEvents(RequestId{}, {outcome})).writable());
  }
}

TEST(JsonLine, IsOneLineForEveryPayload) {
  for (const PlanEventPayload& payload : test::samplePayloads()) {
    const std::string line = jsonLine({RequestId{}, test::kSampleAnswer, 4, 0.5, payload});
    EXPECT_EQ(line.find('\n'), std::string::npos);
    const Json json = Json::parse(line);
    EXPECT_EQ(json["type"], payloadName(payload));
    EXPECT_EQ(json["sequence"], 4);
    EXPECT_EQ(json["request_id"], std::string(32, '0'));
    EXPECT_EQ(json["answer_id"], "a5" + std::string(30, '0'));
  }
}

}  // namespace
}  // namespace handover::client
