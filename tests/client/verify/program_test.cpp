// SPDX-License-Identifier: Apache-2.0
// The real program on a right plan, and on the same plan with one fault planted.
#include "gantry_plan.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

namespace handover::verify::test {
namespace {

using testing::Contains;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

class VerifyProgram : public testing::Test {
 protected:
  /// Plants a fault in the right plan and returns what the program says.
  ProgramResult spoiled(const std::function<void(Json&)>& fault) const {
    Json file = cell_.plan();
    fault(file);
    return verify(cell_, file);
  }

  void expectFound(const ProgramResult& result, const std::string& kind) const {
    EXPECT_EQ(result.exit_code, 1) << result.output;
    EXPECT_THAT(result.kinds, Contains(kind)) << result.output;
  }

  GantryCell cell_;
};

/// All times of the plan, stretched.
void stretchTime(Json& file, double factor) {
  for (Json& entry : file["plan"]["stages"]) {
    entry["start"] = entry["start"].get<double>() * factor;
    for (Json& t : entry["t"]) t = t.get<double>() * factor;
    for (Json& row : entry["qd"]) {
      for (Json& value : row) value = value.get<double>() / factor;
    }
  }
}

void shiftColumn(Json& stage, std::size_t column, double by) {
  for (Json& row : stage["q"]) row[column] = row[column].get<double>() + by;
}

TEST_F(VerifyProgram, PassesTheRightPlan) {
  const ProgramResult result = verify(cell_, cell_.plan());
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_TRUE(result.json["valid"]);
  EXPECT_THAT(result.kinds, IsEmpty());
  // It looked: every stage has states and pairs, and the fingers came near things.
  for (const Json& stage : result.json["checks"]["stages"]) {
    EXPECT_GT(stage["states"], 1) << stage;
    EXPECT_GT(stage["pairs"], 0) << stage;
  }
}

TEST_F(VerifyProgram, SpeaksPlainTextWithoutJson) {
  Json file = cell_.plan();
  cell_.write("plan.json", file.dump());
  const std::string arguments =
      (cell_.root() / "plan.json").string() + " --root " + cell_.root().string();
  EXPECT_EQ(run(arguments).output, "valid\n");
  file["plan"]["X_WO_goal"]["xyz"][1] = 0.01;
  cell_.write("plan.json", file.dump());
  const ProgramResult invalid = run(arguments);
  EXPECT_EQ(invalid.exit_code, 1);
  EXPECT_THAT(invalid.output, HasSubstr("receiver_place t="));
  EXPECT_THAT(invalid.output, HasSubstr("goal: the object ends away from the goal"));
}

TEST_F(VerifyProgram, FindsAShiftedJoint) {
  const auto result =
      spoiled([](Json& file) { shiftColumn(stage(file, "giver_approach"), 1, 0.003); });
  expectFound(result, "join");
}

TEST_F(VerifyProgram, FindsAJumpAtAJoin) {
  const auto result = spoiled([](Json& file) {
    Json& first = stage(file, "giver_transfer")["q"][0][2];
    first = first.get<double>() + 1e-7;
  });
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.kinds, ElementsAre("join"));
}

TEST_F(VerifyProgram, FindsAnObstaclePutBack) {
  const auto result = spoiled([](Json& file) {
    object(file, "post")["X_WO"]["xyz"] = {-0.15, 0, 0.25};
    object(file, "post")["geometry"]["size"] = {0.02, 0.02, 0.1};
  });
  expectFound(result, "collision");
  const Json& first = result.json["violations"][0];
  EXPECT_EQ(first["stage"], "giver_transfer");
  EXPECT_THAT(first["bodies"], Contains("post"));
}

TEST_F(VerifyProgram, FindsACollisionBetweenSamples) {
  // A thin wall that the receiver's hand is past on both sides at the plan file's own samples.
  const auto result = spoiled([](Json& file) {
    Json& reach = stage(file, "receiver_reach");
    Json& transfer = stage(file, "receiver_transfer");
    for (Json* entry : {&reach, &transfer}) {
      const std::size_t last = (*entry)["t"].size() - 1;
      for (const char* key : {"t", "q", "qd"}) {
        (*entry)[key] = {(*entry)[key][0], (*entry)[key][last]};
      }
    }
    Json wall = boxObject("wall", {0.001, 0.2, 0.001}, {0.4, 0, 0.3});
    file["plan"]["objects"].push_back(wall);
  });
  expectFound(result, "collision");
  EXPECT_THAT(result.json["violations"][0]["bodies"], Contains("wall"));
}

TEST_F(VerifyProgram, FindsTwoArmsThatMeet) {
  // The receiver goes on into the giver's hand.
  const auto result = spoiled([](Json& file) {
    file["plan"]["X_OT_receiver"]["xyz"] = {0, 0, -0.015};
    for (Json& entry : file["plan"]["stages"]) {
      const std::string kind = entry["kind"];
      if (kind.rfind("receiver", 0) == 0 && entry["joints"].size() > 1)
        shiftColumn(entry, 2, -0.045);
      for (Json& hold : entry["holding"]) {
        if (hold["robot"] == "r" && hold["object"] == "box") hold["X_LO"]["xyz"][2] = 0.015;
      }
    }
    robot(file, "r")["q_start"]["z"] = robot(file, "r")["q_start"]["z"].get<double>() - 0.045;
    object(file, "sign")["X_WO"]["xyz"][2] = 0.205;
  });
  expectFound(result, "collision");
  EXPECT_THAT(result.kinds, Not(Contains("join")));
  EXPECT_THAT(result.output, HasSubstr("g/left_finger"));
}

TEST_F(VerifyProgram, FindsContainment) {
  // A closed box around all of the giver's finger: surfaces never meet.
  const auto result = spoiled([](Json& file) {
    file["plan"]["objects"].push_back(boxObject("crate", {6, 6, 6}, {0, 0, 0}));
  });
  expectFound(result, "collision");
  EXPECT_THAT(result.json["violations"][0]["bodies"], Contains("crate"));
}

TEST_F(VerifyProgram, FindsASmallBoxInsideAMovingBody) {
  const auto result = spoiled([](Json& file) {
    // 2 mm cube in the middle of the giver's palm (20 mm thick) at the start.
    file["plan"]["objects"].push_back(boxObject("chip", {0.002, 0.002, 0.002}, {-0.66, 0, 0.2}));
  });
  expectFound(result, "collision");
  EXPECT_EQ(result.json["violations"][0]["stage"], "giver_reach");
  EXPECT_THAT(result.json["violations"][0]["bodies"], Contains("g/palm"));
}

TEST_F(VerifyProgram, FindsSwappedStages) {
  const auto result = spoiled([](Json& file) {
    Json& stages = file["plan"]["stages"];
    std::swap(stages[3], stages[4]);
  });
  expectFound(result, "order");
}

TEST_F(VerifyProgram, FindsAMissingStage) {
  expectFound(spoiled([](Json& file) { file["plan"]["stages"].erase(5); }), "order");
}

TEST_F(VerifyProgram, FindsAFasterClock) {
  const auto result = spoiled([](Json& file) { stretchTime(file, 0.9); });
  expectFound(result, "acceleration");
  EXPECT_THAT(result.kinds, Not(Contains("collision")));
  expectFound(spoiled([](Json& file) { stretchTime(file, 0.5); }), "velocity");
}

TEST_F(VerifyProgram, PassesASlowerClock) {
  EXPECT_EQ(spoiled([](Json& file) { stretchTime(file, 2.5); }).exit_code, 0);
}

TEST_F(VerifyProgram, FindsAVelocityThatOnlyTheCurveHas) {
  // Samples say rest at both ends; the cubic between them is at 1.5 times the mean speed.
  const auto result = spoiled([](Json& file) {
    robot(file, "g")["limits"]["x"][3] = 100;
    Json& reach = stage(file, "giver_reach");
    const std::size_t last = reach["t"].size() - 1;
    const double mean = 0.15 / 0.45;  // under the limit of 0.5
    reach["q"] = {reach["q"][0], reach["q"][last]};
    reach["qd"] = {reach["qd"][0], reach["qd"][last]};
    reach["t"] = {0.0, 0.15 / mean * 0.85};
    for (auto& [joint, limits] : robot(file, "g")["limits"].items()) limits[3] = 100;
  });
  expectFound(result, "velocity");
  EXPECT_THAT(result.kinds, Each(std::string("velocity")));
}

TEST_F(VerifyProgram, FindsAPositionThatOnlyTheCurveHas) {
  const auto result = spoiled([](Json& file) {
    robot(file, "g")["limits"]["yaw"] = {-0.001, 0.001, 1, 1};
    Json& reach = stage(file, "giver_reach");
    reach["qd"][4][3] = 0.4;  // the wrist swings out and back between samples
  });
  expectFound(result, "position");
}

TEST_F(VerifyProgram, FindsADroppedObject) {
  // The giver has let go before the receiver came: nobody is said to hold the box.
  const auto result = spoiled([](Json& file) {
    Json& holding = stage(file, "receiver_approach")["holding"];
    holding.erase(0);
  });
  expectFound(result, "holding");
}

TEST_F(VerifyProgram, FindsAForgottenAttachment) {
  expectFound(spoiled([](Json& file) { stage(file, "giver_lift")["holding"].erase(1); }),
              "holding");
}

TEST_F(VerifyProgram, FindsAHoldThatIsNone) {
  const auto result = spoiled([](Json& file) {
    Json& grasp = stage(file, "giver_grasp");
    grasp["holding"].push_back(stage(file, "giver_lift")["holding"][0]);
  });
  expectFound(result, "holding");
}

TEST_F(VerifyProgram, FindsAnObjectThatSlipsInTheHand) {
  const auto result = spoiled(
      [](Json& file) { stage(file, "giver_transfer")["holding"][0]["X_LO"]["xyz"][0] = 1e-5; });
  expectFound(result, "holding");
}

TEST_F(VerifyProgram, FindsAnObjectThatJumpsIntoTheHand) {
  const auto result = spoiled([](Json& file) {
    file["plan"]["X_WO_start"]["xyz"][1] = 0.0002;
    object(file, "box")["X_WO"]["xyz"][1] = 0.0002;
  });
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.kinds, ElementsAre("object_jump")) << result.output;
}

