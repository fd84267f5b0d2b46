// SPDX-License-Identifier: Apache-2.0
// Faults of curves, of O's way and of the order of stages.
#include "spoiled_plan.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace handover::verify::test {
namespace {

using testing::Contains;
using testing::HasSubstr;

class MotionFault : public SpoiledPlan {
 protected:
  static PlanOptions joined() {
    PlanOptions options;
    options.joined = true;
    return options;
  }

  static void limit(Json& file, const char* joint, std::size_t entry, double value) {
    robot(file, "g")["limits"][joint][entry] = value;
  }
};

TEST_F(MotionFault, Position) {
  // The giver's tool goes as far as x = 0, that is 0.76 of its first joint.
  expectOnly("position", [](Json& file) { limit(file, "x", 1, 0.759); });
  expectValid([](Json& file) { limit(file, "x", 1, 0.7600005); });
}

TEST_F(MotionFault, PositionThatOnlyTheCurveHas) {
  // The wrist swings out and back, and both samples say 0.
  expectOnly("position", [](Json& file) {
    Json& reach = stage(file, 0, "reach");
    limit(file, "yaw", 0, -1e-4);
    limit(file, "yaw", 1, 1e-4);
    // Between two samples that are h apart, qd and -qd at their ends lead h/4 qd and more away.
    const double h = reach["t"][5].get<double>() - reach["t"][4].get<double>();
    const double qd = 1.2e-3 / h;
    for (const std::size_t k : {4, 5}) {
      reach["q"][k][3] = 0.0;
      reach["qd"][k][3] = (k == 4 ? 1 : -1) * qd;
      reach["qdd"][k][3] = 0.0;
    }
    // Slow enough for everything else.
    const double slower = 6;
    for (Json& t : reach["t"]) t = t.get<double>() * slower;
    for (Json& row : reach["qd"]) {
      for (Json& value : row) value = value.get<double>() / slower;
    }
    for (Json& row : reach["qdd"]) {
      for (Json& value : row) value = value.get<double>() / slower / slower;
    }
    stage(file, 0, "approach")["after"][0][1] = reach["t"].back();
    startEarly(file);
  });
}

/// Of the quintic from rest to rest that the stage is in this joint.
struct Peaks {
  double velocity, acceleration, jerk;
};

Peaks peaksOf(const Json& stage, std::size_t column) {
  const double d =
      std::abs(stage["q"].back()[column].get<double>() - stage["q"][0][column].get<double>());
  const double T = stage["t"].back();
  return {1.875 * d / T, 10 / std::sqrt(3.0) * d / T / T, 60 * d / T / T / T};
}

TEST_F(MotionFault, VelocityAccelerationJerk) {
  Json file = cell_.plan();
  Peaks peaks{};
  for (const Json& entry : file["plan"]["stages"]) {
    if (entry["robot"] != "g" || entry["joints"].size() == 1) continue;
    const Peaks own = peaksOf(entry, 2);
    peaks.velocity = std::max(peaks.velocity, own.velocity);
    peaks.acceleration = std::max(peaks.acceleration, own.acceleration);
    peaks.jerk = std::max(peaks.jerk, own.jerk);
  }
  const auto with = [](std::size_t entry, double value) {
    return [=](Json& plan) { limit(plan, "z", entry, value); };
  };
  expectValid(with(2, peaks.velocity / 1.0009));
  expectOnly("velocity", with(2, peaks.velocity / 1.0012));
  expectValid(with(3, peaks.acceleration / 1.0009));
  expectOnly("acceleration", with(3, peaks.acceleration / 1.0012));
  expectValid(with(4, peaks.jerk / 1.0095));
  expectOnly("jerk", with(4, peaks.jerk / 1.0105));
}

TEST_F(MotionFault, JointThatStartsWhereItDidNotStop) {
  expectOnly("join", [](Json& file) { addTo(stage(file, 0, "carry")["q"][0][2], 1e-7); });
  expectValid([](Json& file) { addTo(stage(file, 0, "carry")["q"][0][2], 5e-10); });
  expectOnly("join", [](Json& file) { addTo(stage(file, 0, "reach")["q"][0][1], 1e-7); });
}

TEST_F(MotionFault, StagesThatDoNotGoOnAsTheOneBeforeEnded) {
  expectOnly("join", joined(), [](Json& file) { addTo(stage(file, 0, "carry")["q"][0][1], 2e-6); });
  expectOnly("join", joined(),
             [](Json& file) { addTo(stage(file, 0, "carry")["qd"][0][2], 2e-6); });
  expectOnly("join", joined(),
             [](Json& file) { addTo(stage(file, 0, "carry")["qdd"][0][2], 2e-6); });
  expectValid(joined(), [](Json& file) { addTo(stage(file, 0, "carry")["qd"][0][2], 5e-7); });
  expectOnly("stop", joined(), [](Json& file) { addTo(stage(file, 1, "home")["start"], 0.01); });
}

TEST_F(MotionFault, NoRestAtTheEnds) {
  expectOnly("stop", [](Json& file) { stage(file, 0, "reach")["qd"][0][0] = 1e-6; });
  expectOnly("stop", [](Json& file) { stage(file, 0, "reach")["qdd"][0][0] = 1e-6; });
  expectOnly("stop", [](Json& file) { stage(file, 1, "home")["qd"].back()[2] = -1e-6; });
  expectOnly("stop", [](Json& file) { stage(file, 1, "release")["qdd"].back()[0] = -1e-6; });
}

TEST_F(MotionFault, ARetreatThatEndsElsewhere) {
  expectOnly("home", [](Json& file) { addProfile(stage(file, 1, "home"), 1, 0.001, step()); });
}

TEST_F(MotionFault, Holding) {
  expectOnly("holding", [](Json& file) { stage(file, 1, "approach")["holding"].erase(0); });
  expectOnly("holding", [](Json& file) { stage(file, 0, "lift")["holding"].erase(1); });
  expectOnly("holding", [](Json& file) {
    stage(file, 0, "grasp")["holding"].push_back(stage(file, 0, "lift")["holding"][0]);
  });
  expectOnly("holding", [](Json& file) {
    stage(file, 0, "lift")["holding"].push_back(stage(file, 0, "lift")["holding"][0]);
  });
  // As a release begins the hand still holds, as it has ended no more.
  expectOnly("holding", [](Json& file) {
    stage(file, 0, "retreat")["holding"].push_back(stage(file, 0, "lift")["holding"][0]);
  });
  expectOnly("holding",
             [](Json& file) { stage(file, 0, "carry")["holding"][0]["X_LO"]["xyz"][0] = 1e-5; });
  expectOnly("holding", [](Json& file) {
    for (Json& entry : file["plan"]["stages"]) {
      for (Json& hold : entry["holding"]) {
        if (hold["robot"] == "g") addTo(hold["X_LO"]["xyz"][1], 2e-4);
      }
    }
  });
  expectOnly("holding",
             [](Json& file) { stage(file, 0, "carry")["holding"][0]["link"] = "left_finger"; });
  expectOnly("holding", [](Json& file) {
    addTo(stage(file, 0, "carry")["holding"][1]["X_LO"]["xyz"][1], 1e-5);
  });
}

TEST_F(MotionFault, TheObjectJumpsIntoTheHand) {
  expectOnly("state", [](Json& file) {
    file["scene"]["start"]["X_WO"]["xyz"][1] = 0.0002;
    object(file, "box")["X_WO"]["xyz"][1] = 0.0002;
  });
}

TEST_F(MotionFault, TheObjectIsNotAtTheHandover) {
  expectOnly("state", [](Json& file) { file["plan"]["handovers"][0]["xyz"][2] = 0.4002; });
}

TEST_F(MotionFault, TheObjectJumpsFromHandToHand) {
  // The receiver's grasp is another than its hand has.
  const auto result =
      spoiled({}, [](Json& file) { addTo(file["plan"]["holders"][1]["X_OT"]["xyz"][0], 5e-4); });
  EXPECT_THAT(result.kinds, Contains("state")) << result.output;
  EXPECT_THAT(result.output, HasSubstr("the hand that takes has the object away"));
}

TEST_F(MotionFault, TheObjectEndsElsewhere) {
  const auto goal = [](double y) {
    return [y](Json& file) { file["scene"]["goal"]["X_WO"]["xyz"][1] = y; };
  };
  const auto turned = [](double degrees) {
    return [degrees](Json& file) {
      const double half = degrees / 2 * M_PI / 180;
      file["scene"]["goal"]["X_WO"]["quat_wxyz"] = {std::cos(half), 0, 0, std::sin(half)};
    };
  };
  expectOnly("state", goal(0.0011));
  expectValid(goal(0.0009));
  expectOnly("state", turned(0.6));
  expectValid(turned(0.4));
}

TEST_F(MotionFault, TheObjectMovesWhileItIsHandedOver) {
  const auto result = spoiled({}, [](Json& file) {
    // The carry ends a little after the other hand begins to close.
    Json& carry = stage(file, 0, "carry");
    Json& grasp = stage(file, 1, "grasp");
    carry["start"] = grasp["start"].get<double>() - carry["t"].back().get<double>() + 0.3;
  });
  EXPECT_THAT(result.kinds, Contains("state")) << result.output;
  EXPECT_THAT(result.kinds, Contains("order"));
}

TEST_F(MotionFault, WhatTheObjectRestsOnGoesAway) {
  expectOnly("state", [](Json& file) { file["scene"]["start"]["rest"] = {"table", "sign"}; });
}

TEST_F(MotionFault, WaysThatAreNotStraight) {
  for (const char* action : {"approach", "retreat"}) {
    expectOnly("straight",
               [&](Json& file) { addProfile(stage(file, 0, action), 1, 0.0012, bump()); });
    expectValid([&](Json& file) { addProfile(stage(file, 0, action), 1, 0.0008, bump()); });
    expectOnly("straight", [&](Json& file) {
      addProfile(stage(file, 0, action), 3, 0.6 * M_PI / 180, bump());
    });
    expectValid(
        [&](Json& file) { addProfile(stage(file, 0, action), 3, 0.4 * M_PI / 180, bump()); });
  }
  expectOnly("straight",
             [](Json& file) { addProfile(stage(file, 1, "place"), 1, 0.0012, bump()); });
  expectOnly("straight", [](Json& file) { addProfile(stage(file, 0, "lift"), 1, 0.0012, bump()); });
}

TEST_F(MotionFault, ALiftThatIsNotStraightUp) {
  const auto leaning = [](double degrees) {
    return [degrees](Json& file) {
      moveKnot(stage(file, 0, "lift"), stage(file, 0, "carry"), 1,
               0.05 * std::tan(degrees * M_PI / 180));
    };
  };
  expectOnly("straight", leaning(1.1));
  expectValid(leaning(0.9));
}

TEST_F(MotionFault, ARetreatThatIsTooShort) {
  const auto back = [](double by) {
    PlanOptions options;
    options.last_retreat = by;
    return options;
  };
  expectOnly("straight", back(0.0049), [](Json&) {});
  expectValid(back(0.0051), [](Json&) {});
}

TEST_F(MotionFault, Upright) {
  PlanOptions options;
  options.upright = true;
  const auto leaning = [](double by) {
    return [by](Json& file) {
      file["scene"]["upright"]["within_deg"] = 1;
      addProfile(stage(file, 1, "carry"), 4, by * M_PI / 180, bump());
    };
  };
  expectOnly("upright", options, leaning(1.05));
  expectValid(options, leaning(0.95));
}

TEST_F(MotionFault, UprightIsBeyondTheLargerOfStartAndGoal) {
  PlanOptions options;
  options.upright = true;
  const auto about = [](double lean, double allowed) {
    return [=](Json& file) {
      // An axis that leans at start and goal alike.
      file["scene"]["upright"]["axis"] = {std::sin(lean), 0, std::cos(lean)};
      file["scene"]["upright"]["within_deg"] = allowed;
      addProfile(stage(file, 0, "carry"), 4, 1.5 * M_PI / 180, bump());
    };
  };
  expectValid(options, about(0.5, 2));
  expectOnly("upright", options, about(0.5, 1));
}

TEST_F(MotionFault, Dexterity) {
  for (const std::size_t holder : {0, 1}) {
    for (const char* name : {"take", "give"}) {
      const auto claimed = [&](double value) {
        return [=](Json& file) { file["plan"]["holders"][holder]["dexterity"][name] = value; };
      };
      expectOnly("dexterity", claimed(1.011));
      expectOnly("dexterity", claimed(0.988));
      expectValid(claimed(1.009));
    }
  }
}

// ---- order ------------------------------------------------------------------------------------

/// Removes the edges of the stage that wait for another one of that action.
void forget(Json& file, Json& stage, int holder, const char* action) {
  const int index = handover::verify::test::stage(file, holder, action)["index"];
  Json kept = Json::array();
  for (const Json& edge : stage["after"]) {
    if (edge[0] != index) kept.push_back(edge);
  }
  stage["after"] = kept;
}

TEST_F(MotionFault, EdgesThatOrderRequires) {
  expectOnly("order", [](Json& file) { forget(file, stage(file, 0, "release"), 1, "grasp"); });
  expectOnly("order", [](Json& file) { forget(file, stage(file, 1, "carry"), 0, "retreat"); });
  expectOnly("order", [](Json& file) {
    forget(file, stage(file, 1, "carry"), 0, "retreat");
    forget(file, stage(file, 1, "carry"), 0, "release");
  });
  expectOnly("order", [](Json& file) {
    forget(file, stage(file, 1, "grasp"), 0, "carry");
    forget(file, stage(file, 1, "approach"), 0, "carry");
  });
  expectOnly("order", [](Json& file) { forget(file, stage(file, 0, "home"), 0, "retreat"); });
  expectOnly("order", [](Json& file) { forget(file, stage(file, 1, "grasp"), 1, "approach"); });
}

TEST_F(MotionFault, EdgesThatOthersImplyNeedNotBeListed) {
  // The approach waits for the carry, and the grasp for the approach.
  expectValid([](Json& file) { forget(file, stage(file, 1, "grasp"), 0, "carry"); });
  // The retreat comes after the release.
  expectValid([](Json& file) { forget(file, stage(file, 1, "carry"), 0, "release"); });
}

TEST_F(MotionFault, TheNextCarryWaitsForTheFirst5mm) {
  const auto waits = [](double longer) {
    return [longer](Json& file) {
      Json& carry = stage(file, 1, "carry");
      addTo(carry["after"].back()[1], longer);
      startEarly(file);
    };
  };
  expectOnly("order", waits(-0.0015));
  expectValid(waits(-0.0005));
  expectValid(waits(0.05));
}

TEST_F(MotionFault, StartsBeforeTheEdgesAllow) {
  expectOnly("order", [](Json& file) { addTo(stage(file, 1, "grasp")["start"], -1e-6); });
}

TEST_F(MotionFault, EdgesThatCannotBe) {
  expectOnly("order", [](Json& file) {
    Json& edge = stage(file, 1, "carry")["after"][0];
    edge[1] = edge[1].get<double>() + 0.01;
  });
  expectOnly("order", [](Json& file) { stage(file, 1, "carry")["after"][0][1] = -0.01; });
  expectOnly("order", [](Json& file) {
    stage(file, 0, "carry")["after"].push_back({stage(file, 1, "grasp")["index"], 0.1});
  });
}

TEST_F(MotionFault, AStageThatGoesOnCannotWait) {
  expectOnly("order", joined(), [](Json& file) {
    stage(file, 0, "carry")["after"].push_back({stage(file, 1, "reach")["index"], 0.0});
  });
}

TEST_F(MotionFault, JoinedStagesNeedNoEdgeBetweenThem) {
  expectValid(joined(), [](Json& file) { forget(file, stage(file, 0, "carry"), 0, "lift"); });
}

}  // namespace
}  // namespace handover::verify::test
