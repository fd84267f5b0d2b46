// SPDX-License-Identifier: Apache-2.0
#include "json_writer.hpp"
#include "sample_events.hpp"

#include <handover/client/plan_file.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>

namespace handover::client {
namespace {

PlanFile fileOf(const std::vector<PlanEvent>& stages) {
  PlanFile file;
  for (const PlanEvent& stage : stages) file.add(stage);
  return file;
}

/// The text of the member "plan".
std::string planText(const std::string& file) {
  const auto begin = file.find("\"plan\": ");
  const auto end = file.find("\"complete\": ");
  return file.substr(begin, end - begin);
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

TEST(PlanFile, IsTheGoldenTextForTheSampleAnswer) {
  const std::string text = fileOf(test::sampleAnswer(RequestId{})).text();
  const std::string path = HANDOVER_SOURCE_DIR "/tests/client/golden_plan.json";
  if (std::getenv("HANDOVER_REFRESH_GOLDEN") != nullptr) std::ofstream(path) << text;
  std::ifstream file(path);
  std::stringstream golden;
  golden << file.rdbuf();
  EXPECT_EQ(text, golden.str());
}

TEST(PlanFile, HasTheKeysOfTheFormatInOrder) {
  const Json file = Json::parse(fileOf(test::sampleAnswer(RequestId{})).text());
  EXPECT_EQ(file["format"], "handover-plan/1");
  EXPECT_THAT(keysOf(file), testing::ElementsAre("format", "plan", "complete", "timing", "funnel",
                                                 "explanation"));
  EXPECT_THAT(
      keysOf(file["plan"]),
      testing::ElementsAre("cell", "task", "seed", "scene_hash", "object", "giver", "receiver",
                           "giver_arm", "receiver_arm", "giver_tool_link", "receiver_tool_link",
                           "robots", "objects", "X_WO_start", "X_WO_goal", "X_WO_handover",
                           "X_OT_giver", "X_OT_receiver", "dexterity", "stages"));
  EXPECT_THAT(keysOf(file["plan"]["robots"][0]),
              testing::ElementsAre("name", "urdf", "urdf_sha256", "srdf", "X_WB", "q_start",
                                   "limits", "resting"));
  EXPECT_THAT(keysOf(file["plan"]["objects"][0]),
              testing::ElementsAre("name", "geometry", "X_WO", "attached_to", "resting"));
  EXPECT_THAT(keysOf(file["plan"]["stages"][0]),
              testing::ElementsAre("index", "kind", "robot", "joints", "start", "t", "q", "qd",
                                   "holding", "may_touch"));
  EXPECT_EQ(file["plan"]["stages"].size(), 14u);
  EXPECT_TRUE(file["plan"]["objects"][2]["attached_to"].is_null());
  EXPECT_EQ(file["timing"]["scene_revision"], 7);
  EXPECT_EQ(file["plan"]["seed"].get<std::uint64_t>(), 18446744073709551615ull);
}

TEST(PlanFile, PlanMemberDoesNotDependOnTimes) {
  const RequestId one = RequestId::random(), two = RequestId::random();
  const std::string fast = fileOf(test::sampleAnswer(one, 0.001)).text();
  const std::string slow = fileOf(test::sampleAnswer(two, 0.7)).text();
  EXPECT_NE(fast, slow);
  EXPECT_EQ(planText(fast), planText(slow));
}

TEST(PlanFile, TakesTheFirstPlanFromTheFirstWholeSolution) {
  const PlanFile file = fileOf(test::sampleAnswer(RequestId{}, 1.0));
  // 5 stages before, a solution, 14 trajectories.
  EXPECT_EQ(file.firstPlanSeconds(), 20.0);
  EXPECT_EQ(file.solution()->index, 1u);
}

TEST(PlanFile, SaysHowMuchOverlapSaves) {
  auto stages = test::sampleAnswer(RequestId{});
  // One after another.
  std::map<std::uint32_t, double> now;
  for (PlanEvent& it : stages) {
    auto* stage = std::get_if<StageTrajectory>(&it.payload);
    if (stage == nullptr) continue;
    stage->start = now[stage->solution];
    now[stage->solution] += stage->t.back();
  }
  const MotionTime sequential = fileOf(stages).motionTime();
  EXPECT_EQ(sequential.motion_s, 7.0);
  EXPECT_EQ(sequential.overlap_saves_s, 0.0);
  for (PlanEvent& it : stages) {
    auto* stage = std::get_if<StageTrajectory>(&it.payload);
    if (stage != nullptr && stage->kind >= StageKind::kReceiverReach) stage->start -= 0.25;
  }
  const PlanFile file = fileOf(stages);
  EXPECT_EQ(file.motionTime(), (MotionTime{6.75, 0.25}));
  const Json timing = Json::parse(file.text())["timing"];
  EXPECT_EQ(timing["motion_s"], 6.75);
  EXPECT_EQ(timing["overlap_saves_s"], 0.25);
}

TEST(PlanFile, IsNotCompleteWithoutEveryStage) {
  auto stages = test::sampleAnswer(RequestId{});
  stages.erase(stages.end() - 3);
  const PlanFile file = fileOf(stages);
  EXPECT_FALSE(file.complete());
  EXPECT_THROW((void)file.text(), std::logic_error);
  EXPECT_FALSE(fileOf({stages.begin(), stages.end() - 1}).complete());
}

TEST(JsonLine, IsOneLineForEveryPayload) {
  for (const PlanEventPayload& payload : test::samplePayloads()) {
    const std::string line = jsonLine({RequestId{}, 4, 0.5, payload});
    EXPECT_EQ(line.find('\n'), std::string::npos);
    const Json json = Json::parse(line);
    EXPECT_EQ(json["type"], payloadName(payload));
    EXPECT_EQ(json["sequence"], 4);
    EXPECT_EQ(json["request_id"], std::string(32, '0'));
  }
}

}  // namespace
}  // namespace handover::client