TEST_F(VerifyProgram, FindsAnObjectThatIsElsewhereAtTheStart) {
  expectFound(spoiled([](Json& file) { object(file, "box")["X_WO"]["xyz"][0] = -0.301; }),
              "object_start");
}

TEST_F(VerifyProgram, FindsAWrongHandoverPose) {
  expectFound(spoiled([](Json& file) { file["plan"]["X_WO_handover"]["xyz"][2] = 0.4002; }),
              "handover");
}

TEST_F(VerifyProgram, FindsAWrongGrasp) {
  expectFound(spoiled([](Json& file) { file["plan"]["X_OT_giver"]["xyz"][2] = -0.0298; }),
              "holding");
}

TEST_F(VerifyProgram, FindsAWrongGoal) {
  expectFound(spoiled([](Json& file) { file["plan"]["X_WO_goal"]["xyz"][1] = 0.0011; }), "goal");
  const auto turned = [](double degrees) {
    return [degrees](Json& file) {
      const double half = degrees / 2 * M_PI / 180;
      file["plan"]["X_WO_goal"]["quat_wxyz"] = {std::cos(half), 0, 0, std::sin(half)};
    };
  };
  expectFound(spoiled(turned(0.6)), "goal");
  EXPECT_EQ(spoiled(turned(0.4)).exit_code, 0);
  EXPECT_EQ(spoiled([](Json& file) { file["plan"]["X_WO_goal"]["xyz"][1] = 0.0009; }).exit_code, 0);
}

