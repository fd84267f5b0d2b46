// SPDX-License-Identifier: Apache-2.0
// Faults of the scene, of the chain and of the list of stages.
#include "spoiled_plan.hpp"

#include <string>
#include <utility>
#include <vector>

namespace handover::verify::test {
namespace {

using testing::HasSubstr;

class SceneFault : public SpoiledPlan {
 protected:
  static PlanOptions alone() {
    PlanOptions options;
    options.holders = 1;
    return options;
  }

  static PlanOptions suction() {
    PlanOptions options;
    options.suction = true;
    return options;
  }
};

TEST_F(SceneFault, Hash) {
  for (const char* key : {"urdf_sha256", "yaml_sha256"}) {
    expectOnly("hash", [key](Json& file) { robot(file, "g")[key] = std::string(64, 'a'); });
  }
}

TEST_F(SceneFault, LimitsWiderThanTheFilesSay) {
  const auto claim = [](const char* name, const char* joint, std::size_t entry, Json value) {
    return [=](Json& file) { robot(file, name)["limits"][joint][entry] = value; };
  };
  expectOnly("limits", claim("g", "x", 0, -0.6));
  expectOnly("limits", claim("g", "x", 1, 1.6));
  expectOnly("limits", claim("r", "z", 2, 0.6));
  expectOnly("limits", claim("r", "z", 3, 1.1));     // the arm's, of the yaml
  expectOnly("limits", claim("r", "z", 4, 10.5));    // ten times the acceleration
  expectOnly("limits", claim("g", "left", 3, 1.1));  // the hand's
  expectOnly("limits", claim("g", "left", 4, 21));
  expectOnly("limits", claim("g", "yaw", 1, nullptr));  // not a joint without end
  expectValid(claim("g", "x", 1, 1.4));
  expectValid(claim("g", "yaw", 2, 0.5));
}

TEST_F(SceneFault, LimitsOfAFollowerMayBeLeftOut) {
  expectValid([](Json& file) { robot(file, "g")["limits"].erase("right"); });
}

TEST_F(SceneFault, StartOutsideTheLimits) {
  expectOnly("start", alone(), [](Json& file) { robot(file, "r")["q_start"]["pitch"] = 1.1; });
}

TEST_F(SceneFault, BrokenMimicLaw) {
  expectOnly("mimic", alone(), [](Json& file) { robot(file, "r")["q_start"]["right"] = 0.03; });
}

TEST_F(SceneFault, ObjectsThatAreElsewhere) {
  expectOnly("scene", [](Json& file) { object(file, "box")["X_WO"]["xyz"][0] = -0.301; });
  expectOnly("scene", [](Json& file) { object(file, "sign")["X_WO"]["xyz"][1] = 0.01; });
}

TEST_F(SceneFault, TheObjectIsAttachedOrRests) {
  expectOnly("scene", [](Json& file) {
    object(file, "box")["attached_to"] = object(file, "sign")["attached_to"];
  });
  expectOnly("scene", [](Json& file) { object(file, "box")["resting"] = {"table"}; });
}

TEST_F(SceneFault, Chain) {
  expectOnly("chain", [](Json& file) { file["plan"]["handovers"].clear(); });
  expectOnly("chain", [](Json& file) { file["plan"]["holders"][0]["arm"] = "hand"; });
  expectOnly("chain", [](Json& file) { file["plan"]["holders"][1]["hand"]["palm"] = "z_link"; });
  expectOnly("chain",
             [](Json& file) { file["plan"]["holders"][1]["hand"]["fingers"][1] = "wrist_2"; });
  expectOnly("chain", [](Json& file) { file["plan"]["holders"][0]["tool_link"] = "base"; });
  expectOnly("chain", [](Json& file) { file["plan"]["holders"][1] = file["plan"]["holders"][0]; });
  expectOnly("chain", suction(),
             [](Json& file) { file["plan"]["holders"][0]["hand"]["cup_link"] = "z_link"; });
  PlanOptions held;
  held.held_at_start = true;
  expectOnly("chain", held, [](Json& file) { file["scene"]["start"]["held_by"] = "r/arm"; });
}

TEST_F(SceneFault, ListOfStages) {
  expectOnly("stages",
             [](Json& file) { std::swap(file["plan"]["stages"][3], file["plan"]["stages"][4]); });
  expectOnly("stages", [](Json& file) { file["plan"]["stages"].erase(15); });
  expectOnly("stages", [](Json& file) { stage(file, 0, "lift")["index"] = 4; });
  expectOnly("stages", [](Json& file) { stage(file, 0, "lift")["action"] = "raise"; });
  expectOnly("stages", [](Json& file) { stage(file, 1, "place")["holder"] = 0; });
  expectOnly("stages", [](Json& file) { stage(file, 0, "lift")["robot"] = "r"; });
  // Held at the start, the first has nothing to reach for; kept, the last has nothing to place.
  expectOnly("stages", [](Json& file) { file["scene"]["start"]["held_by"] = "g/arm"; });
  expectOnly("stages", [](Json& file) { file["scene"]["goal"]["end"] = "hold"; });
}

TEST_F(SceneFault, JointsThatAStageMayNotMove) {
  const auto still = [](Json& entry, const char* joint, double at) {
    entry["joints"].push_back(joint);
    for (Json& row : entry["q"]) row.push_back(at);
    for (const char* key : {"qd", "qdd"}) {
      for (Json& row : entry[key]) row.push_back(0.0);
    }
  };
  for (const char* action : {"approach", "lift", "carry", "retreat"}) {
    expectOnly("joints", [&](Json& file) { still(stage(file, 0, action), "left", 0.0205); });
  }
  expectOnly("joints", [&](Json& file) { still(stage(file, 1, "place"), "left", 0.0205); });
  expectOnly("joints", [&](Json& file) { still(stage(file, 0, "grasp"), "pitch", 0); });
  expectOnly("joints", [&](Json& file) { still(stage(file, 0, "release"), "pitch", 0); });
  expectOnly("joints", [](Json& file) { stage(file, 0, "grasp")["joints"] = {"right"}; });
  // A hand may open on the way.
  expectValid([&](Json& file) { still(stage(file, 0, "reach"), "left", 0.04); });
  expectValid([&](Json& file) { still(stage(file, 0, "home"), "left", 0.04); });
}

TEST_F(SceneFault, GripperStagesWithoutTheirJointsOrWithSome) {
  expectOnly("joints", [](Json& file) {
    Json& grasp = stage(file, 0, "grasp");
    grasp["joints"] = Json::array();
    for (const char* key : {"q", "qd", "qdd"}) {
      for (Json& row : grasp[key]) row = Json::array();
    }
  });
  expectOnly("joints", suction(), [](Json& file) {
    Json& grasp = stage(file, 0, "grasp");
    grasp["joints"] = {"pitch"};
    for (const char* key : {"q", "qd", "qdd"}) {
      for (Json& row : grasp[key]) row = {0.0};
    }
  });
}

TEST_F(SceneFault, SamplesInTime) {
  expectOnly("samples", [](Json& file) {
    Json& t = stage(file, 0, "reach")["t"];
    t[3] = t[2];
  });
  expectOnly("samples", [](Json& file) {
    Json& t = stage(file, 0, "reach")["t"];
    t[3] = t[2].get<double>() + 0.0009;
  });
  expectOnly("samples", [](Json& file) { stage(file, 0, "reach")["t"][0] = 0.001; });
  expectOnly("samples", [](Json& file) { stage(file, 0, "reach")["start"] = -0.1; });
  expectOnly("samples", [](Json& file) {
    for (const char* key : {"t", "q", "qd", "qdd"}) {
      Json& rows = stage(file, 0, "reach")[key];
      rows = {rows[0]};
    }
  });
}

TEST_F(SceneFault, StagesThatShareAJointOverlap) {
  const auto earlier = [](const char* action) {
    return [action](Json& file) { addTo(stage(file, 0, action)["start"], -1e-6); };
  };
  // Grasp and lift have no joint in common; approach and reach have.
  const auto lift = spoiled({}, earlier("lift"));
  EXPECT_THAT(lift.kinds, testing::UnorderedElementsAre("order", "holding")) << lift.output;
  const auto approach = spoiled({}, earlier("approach"));
  EXPECT_THAT(approach.kinds, testing::ElementsAre("overlap")) << approach.output;
  EXPECT_THAT(approach.output, HasSubstr("g arm reach"));
}

}  // namespace
}  // namespace handover::verify::test
