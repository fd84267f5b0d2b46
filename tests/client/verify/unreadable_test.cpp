// SPDX-License-Identifier: Apache-2.0
// Malformed plan files and files that they name: exit 2, and the field by name.
#include "gantry_plan.hpp"

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
        Case{"WrongFormat", [](Json& f) { f["format"] = "handover-plan/2"; }, "/format"},
        Case{"NoPlan", [](Json& f) { f.erase("plan"); }, "/plan: missing"},
        Case{"CompleteIsText", [](Json& f) { f["complete"] = "yes"; }, "/complete"},
        Case{"NoSeed", [](Json& f) { f["plan"].erase("seed"); }, "/plan/seed: missing"},
        Case{"NegativeSeed", [](Json& f) { f["plan"]["seed"] = -1; }, "/plan/seed"},
        Case{"HashNotHex", [](Json& f) { robot(f, "g")["urdf_sha256"] = "xyz"; },
             "/plan/robots/0/urdf_sha256"},
        Case{"ShortQuaternion",
             [](Json& f) {
               f["plan"]["X_WO_goal"]["quat_wxyz"] = {1, 0, 0};
             },
             "/plan/X_WO_goal/quat_wxyz"},
        Case{"QuaternionNotUnit",
             [](Json& f) {
               f["plan"]["X_WO_start"]["quat_wxyz"] = {1.01, 0, 0, 0};
             },
             "/plan/X_WO_start/quat_wxyz"},
        Case{"PositionIsText", [](Json& f) { f["plan"]["X_WO_goal"]["xyz"][1] = "0"; },
             "/plan/X_WO_goal/xyz/1"},
        Case{"NullCoordinate", [](Json& f) { object(f, "post")["X_WO"]["xyz"][0] = nullptr; },
             "/plan/objects/3/X_WO/xyz/0"},
        Case{"HugeCoordinate", [](Json& f) { object(f, "post")["X_WO"]["xyz"][0] = 1e300; },
             "/plan/objects/3/X_WO/xyz/0"},
        Case{"UnknownGeometry", [](Json& f) { object(f, "post")["geometry"]["type"] = "cone"; },
             "/plan/objects/3/geometry/type"},
        Case{"NegativeBox",
             [](Json& f) {
               object(f, "post")["geometry"]["size"] = {0.1, -0.1, 0.1};
             },
             "/plan/objects/3/geometry/size"},
        Case{"EmptyCompound",
             [](Json& f) {
               object(f, "post")["geometry"] = {{"type", "compound"}, {"parts", Json::array()}};
             },
             "/plan/objects/3/geometry/parts"},
        Case{"EndlessCompound",
             [](Json& f) {
               Json geometry = {{"type", "sphere"}, {"radius", 1}};
               for (int i = 0; i < 10; ++i) {
                 geometry = {
                     {"type", "compound"},
                     {"parts", {{{"X_OS", f["plan"]["X_WO_goal"]}, {"geometry", geometry}}}}};
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
             "/plan/robots/0/urdf"},
        Case{"UrdfMissing", [](Json& f) { robot(f, "g")["urdf"] = "robots/none.urdf"; },
             "none.urdf: no such file"},
        Case{"RobotTwice", [](Json& f) { robot(f, "r")["name"] = "g"; }, "/plan/robots/1/name"},
        Case{"UnknownGiver", [](Json& f) { f["plan"]["giver"] = "x"; }, "/plan/giver"},
        Case{"UnknownObject", [](Json& f) { f["plan"]["object"] = "x"; }, "/plan/object"},
        Case{"UnknownRest", [](Json& f) { object(f, "box")["resting"] = {"x"}; },
             "/plan/objects/0/resting"},
        Case{"UnknownToolLink", [](Json& f) { f["plan"]["giver_tool_link"] = "x"; },
             "no link \"x\""},
        Case{"UnknownTouchLink",
             [](Json& f) { object(f, "sign")["attached_to"]["touch_links"] = {"x"}; },
             "/plan/objects/4/attached_to/touch_links"},
        Case{"UnknownRestingLink",
             [](Json& f) {
               robot(f, "g")["resting"] = {{"x", "table"}};
             },
             "/plan/robots/0/resting"},
        Case{"JointMissingInStart", [](Json& f) { robot(f, "g")["q_start"].erase("right"); },
             "/plan/robots/0/q_start: nothing for joint \"right\""},
        Case{"UnknownJointInStart", [](Json& f) { robot(f, "g")["q_start"]["w"] = 0; },
             "/plan/robots/0/q_start/w"},
        Case{"FixedJointInLimits",
             [](Json& f) {
               robot(f, "g")["limits"]["tool_joint"] = {0, 0, 0, 0};
             },
             "/plan/robots/0/limits/tool_joint"},
        Case{"ThreeLimits",
             [](Json& f) {
               robot(f, "g")["limits"]["x"] = {0, 1, 1};
             },
             "/plan/robots/0/limits/x"},
        Case{"UnknownJointInStage", [](Json& f) { stageAt(f, 0)["joints"][0] = "w"; },
             "/plan/stages/0/joints"},
        Case{"JointTwiceInStage", [](Json& f) { stageAt(f, 0)["joints"][1] = "x"; },
             "/plan/stages/0/joints"},
        Case{"RowTooShort", [](Json& f) { stageAt(f, 3)["q"][2].erase(0); },
             "/plan/stages/3/q/2: 5 values for 6 joints"},
        Case{"RowMissing", [](Json& f) { stageAt(f, 3)["qd"].erase(0); }, "/plan/stages/3/qd"},
        Case{"RowIsNumber", [](Json& f) { stageAt(f, 3)["q"][1] = 1; }, "/plan/stages/3/q/1"},
        Case{"NoSamples",
             [](Json& f) {
               for (const char* key : {"t", "q", "qd"}) stageAt(f, 2)[key] = Json::array();
             },
             "/plan/stages/2/t"},
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
        Case{"IndexNotWhole", [](Json& f) { stageAt(f, 3)["index"] = 3.5; },
             "/plan/stages/3/index"},
        Case{"TooManyStages",
             [](Json& f) {
               for (int i = 0; i < 100; ++i) f["plan"]["stages"].push_back(stageAt(f, 0));
             },
             "/plan/stages: more than 64"}),
    [](const testing::TestParamInfo<Case>& entry) { return std::string(entry.param.name); });

TEST(UnreadableText, IsRefused) {
  const GantryCell cell;
  const std::string text = cell.plan().dump();
  for (const std::string& bad :
       {std::string(), std::string("not json"), text.substr(0, text.size() / 2), text + "x",
        std::string("{\"format\": 1e999}"), std::string("\xff\xfe"), std::string(100'000, '[')}) {
    const ProgramResult result = verifyText(cell, bad);
    EXPECT_EQ(result.exit_code, 2) << bad.substr(0, 40);
    EXPECT_THAT(result.output, HasSubstr(".json: /: ")) << bad.substr(0, 40);
  }
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

TEST(UnreadableUrdf, IsRefusedUnlessItsHashAlreadyTells) {
  const GantryCell cell;
  const Json plan = cell.plan();
  cell.write("robots/gantry/gantry.srdf", "<robot name='gantry'><group></robot>");
  EXPECT_EQ(verify(cell, plan).exit_code, 2);
  // An exchanged URDF is a finding, even when nothing else can be made of it.
  cell.write("robots/gantry/gantry.urdf", "<robot name='other'><link name='base'/></robot>");
  const ProgramResult result = verify(cell, plan);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.kinds, testing::ElementsAre("urdf_hash", "urdf_hash"));
}

}  // namespace
}  // namespace handover::verify::test