TEST_F(VerifyProgram, FindsAHandThatOpensEarly) {
  const auto result = spoiled([](Json& file) {
    Json& release = stage(file, "giver_release");
    release["start"] = release["start"].get<double>() - 0.1;
  });
  expectFound(result, "sequence");
}

TEST_F(VerifyProgram, FindsFingersThatMoveInAnArmStage) {
  const auto result = spoiled([](Json& file) {
    Json& transfer = stage(file, "giver_transfer");
    transfer["joints"].push_back("left");
    for (Json& row : transfer["q"]) row.push_back(0.0205);
    for (Json& row : transfer["qd"]) row.push_back(0.0);
  });
  expectFound(result, "joints");
}

TEST_F(VerifyProgram, FindsAMimicJointThatIsDriven) {
  const auto result = spoiled([](Json& file) { stage(file, "giver_grasp")["joints"] = {"right"}; });
  expectFound(result, "joints");
}

TEST_F(VerifyProgram, FindsAReceiverThatComesBeforeTheGiverCarries) {
  expectFound(spoiled([](Json& file) { stage(file, "receiver_reach")["start"] = 0.0; }),
              "sequence");
}

TEST_F(VerifyProgram, PassesAReceiverThatComesFromTheLiftOn) {
  const auto result = spoiled([](Json& file) {
    // As early as the contract has it; then it waits for the giver.
    const double lift = stage(file, "giver_lift")["start"];
    const double early = stage(file, "receiver_reach")["start"].get<double>() - lift;
    for (const char* kind : {"receiver_reach", "receiver_approach"}) {
      stage(file, kind)["start"] = stage(file, kind)["start"].get<double>() - early;
    }
  });
  EXPECT_EQ(result.exit_code, 0) << result.output;
}

