// SPDX-License-Identifier: Apache-2.0
// Faults of contacts, rests and grips.
#include "spoiled_plan.hpp"

#include <cmath>
#include <string>
#include <vector>

namespace handover::verify::test {
namespace {

using testing::AnyOf;
using testing::Contains;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;

class ContactFault : public SpoiledPlan {
 protected:
  static PlanOptions suction() {
    PlanOptions options;
    options.suction = true;
    return options;
  }

  static PlanOptions held() {
    PlanOptions options;
    options.held_at_start = true;
    return options;
  }

  static PlanOptions closing(double to) {
    PlanOptions options;
    options.closed = to;
    return options;
  }

  static void eraseClaims(Json& file, const std::string& body) {
    for (Json& entry : file["plan"]["stages"]) {
      Json kept = Json::array();
      for (const Json& pair : entry["may_touch"]) {
        if (pair[0] != body && pair[1] != body) kept.push_back(pair);
      }
      entry["may_touch"] = kept;
    }
  }

  static void put(Json& file, const std::string& name, const std::vector<double>& size,
                  const std::vector<double>& xyz) {
    file["scene"]["objects"].push_back(boxObject(name, size, xyz));
  }
};

TEST_F(ContactFault, AnObstacleInTheWay) {
  expectOnly("contact", [](Json& file) { put(file, "gate", {0.02, 0.02, 0.1}, {-0.15, 0, 0.25}); });
}

TEST_F(ContactFault, AnObstacleThatSamplesMiss) {
  // A rod of 2 mm that the receiver's hand is past on both sides of a sample.
  expectOnly("contact", [](Json& file) {
    for (const char* action : {"reach", "home"}) {
      Json& entry = stage(file, 1, action);
      for (const char* key : {"t", "q", "qd", "qdd"}) {
        entry[key] = {entry[key][0], entry[key].back()};
      }
    }
    put(file, "rod", {0.002, 0.2, 0.002}, {0.4, 0, 0.3});
  });
}

TEST_F(ContactFault, AThingAroundAnother) {
  const auto result = spoiled({}, [](Json& file) { put(file, "crate", {6, 6, 6}, {0, 0, 0}); });
  EXPECT_THAT(result.kinds, Contains("contact")) << result.output;
  EXPECT_THAT(result.kinds, Each(AnyOf("contact", "rest")));  // the box stands in it, too
  // 4 mm in the middle of the giver's palm, which is 20 mm thick.
  expectOnly("contact", [](Json& file) { put(file, "chip", {4e-3, 4e-3, 4e-3}, {-0.66, 0, 0.2}); });
}

TEST_F(ContactFault, ThingsThatNeverMove) {
  const auto peg = [](Json& file) { put(file, "peg", {0.01, 0.01, 0.2}, {-0.8, 0, -0.5}); };
  const auto result = spoiled({}, peg);
  EXPECT_THAT(result.kinds, ElementsAre("contact")) << result.output;
  EXPECT_EQ(result.json["violations"][0]["time"], 0);
  EXPECT_TRUE(result.json["violations"][0]["stage"].is_null());
  // Unless they are said to stand so.
  expectValid([&](Json& file) {
    peg(file);
    robot(file, "g")["resting"].push_back({"base", "peg"});
  });
  expectOnly("contact", [](Json& file) {
    put(file, "nail", {0.01, 0.01, 0.1}, {0.4, 0.2, -0.02});
  });
  expectValid([](Json& file) {
    put(file, "nail", {0.01, 0.01, 0.1}, {0.4, 0.2, -0.02});
    object(file, "nail")["resting"] = {"shelf"};
  });
}

TEST_F(ContactFault, TouchingByLessThanHalfAMillimetreIsForgiven) {
  const auto nail = [](double deep) {
    return [deep](Json& file) { put(file, "nail", {0.01, 0.01, 0.1}, {0.4, 0.2, 0.05 - deep}); };
  };
  expectValid(nail(4e-4));
  expectOnly("contact", nail(6e-4));
}

TEST_F(ContactFault, TheArmsMeet) {
  // The receiver grips lower, where the giver has its hand.
  const auto result = spoiled({}, [](Json& file) {
    file["plan"]["holders"][1]["X_OT"]["xyz"] = {0, 0, -0.015};
    for (Json& entry : file["plan"]["stages"]) {
      if (entry["robot"] == "r" && entry["joints"].size() > 1) {
        for (Json& row : entry["q"]) addTo(row[2], -0.045);
      }
      for (Json& hold : entry["holding"]) {
        if (hold["robot"] == "r" && hold["object"] == "box") hold["X_LO"]["xyz"][2] = 0.015;
      }
    }
    addTo(robot(file, "r")["q_start"]["z"], -0.045);
    object(file, "sign")["X_WO"]["xyz"][2] = 0.205;
  });
  EXPECT_THAT(result.kinds, Contains("contact")) << result.output;
  EXPECT_THAT(result.kinds, Each(AnyOf("contact", "order"))) << result.output;
  EXPECT_THAT(result.output, HasSubstr("g/left_finger"));
}

/// Fixes a cube to the receiver's arm. @param at in the frame of its z_link, before it by x.
void addDot(Json& file, const std::vector<double>& at, double edge) {
  Json dot = boxObject("dot", {edge, edge, edge}, {});
  dot["X_WO"] = pose({0.64 - at[0], -at[1], at[2] + 0.2}, {0, 0, 0, 1});
  dot["attached_to"] = {{"robot", "r"},
                        {"link", "z_link"},
                        {"X_LO", pose(at)},
                        {"touch_links", {"palm", "left_finger", "right_finger"}}};
  file["scene"]["objects"].push_back(dot);
  for (Json& entry : file["plan"]["stages"]) {
    entry["holding"].push_back(
        {{"object", "dot"}, {"robot", "r"}, {"link", "z_link"}, {"X_LO", pose(at)}});
  }
}

TEST_F(ContactFault, ArmsMeetOnlyWhenOneIsLate) {
  // On the way with the box, it passes where the giver's hand has left a second ago.
  const auto dot = [](Json& file) { addDot(file, {0.5011, -0.0440, -0.0508}, 0.021); };
  PlanOptions options;
  options.slack = 0.5;
  expectValid(options, dot);
  options.slack = 1;
  const auto result = spoiled(options, dot);
  EXPECT_THAT(result.kinds, ElementsAre("order")) << result.output;
  EXPECT_THAT(result.output, HasSubstr("g/palm touches dot when r arm carry is "));
}

TEST_F(ContactFault, ArmsMeetOnlyWhenStagesAreRunInTurn) {
  const auto result = spoiled({}, [](Json& file) {
    addDot(file, {0.8708, 0.0574, 0.0010}, 0.0279);
  });
  EXPECT_THAT(result.kinds, testing::Not(testing::IsEmpty())) << result.output;
  EXPECT_THAT(result.kinds, Each("order")) << result.output;
  EXPECT_THAT(result.output, HasSubstr("when one stage is run after the other"));
}

TEST_F(ContactFault, AHandThatTouchesTheObjectBeforeItGrasps) {
  const auto result = spoiled({}, [](Json& file) {
    // Too wide for the open hand, but for a notch where it closes.
    object(file, "box")["geometry"] = {
        {"type", "compound"},
        {"parts",
         {{{"X_OS", pose({0, 0, 0})},
           {"geometry", {{"type", "box"}, {"size", {0.04, 0.04, 0.12}}}}},
          {{"X_OS", pose({-0.019, 0.03, -0.03})},
           {"geometry", {{"type", "box"}, {"size", {0.002, 0.03, 0.02}}}}}}}};
  });
  EXPECT_THAT(result.kinds, Contains("contact")) << result.output;
  bool in_approach = false;
  for (const Json& violation : result.json["violations"]) {
    in_approach |= violation["stage"] == 1 && violation["kind"] == "contact";
  }
  EXPECT_TRUE(in_approach) << result.output;
}

TEST_F(ContactFault, AHandThatDoesNotLetGo) {
  const auto result = spoiled(closing(0.0185), [](Json& file) {
    Json& release = stage(file, 1, "release");
    for (std::size_t k = 0; k < release["t"].size(); ++k) {
      release["q"][k][0] = 0.0185;
      release["qd"][k][0] = release["qdd"][k][0] = 0.0;
    }
  });
  EXPECT_THAT(result.kinds, Each("contact")) << result.output;
  ASSERT_FALSE(result.kinds.empty());
  const int retreat = 14;
  EXPECT_EQ(result.json["violations"][0]["stage"], retreat);
}

TEST_F(ContactFault, DepthOfAHand) {
  expectValid(closing(0.0185), [](Json&) {});
  expectOnly("depth", closing(0.0175), [](Json&) {});
}

TEST_F(ContactFault, DepthInTheRest) {
  const auto lowered = [](double by) {
    return [by](Json& file) { addTo(object(file, "shelf")["X_WO"]["xyz"][2], by); };
  };
  expectValid(lowered(8e-4));
  const auto result = spoiled({}, lowered(1.2e-3));
  EXPECT_THAT(result.kinds, Contains("rest")) << result.output;
  EXPECT_THAT(result.kinds, Contains("depth"));
  EXPECT_THAT(result.kinds, Each(AnyOf("rest", "depth")));
}

TEST_F(ContactFault, NothingToRestOn) {
  const auto lower = [](const char* name, double by) {
    return [=](Json& file) { addTo(object(file, name)["X_WO"]["xyz"][2], -by); };
  };
  for (const char* name : {"table", "shelf"}) {
    expectValid(lower(name, 1.8e-3));
    expectOnly("rest", lower(name, 2.2e-3));
  }
}

TEST_F(ContactFault, RestsOnSomethingElseThanItSays) {
  expectOnly("rest", [](Json& file) {
    file["scene"]["start"]["rest"] = {"post"};
    eraseClaims(file, "table");
  });
  expectOnly("rest", [](Json& file) {
    file["scene"]["goal"]["rest"] = Json::array();
    eraseClaims(file, "shelf");
  });
}

TEST_F(ContactFault, RestNoneWaivesTheGap) {
  expectValid([](Json& file) {
    file["scene"]["start"]["rest"] = "none";
    addTo(object(file, "table")["X_WO"]["xyz"][2], -0.01);
    eraseClaims(file, "table");
  });
  // What is near is its rest and may be claimed.
  expectValid([](Json& file) { file["scene"]["start"]["rest"] = "none"; });
  // What is not, may not.
  expectOnly("may_touch", [](Json& file) {
    file["scene"]["start"]["rest"] = "none";
    addTo(object(file, "table")["X_WO"]["xyz"][2], -0.01);
  });
  // Not the depth.
  const auto result = spoiled({}, [](Json& file) {
    file["scene"]["goal"]["rest"] = "none";
    addTo(object(file, "shelf")["X_WO"]["xyz"][2], 3e-3);
  });
  EXPECT_THAT(result.kinds, Contains("rest")) << result.output;
}

TEST_F(ContactFault, RestOfAnObjectInAHand) {
  expectOnly("rest", held(), [](Json& file) { file["scene"]["start"]["rest"] = {"table"}; });
  PlanOptions kept;
  kept.ends_held = true;
  expectOnly("rest", kept, [](Json& file) { file["scene"]["goal"]["rest"] = "none"; });
}

TEST_F(ContactFault, ClaimsOfTooMuch) {
  const auto claim = [](int holder, const char* action, const char* a, const char* b) {
    return [=](Json& file) { stage(file, holder, action)["may_touch"].push_back({a, b}); };
  };
  expectOnly("may_touch", claim(0, "carry", "g/palm", "post"));
  expectOnly("may_touch", claim(0, "carry", "box", "table"));
  expectOnly("may_touch", claim(1, "place", "box", "post"));
  expectOnly("may_touch", claim(1, "carry", "box", "shelf"));
  expectOnly("may_touch", claim(0, "approach", "g/palm", "box"));
  expectOnly("may_touch", claim(1, "approach", "r/palm", "box"));
  expectOnly("may_touch", claim(0, "home", "g/palm", "box"));
  expectOnly("may_touch", claim(0, "carry", "g/z_link", "box"));
  expectValid(claim(0, "carry", "g/palm", "g/left_finger"));  // a standing pair
}

TEST_F(ContactFault, ClaimsOfTooLittleDoNotMatter) {
  expectValid([](Json& file) {
    for (Json& entry : file["plan"]["stages"]) entry["may_touch"] = Json::array();
  });
}

TEST_F(ContactFault, ClaimsAreNotBelieved) {
  const auto result = spoiled({}, [](Json& file) {
    put(file, "gate", {0.02, 0.02, 0.1}, {-0.15, 0, 0.25});
    for (Json& entry : file["plan"]["stages"]) entry["may_touch"].push_back({"box", "gate"});
  });
  EXPECT_THAT(result.kinds, Contains("contact")) << result.output;
}

TEST_F(ContactFault, AGripWithOneFinger) {
  // The box stands to one side: the right finger is 4 mm away.
  expectOnly("grip", [](Json& file) {
    object(file, "box")["geometry"] = {
        {"type", "compound"},
        {"parts",
         {{{"X_OS", pose({0, 0.00175, 0})},
           {"geometry", {{"type", "box"}, {"size", {0.04, 0.0365, 0.12}}}}}}}};
  });
}

TEST_F(ContactFault, AGripWithoutOpposingContacts) {
  // Both fingertips are 1 mm before one face of a plate.
  const auto result = spoiled({}, [](Json& file) {
    object(file, "box")["geometry"] = {
        {"type", "compound"},
        {"parts",
         {{{"X_OS", pose({0.0410, 0, -0.03})},
           {"geometry", {{"type", "box"}, {"size", {0.04, 0.2, 0.04}}}}},
          {{"X_OS", pose({-0.0410, 0, 0.03})},
           {"geometry", {{"type", "box"}, {"size", {0.04, 0.2, 0.02}}}}}}}};
  });
  EXPECT_THAT(result.kinds, Contains("grip")) << result.output;
  EXPECT_THAT(result.output, HasSubstr("contact normals differ by at most 0 deg"));
}

TEST_F(ContactFault, AGripOfAnObjectHeldAtTheStart) {
  const auto result = spoiled(held(), [](Json& file) {
    robot(file, "g")["q_start"]["left"] = robot(file, "g")["q_start"]["right"] = 0.024;
    addProfile(stage(file, 0, "release"), 0, 0.0035, {1, 0, 0, -10, 15, -6});
  });
  EXPECT_THAT(result.kinds, ElementsAre("grip")) << result.output;
  EXPECT_EQ(result.json["violations"][0]["time"], 0);
}

TEST_F(ContactFault, ACupThatDoesNotReachOrLeans) {
  // The box is thinner, so its faces are farther away.
  const auto thinner = [](double by) {
    return [by](Json& file) { object(file, "box")["geometry"]["size"][0] = 0.04 - 2 * by; };
  };
  expectValid(suction(), thinner(1.4e-3));
  expectOnly("grip", suction(), thinner(1.6e-3));
  const auto leaning = [](double degrees) {
    return [degrees](Json& file) {
      const double lean = degrees * M_PI / 180;
      file["plan"]["holders"][0]["hand"]["axis"] = {std::cos(lean), std::sin(lean), 0};
    };
  };
  expectValid(suction(), leaning(4.9));
  expectOnly("grip", suction(), leaning(5.1));
}

}  // namespace
}  // namespace handover::verify::test
