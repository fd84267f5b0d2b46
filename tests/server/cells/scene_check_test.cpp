// SPDX-License-Identifier: Apache-2.0
#include "cells/scene_check.hpp"

#include "support/temporary_folder.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <sstream>

namespace handover::test {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::Field;
using testing::HasSubstr;
using Grade = SceneFinding::Grade;

auto finding(Grade grade, const std::string& text) {
  return AllOf(Field(&SceneFinding::grade, grade), Field(&SceneFinding::text, HasSubstr(text)));
}

/// The butler cell with a word of its file replaced by another.
std::vector<SceneFinding> findingsWith(const std::string& word, const std::string& by) {
  std::ifstream in(HANDOVER_SOURCE_DIR "/config/cells/butler.yaml");
  std::stringstream text;
  text << in.rdbuf();
  std::string cell = text.str();
  if (!word.empty()) cell.replace(cell.find(word), word.size(), by);
  const TemporaryFolder folder;
  const auto file = folder.path() / "changed.yaml";
  std::ofstream(file) << cell;
  CellService service(HANDOVER_SOURCE_DIR, {file.string()},
                      std::filesystem::path(HANDOVER_BINARY_DIR "/test-cache/handover"), {}, false);
  return sceneFindings(service, "butler", Deadline());
}

TEST(SceneCheck, SaysTheGraspsAndTheReachOfASoundCell) {
  const auto findings = findingsWith("", "");
  EXPECT_THAT(findings, Not(Contains(Field(&SceneFinding::grade, Grade::kFault))));
  EXPECT_THAT(findings, Contains(finding(Grade::kFact, "hubo/left: 368 grasps of cup")));
  EXPECT_THAT(findings, Contains(finding(Grade::kFact, "the start is in reach of crichton/")));
  EXPECT_THAT(findings, Contains(finding(Grade::kFact, "are in reach of both arms")));
}

TEST(SceneCheck, SaysWhatFloats) {
  EXPECT_THAT(findingsWith("[0, 0, 0.077]", "[0, 0, 0.082]"),
              Contains(finding(Grade::kFault,
                               "goal_unsupported: At its goal cup rests on nothing; "
                               "tray is 5.0 mm away")));
}

TEST(SceneCheck, SaysEveryPairThatTouches) {
  const auto findings = findingsWith("[0.35, -0.80, 0.8126]", "[0.50, -0.67, 0.8126]");
  EXPECT_THAT(findings, Contains(finding(Grade::kFault, "start_in_collision")));
  EXPECT_THAT(findings, Contains(finding(Grade::kFault, "coffee_cup touches milk_carton")));
}

TEST(SceneCheck, SaysWhatIsOutOfReach) {
  EXPECT_THAT(findingsWith("base: {xyz: [1.18, 0, 0.98]", "base: {xyz: [3.18, 0, 0.98]"),
              Contains(finding(Grade::kWarning, "0 points near the shoulders' middle")));
}

}  // namespace
}  // namespace handover::test