TEST_F(VerifyProgram, FindsAReceiverThatGraspsWhileTheGiverCarries) {
  const auto result = spoiled([](Json& file) {
    // The giver stops a little later than it should.
    Json& transfer = stage(file, "giver_transfer");
    transfer["start"] = stage(file, "receiver_grasp")["start"].get<double>() -
                        transfer["t"].back().get<double>() + 0.005;
  });
  expectFound(result, "sequence");
}

TEST_F(VerifyProgram, FindsAnObjectThatLeavesBeforeTheGiversHandIsOpen) {
  const auto result = spoiled([](Json& file) {
    Json& transfer = stage(file, "receiver_transfer");
    transfer["start"] = transfer["start"].get<double>() - 0.01;
  });
  expectFound(result, "sequence");
}

TEST_F(VerifyProgram, FindsAnObjectMovedIntoTheHandThatStillLeaves) {
  // Sideways at once, between fingers that are open but have not got past the box.
  const auto result = spoiled([](Json& file) {
    Json& transfer = stage(file, "receiver_transfer");
    const double before = transfer["t"].back();
    Json aside = transfer["q"].front();
    aside[1] = aside[1].get<double>() + 0.05;
    transfer["q"] = {transfer["q"].front(), aside, transfer["q"].back()};
    transfer["qd"] = {transfer["qd"].front(), transfer["qd"].front(), transfer["qd"].front()};
    transfer["t"] = {0.0, 0.56, 2.6};
    for (const char* kind : {"receiver_place", "receiver_release", "receiver_retreat"}) {
      stage(file, kind)["start"] = stage(file, kind)["start"].get<double>() + 2.6 - before;
    }
  });
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.kinds, Each("collision")) << result.output;
  EXPECT_THAT(result.output, HasSubstr("g/right_finger"));
}

TEST_F(VerifyProgram, FindsAReceiverThatLetsGoBeforeTheGiverIsHome) {
  const auto result = spoiled([](Json& file) {
    Json& retreat = stage(file, "giver_retreat");
    const double late = stage(file, "receiver_release")["start"].get<double>() + 0.1 -
                        retreat["start"].get<double>() - retreat["t"].back().get<double>();
    retreat["start"] = retreat["start"].get<double>() + late;
  });
  expectFound(result, "sequence");
}

TEST_F(VerifyProgram, FindsOverlapOfOneRobotsStages) {
  const auto result = spoiled([](Json& file) {
    Json& lift = stage(file, "giver_lift");
    lift["start"] = lift["start"].get<double>() - 1e-6;
  });
  expectFound(result, "overlap");
}

TEST_F(VerifyProgram, FindsTheWrongRobot) {
  expectFound(spoiled([](Json& file) { stage(file, "giver_lift")["robot"] = "r"; }), "robot");
}

