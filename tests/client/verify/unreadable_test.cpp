// SPDX-License-Identifier: Apache-2.0
// Malformed plan files and files that they name: exit 2, and the field by name.
#include "gantry_plan.hpp"
#include "verify/sha256.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <ostream>
#include <string>

namespace handover::verify::test {
namespace {

using testing::HasSubstr;

struct Case {
  const char* name;
  std::function<void(Json&)> fault;
  const char* field;  ///< that the answer must name
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

Json& stageAt(Json& file, std::size_t index) { return file["plan"]["stages"][index]; }

class UnreadablePlan : public testing::TestWithParam<Case> {};

TEST_P(UnreadablePlan, IsRefusedNamingTheField) {
  const GantryCell cell;
  Json file = cell.plan();
  GetParam().fault(file);
  const ProgramResult result = verify(cell, file);
  EXPECT_EQ(result.exit_code, 2) << result.output;
  EXPECT_THAT(result.json.value("unreadable", ""), HasSubstr(GetParam().field));
}

INSTANTIATE_TEST_SUITE_P(
    Fields, UnreadablePlan,
    testing::Values(
        Case{"NotAnObject", [](Json& f) { f = Json::array(); }, "/: expected an object"},
        Case{"OldFormat", [](Json& f) { f["format"] = "handover-plan/1"; }, "/format"},
        Case{"PlanMissing", [](Json& f) { f.erase("plan"); }, "/plan: missing"},
        Case{"PlanNull", [](Json& f) { f["plan"] = nullptr; }, "/plan: the file has no plan"},
        Case{"SceneMissing", [](Json& f) { f.erase("scene"); }, "/scene: missing"},
        Case{"QualityMissing", [](Json& f) { f.erase("quality"); }, "/quality: missing"},
        Case{"QualityIsText", [](Json& f) { f["quality"] = "good"; }, "/quality: expected an object"},
        Case{"QualityWithoutBound",
             [](Json& f) {
               f["quality"] = {{"duration_s", 1}};
             },
             "/quality/bound_s: missing"},
        Case{"CompleteIsText", [](Json& f) { f["complete"] = "yes"; }, "/complete"},
        Case{"NoSeed", [](Json& f) { f["scene"].erase("seed"); }, "/scene/seed: missing"},
        Case{"NegativeSeed", [](Json& f) { f["scene"]["seed"] = -1; }, "/scene/seed"},
        Case{"HashNotHex", [](Json& f) { robot(f, "g")["urdf_sha256"] = "xyz"; },
             "/scene/robots/0/urdf_sha256"},
        Case{"YamlHashMissing", [](Json& f) { robot(f, "g").erase("yaml_sha256"); },
             "/scene/robots/0/yaml_sha256: missing"},
        Case{"ShortQuaternion",
             [](Json& f) {
               f["scene"]["goal"]["X_WO"]["quat_wxyz"] = {1, 0, 0};
             },
             "/scene/goal/X_WO/quat_wxyz"},
        Case{"QuaternionNotUnit",
             [](Json& f) {
               f["scene"]["start"]["X_WO"]["quat_wxyz"] = {1.01, 0, 0, 0};
             },
             "/scene/start/X_WO/quat_wxyz"},
        Case{"HandoverQuaternionNotUnit",
             [](Json& f) {
               f["plan"]["handovers"][0]["quat_wxyz"] = {0.9, 0, 0, 0};
             },
             "/plan/handovers/0/quat_wxyz"},
        Case{"PositionIsText", [](Json& f) { f["scene"]["goal"]["X_WO"]["xyz"][1] = "0"; },
             "/scene/goal/X_WO/xyz/1"},
        Case{"NullCoordinate", [](Json& f) { object(f, "post")["X_WO"]["xyz"][0] = nullptr; },
             "/scene/objects/3/X_WO/xyz/0"},
        Case{"HugeCoordinate", [](Json& f) { object(f, "post")["X_WO"]["xyz"][0] = 1e300; },
             "/scene/objects/3/X_WO/xyz/0"},
        Case{"UnknownGeometry", [](Json& f) { object(f, "post")["geometry"]["type"] = "cone"; },
             "/scene/objects/3/geometry/type"},
        Case{"NegativeBox",
             [](Json& f) {
               object(f, "post")["geometry"]["size"] = {0.1, -0.1, 0.1};
             },
             "/scene/objects/3/geometry/size"},
        Case{"EmptyCompound",
             [](Json& f) {
               object(f, "post")["geometry"] = {{"type", "compound"}, {"parts", Json::array()}};
             },
             "/scene/objects/3/geometry/parts"},
        Case{"EndlessCompound",
             [](Json& f) {
               Json geometry = {{"type", "sphere"}, {"radius", 1}};
               for (int i = 0; i < 10; ++i) {
                 geometry = {
                     {"type", "compound"},
                     {"parts", {{{"X_OS", pose({0, 0, 0})}, {"geometry", geometry}}}}};
               }
               object(f, "post")["geometry"] = geometry;
             },
             "nested too deeply"},
        Case{"MeshOutsideTheRoot",
             [](Json& f) {
               object(f, "post")["geometry"] = {
                   {"type", "mesh"}, {"path", "../../etc/passwd"}, {"scale", {1, 1, 1}}};
             },
             "must not leave the root"},
        Case{"MeshMissing",
             [](Json& f) {
               object(f, "post")["geometry"] = {
                   {"type", "mesh"}, {"path", "robots/none.obj"}, {"scale", {1, 1, 1}}};
             },
             "none.obj: no such file"},
        Case{"MeshIsAFolder",
             [](Json& f) {
               object(f, "post")["geometry"] = {
                   {"type", "mesh"}, {"path", "robots/gantry"}, {"scale", {1, 1, 1}}};
             },
             "gantry: is a folder"},
        Case{"MeshIsNone",
             [](Json& f) {
               object(f, "post")["geometry"] = {
                   {"type", "mesh"}, {"path", "robots/gantry/gantry.srdf"}, {"scale", {1, 1, 1}}};
             },
             "gantry.srdf"},
        Case{"UrdfAbsolute", [](Json& f) { robot(f, "g")["urdf"] = "/etc/hosts"; },
             "/scene/robots/0/urdf"},
        Case{"UrdfMissing", [](Json& f) { robot(f, "g")["urdf"] = "robots/none.urdf"; },
             "none.urdf: no such file"},
        Case{"YamlMissing", [](Json& f) { robot(f, "g")["yaml"] = "robots/none.yaml"; },
             "none.yaml: no such file"},
        Case{"RobotTwice", [](Json& f) { robot(f, "r")["name"] = "g"; }, "/scene/robots/1/name"},
        Case{"UnknownObject", [](Json& f) { f["scene"]["object"] = "x"; }, "/scene/object"},
        Case{"UnknownResting", [](Json& f) { object(f, "post")["resting"] = {"x"}; },
             "/scene/objects/3/resting"},
        Case{"UnknownRest", [](Json& f) { f["scene"]["start"]["rest"] = {"x"}; },
             "/scene/start/rest"},
        Case{"RestOfAnotherWord", [](Json& f) { f["scene"]["goal"]["rest"] = "nothing"; },
             "/scene/goal/rest"},
        Case{"HeldByNoArm", [](Json& f) { f["scene"]["start"]["held_by"] = "g"; },
             "/scene/start/held_by"},
        Case{"EndOfAnotherWord", [](Json& f) { f["scene"]["goal"]["end"] = "drop"; },
             "/scene/goal/end"},
        Case{"UprightWithoutAxis",
             [](Json& f) {
               f["scene"]["upright"] = {{"axis", {0, 0, 0}}, {"within_deg", 1}};
             },
             "/scene/upright/axis"},
        Case{"UnknownTouchLink",
             [](Json& f) { object(f, "sign")["attached_to"]["touch_links"] = {"x"}; },
             "/scene/objects/4/attached_to/touch_links"},
        Case{"UnknownRestingLink",
             [](Json& f) {
               robot(f, "g")["resting"] = {{"x", "table"}};
             },
             "/scene/robots/0/resting"},
        Case{"JointMissingInStart", [](Json& f) { robot(f, "g")["q_start"].erase("right"); },
             "/scene/robots/0/q_start: nothing for joint \"right\""},
        Case{"JointMissingInLimits", [](Json& f) { robot(f, "g")["limits"].erase("left"); },
             "/scene/robots/0/limits: nothing for joint \"left\""},
        Case{"UnknownJointInStart", [](Json& f) { robot(f, "g")["q_start"]["w"] = 0; },
             "/scene/robots/0/q_start/w"},
        Case{"FixedJointInLimits",
             [](Json& f) {
               robot(f, "g")["limits"]["tool_joint"] = {0, 0, 0, 0, 0};
             },
             "/scene/robots/0/limits/tool_joint"},
        Case{"FourLimits",
             [](Json& f) {
               robot(f, "g")["limits"]["x"] = {0, 1, 1, 1};
             },
             "/scene/robots/0/limits/x"},
        Case{"NoHolders", [](Json& f) { f["plan"]["holders"].clear(); }, "/plan/holders: empty"},
        Case{"UnknownRobotOfHolder", [](Json& f) { f["plan"]["holders"][1]["robot"] = "x"; },
             "/plan/holders/1/robot"},
        Case{"UnknownToolLink", [](Json& f) { f["plan"]["holders"][0]["tool_link"] = "x"; },
             "/plan/holders/0/tool_link: unknown link \"x\""},
        Case{"UnknownGripper", [](Json& f) { f["plan"]["holders"][0]["gripper"] = "magnet"; },
             "/plan/holders/0/gripper"},
        Case{"UnknownFinger", [](Json& f) { f["plan"]["holders"][0]["hand"]["fingers"][0] = "x"; },
             "/plan/holders/0/hand/fingers"},
        Case{"NoDexterity", [](Json& f) { f["plan"]["holders"][0]["dexterity"].erase("give"); },
             "/plan/holders/0/dexterity/give: missing"},
        Case{"NegativeSlack", [](Json& f) { f["plan"]["slack_s"] = -0.1; }, "/plan/slack_s"},
        Case{"HolderBeyondTheList", [](Json& f) { stageAt(f, 0)["holder"] = 2; },
             "/plan/stages/0/holder"},
        Case{"UnknownJointInStage", [](Json& f) { stageAt(f, 0)["joints"][0] = "w"; },
             "/plan/stages/0/joints"},
        Case{"JointTwiceInStage", [](Json& f) { stageAt(f, 0)["joints"][1] = "x"; },
             "/plan/stages/0/joints"},
        Case{"RowTooShort", [](Json& f) { stageAt(f, 3)["q"][2].erase(0); },
             "/plan/stages/3/q/2: 5 values for 6 joints"},
        Case{"RowMissing", [](Json& f) { stageAt(f, 3)["qd"].erase(0); }, "/plan/stages/3/qd"},
        Case{"AccelerationsMissing", [](Json& f) { stageAt(f, 3).erase("qdd"); },
             "/plan/stages/3/qdd: missing"},
        Case{"RowIsNumber", [](Json& f) { stageAt(f, 3)["q"][1] = 1; }, "/plan/stages/3/q/1"},
        Case{"HoldWithoutLink", [](Json& f) { stageAt(f, 3)["holding"][0].erase("link"); },
             "/plan/stages/3/holding/0/link"},
        Case{"HoldOfUnknownLink", [](Json& f) { stageAt(f, 3)["holding"][0]["link"] = "x"; },
             "/plan/stages/3/holding"},
        Case{"ClaimOfThree",
             [](Json& f) {
               stageAt(f, 3)["may_touch"][0] = {"a", "b", "c"};
             },
             "/plan/stages/3/may_touch/0"},
        Case{"ClaimOfUnknownBody",
             [](Json& f) {
               stageAt(f, 3)["may_touch"][0] = {"g/nothing", "box"};
             },
             "/plan/stages/3/may_touch"},
        Case{"EdgeToNoStage",
             [](Json& f) {
               stageAt(f, 3)["after"][0] = {99, 0.1};
             },
             "/plan/stages/3/after/0/0"},
        Case{"EdgeOfOne",
             [](Json& f) {
               stageAt(f, 3)["after"][0] = {2};
             },
             "/plan/stages/3/after/0"},
        Case{"IndexNotWhole", [](Json& f) { stageAt(f, 3)["index"] = 3.5; },
             "/plan/stages/3/index"},
        Case{"TooManyStages",
             [](Json& f) {
               for (int i = 0; i < 200; ++i) f["plan"]["stages"].push_back(stageAt(f, 0));
             },
             "/plan/stages: more than 128"}),
    [](const testing::TestParamInfo<Case>& entry) { return std::string(entry.param.name); });

TEST(UnreadableText, IsRefused) {
  const GantryCell cell;
  const std::string text = cell.plan().dump();
  for (const std::string& bad :
       {std::string(), std::string("not json"), text.substr(0, text.size() / 2), text + "x",
        std::string("{\"format\": 1e999}"), std::string("\xff\xfe"), std::string(100'000, '[')}) {
    const ProgramResult result = verifyText(cell, bad);
    EXPECT_EQ(result.exit_code, 2) << bad.substr(0, 40);
    EXPECT_THAT(result.output, HasSubstr("plan.json: ")) << bad.substr(0, 40);
    EXPECT_THAT(result.output, testing::Not(HasSubstr("exception"))) << bad.substr(0, 40);
  }
}

TEST(UnreadableText, SaysWhereItIsNoJsonInPlainWords) {
  const GantryCell cell;
  const auto said = [&cell](const std::string& text) {
    return verifyText(cell, text).json.value("unreadable", "");
  };
  EXPECT_THAT(said(""), HasSubstr(".json: line 1, column 1: not JSON: the text ends there"));
  EXPECT_THAT(said("{\n \"a\": [1,\n  2"),
              HasSubstr(".json: line 3, column 4: not JSON: the text ends there"));
  EXPECT_THAT(said("{\n \"a\": 1,\n}"),
              HasSubstr(".json: line 3, column 1: not JSON: unexpected '}'"));
  EXPECT_THAT(said("plan"), HasSubstr(".json: line 1, column 1: not JSON: unexpected 'p'"));
  EXPECT_THAT(said("{\"a\": 1e999}"),
              HasSubstr(".json: /: not JSON: a number beyond what a double holds"));
  EXPECT_THAT(said("{\n\xff}"),
              HasSubstr(".json: line 2, column 1: not JSON: unexpected byte 0xff"));
}

TEST(UnreadableText, KeyTwiceIsRefused) {
  const GantryCell cell;
  std::string text = cell.plan().dump();
  text.insert(1, "\"complete\":true,");
  const ProgramResult result = verifyText(cell, text);
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.output, HasSubstr("given twice"));
}

TEST(UnreadableFile, IsRefused) {
  const GantryCell cell;
  EXPECT_EQ(run("/nonexistent.json").exit_code, 2);
  EXPECT_EQ(run(cell.root().string()).exit_code, 2);
  EXPECT_EQ(run("").exit_code, 2);
  EXPECT_EQ(run("--no-such-option x").exit_code, 2);
  EXPECT_EQ(run("--help").exit_code, 0);
}

TEST(UnreadableYaml, IsRefused) {
  const GantryCell cell;
  Json plan = cell.plan();
  for (const char* bad : {"[1, 2]", "arms: [", "acceleration: fast", "arms: 3"}) {
    cell.write("robots/gantry/bad.yaml", bad);
    for (const char* name : {"g", "r"}) {
      robot(plan, name)["yaml"] = "robots/gantry/bad.yaml";
      robot(plan, name)["yaml_sha256"] = sha256(bad);
    }
    const ProgramResult result = verify(cell, plan);
    EXPECT_EQ(result.exit_code, 2) << bad << result.output;
    EXPECT_THAT(result.output, HasSubstr("bad.yaml")) << bad;
  }
}

TEST(UnreadableUrdf, IsRefusedUnlessItsHashAlreadyTells) {
  const GantryCell cell;
  const Json plan = cell.plan();
  cell.write("robots/gantry/gantry.srdf", "<robot name='gantry'><group></robot>");
  EXPECT_EQ(verify(cell, plan).exit_code, 2);
  // An exchanged URDF is a finding, even when nothing else can be made of it.
  cell.write("robots/gantry/gantry.urdf", "<robot name='other'><link name='base'/></robot>");
  const ProgramResult result = verify(cell, plan);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.kinds, testing::ElementsAre("hash", "hash"));
}

}  // namespace
}  // namespace handover::verify::test