TEST_F(VerifyProgram, FindsContactsSmuggledIn) {
  const auto result = spoiled([](Json& file) {
    stage(file, "giver_transfer")["may_touch"].push_back({"g/palm", "post"});
  });
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.kinds, ElementsAre("contact_smuggled"));
  expectFound(spoiled([](Json& file) {
                stage(file, "giver_transfer")["may_touch"].push_back({"box", "table"});
              }),
              "contact_smuggled");
  // What O is to rest on is found, not believed.
  expectFound(spoiled([](Json& file) {
                stage(file, "receiver_place")["may_touch"].push_back({"box", "post"});
              }),
              "contact_smuggled");
}

TEST_F(VerifyProgram, DoesNotBelieveSmuggledContacts) {
  const auto result = spoiled([](Json& file) {
    object(file, "post")["X_WO"]["xyz"] = {-0.15, 0, 0.25};
    stage(file, "giver_transfer")["may_touch"].push_back({"box", "post"});
  });
  expectFound(result, "contact_smuggled");
  expectFound(result, "collision");
}

TEST_F(VerifyProgram, FindsAnObjectDraggedOverItsRest) {
  // Lifted by nothing, then carried: the rest may be touched while lifting only.
  const auto result = spoiled([](Json& file) {
    Json& lift = stage(file, "giver_lift");
    for (Json& row : lift["q"]) row = lift["q"][0];
    for (Json& row : lift["qd"]) row = lift["qd"][0];
    Json& transfer = stage(file, "giver_transfer");
    transfer["q"][0] = lift["q"][0];
  });
  expectFound(result, "collision");
  EXPECT_THAT(result.output, HasSubstr("\"table\""));
}

TEST_F(VerifyProgram, FindsAHandThatStillTouchesAfterFiveMillimetres) {
  // Fingers that stay closed to a gap of less than nothing drag along the box.
  const auto result = spoiled([](Json& file) {
    Json& release = stage(file, "receiver_release");
    stage(file, "receiver_grasp")["q"].back()[0] = 0.0199;
    for (Json& row : release["q"]) row[0] = 0.0199;
    for (Json& row : release["qd"]) row[0] = 0.0;
  });
  expectFound(result, "collision");
  bool in_retreat = false;
  for (const Json& violation : result.json["violations"]) {
    in_retreat |= violation["stage"] == "receiver_retreat" && violation["kind"] == "collision";
  }
  EXPECT_TRUE(in_retreat) << result.output;
}

TEST_F(VerifyProgram, FindsAGraspWithOneFinger) {
  // The box stands to one side: the right finger is 3 mm away.
  const auto result = spoiled([](Json& file) {
    object(file, "box")["geometry"] = {
        {"type", "compound"},
        {"parts",
         {{{"X_OS", {{"xyz", {0, 0.00175, 0}}, {"quat_wxyz", {1, 0, 0, 0}}}},
           {"geometry", {{"type", "box"}, {"size", {0.04, 0.0365, 0.12}}}}}}}};
  });
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.kinds, ElementsAre("grasp", "grasp")) << result.output;
}

TEST_F(VerifyProgram, FindsAGraspWithoutOpposingContacts) {
  // Both fingers lie on one face of a plate that fills the hand from one side.
  const auto result = spoiled([](Json& file) {
    object(file, "box")["geometry"] = {
        {"type", "compound"},
        {"parts",
         {{{"X_OS", {{"xyz", {0.0415, 0, 0}}, {"quat_wxyz", {1, 0, 0, 0}}}},
           {"geometry", {{"type", "box"}, {"size", {0.04, 0.2, 0.12}}}}}}}};
  });
  expectFound(result, "grasp");
  EXPECT_THAT(result.output, HasSubstr("contact normals differ by at most 0 deg"));
}

TEST_F(VerifyProgram, AcceptsAGraspThatPressesIn) {
  const auto result = spoiled([](Json& file) {
    for (const char* kind : {"giver_grasp", "receiver_grasp"})
      stage(file, kind)["q"].back()[0] = 0.0195;
    for (const char* kind : {"giver_release", "receiver_release"})
      stage(file, kind)["q"].front()[0] = 0.0195;
    for (auto& robot_entry : file["plan"]["robots"])
      robot_entry["limits"]["left"][3] = robot_entry["limits"]["right"][3] = 100;
  });
  EXPECT_EQ(result.exit_code, 0) << result.output;
}

TEST_F(VerifyProgram, FindsLimitsWiderThanTheUrdf) {
  expectFound(spoiled([](Json& file) { robot(file, "g")["limits"]["x"][1] = 1.6; }), "limits");
  expectFound(spoiled([](Json& file) { robot(file, "r")["limits"]["z"][2] = 0.6; }), "limits");
  EXPECT_EQ(spoiled([](Json& file) { robot(file, "g")["limits"]["x"][1] = 1.4; }).exit_code, 0);
}

TEST_F(VerifyProgram, FindsAnotherUrdf) {
  const auto result =
      spoiled([](Json& file) { robot(file, "g")["urdf_sha256"] = std::string(64, 'a'); });
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.kinds, ElementsAre("urdf_hash"));
}

TEST_F(VerifyProgram, FindsABrokenMimicLaw) {
  const auto result = spoiled([](Json& file) { robot(file, "g")["q_start"]["right"] = 0.03; });
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.kinds, ElementsAre("mimic"));
}

TEST_F(VerifyProgram, FindsAStartOutsideTheLimits) {
  expectFound(spoiled([](Json& file) { robot(file, "g")["q_start"]["pitch"] = 1.1; }), "q_start");
}

TEST_F(VerifyProgram, FindsWrongDexterities) {
  for (const char* name : {"receiver_place", "receiver_handover", "giver_pick", "giver_handover"}) {
    const auto result = spoiled([name](Json& file) { file["plan"]["dexterity"][name] = 1.00001; });
    EXPECT_THAT(result.kinds, ElementsAre("dexterity")) << name;
  }
}

TEST_F(VerifyProgram, FindsSpeedAtTheEnds) {
  expectFound(spoiled([](Json& file) { stage(file, "giver_reach")["qd"][0][0] = 0.01; }), "rest");
  expectFound(spoiled([](Json& file) { stage(file, "receiver_retreat")["qd"].back()[2] = -0.01; }),
              "rest");
}

TEST_F(VerifyProgram, FindsTimesThatDoNotRise) {
  expectFound(spoiled([](Json& file) {
                Json& t = stage(file, "giver_reach")["t"];
                t[3] = t[2];
              }),
              "samples");
  expectFound(spoiled([](Json& file) { stage(file, "giver_reach")["t"][0] = 0.001; }), "samples");
}

TEST_F(VerifyProgram, FindsARetreatThatEndsElsewhere) {
  const auto result = spoiled([](Json& file) {
    Json& last = stage(file, "receiver_retreat")["q"].back()[1];
    last = last.get<double>() + 0.001;
  });
  EXPECT_THAT(result.kinds, Contains("posture"));
}

TEST_F(VerifyProgram, FindsAnAttachmentThatIsNotWhereItIsHeld) {
  expectFound(spoiled([](Json& file) { object(file, "sign")["X_WO"]["xyz"][1] = 0.01; }),
              "object_start");
}

TEST_F(VerifyProgram, LeavesStandingPairsAlone) {
  // A peg through the giver's base, which never moves, and one in the sign, which is said to touch.
  const auto result = spoiled([](Json& file) {
    file["plan"]["objects"].push_back(boxObject("peg", {0.01, 0.01, 0.2}, {-0.8, 0, -0.5}));
    file["plan"]["objects"].push_back(boxObject("nail", {0.01, 0.01, 0.05}, {0.3, 0, 0}));
  });
  EXPECT_EQ(result.exit_code, 1);  // the nail sticks into the shelf under the box, and out of it
  for (const Json& violation : result.json["violations"]) {
    EXPECT_THAT(violation["bodies"], Not(Contains("peg")));
  }
  EXPECT_THAT(result.output, HasSubstr("nail"));
}

}  // namespace
}  // namespace handover::verify::test
