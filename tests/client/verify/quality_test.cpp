// SPDX-License-Identifier: Apache-2.0
// The file's quality against the verifier's own figures.
#include "spoiled_plan.hpp"

#include <cmath>
#include <string>
#include <vector>

namespace handover::verify::test {
namespace {

using testing::HasSubstr;

class Quality : public SpoiledPlan {
 protected:
  /// The plan with the claims that its figures allow.
  Json claimed(const PlanOptions& options) const {
    Json file = cell_.plan(options);
    const ProgramResult result = verify(cell_, file);
    file["quality"] = result.json.at("quality");
    file["quality"]["grip"] = {{{"holder", 0}, {"quality", 0.3}, {"of_best", 0.9}}};
    file["quality"]["cost"] = 30.0;
    file["quality"]["terms"] = {{"duration", 30.0}};
    return file;
  }

  static PlanOptions turning() {
    PlanOptions options;
    options.joined = true;
    return options;
  }
};

TEST_F(Quality, PassesItsOwnFigures) {
  for (const int holders : {1, 2, 3}) {
    for (const bool held : {false, true}) {
      PlanOptions options;
      options.holders = holders;
      options.ends_held = options.held_at_start = held;
      const ProgramResult result = verify(cell_, claimed(options));
      EXPECT_EQ(result.exit_code, 0) << holders << result.output;
    }
  }
}

/// From rest to rest over d, in z, x: 0.5 m/s and 1 m/s^2.
double alone(double d) { return d <= 0.25 ? 2 * std::sqrt(d) : d / 0.5 + 0.5; }

double finger() { return 0.0195 / 0.1 + 0.1; }

TEST_F(Quality, FiguresOfOneHolderAreTheFormulas) {
  PlanOptions options;
  options.holders = 1;
  Json file = claimed(options);
  const Json& quality = file["quality"];
  double end = 0;
  for (const Json& entry : file["plan"]["stages"]) {
    end = std::max(end, entry["start"].get<double>() + entry["t"].back().get<double>());
  }
  EXPECT_NEAR(quality["duration_s"], end, 1e-9);
  // reach and approach: 0.30 in x, 0.17 in z; lift, carry, place: 0.05 up, then 0.01 up to 60 mm
  // above, 0.06 down, 0.1 in x; retreat and home: 0.15 back, 0.25 on to the start in x.
  const double bound = alone(0.30) + finger() + alone(0.12) + finger() + alone(0.40);
  EXPECT_NEAR(quality["bound_s"], bound, 1e-9);
  const Json& release = stage(file, 0, "release");
  const Json& grasp = stage(file, 0, "grasp");
  EXPECT_NEAR(quality["object_s"],
              release["start"].get<double>() - grasp["start"].get<double>() -
                  grasp["t"].back().get<double>(),
              1e-9);
  EXPECT_NEAR(quality["idle_s"]["g"], 0, 1e-9);
  EXPECT_NEAR(quality["tilt_deg"], 0, 1e-6);
  EXPECT_NEAR(quality["object_turn_deg"][0], 0, 1e-6);
  // x at the pick: 0.46 of [-0.5, 1.5]; z at the placing: 0.03; the wrist in its middle.
  EXPECT_NEAR(quality["limit_margin"], (0.03 + 0.5) / 2, 0.25);
  // Every leg takes 1.01 times what its jerk allows.
  EXPECT_NEAR(quality["jerk_share"], 1 / (1.01 * 1.01 * 1.01), 1e-4);
}

TEST_F(Quality, IdleIsWhatTheHolderWaits) {
  Json file = claimed({});
  // The giver has the box and waits from the end of its carry to the start of its release.
  const Json& carry = stage(file, 0, "carry");
  const double carried = carry["start"].get<double>() + carry["t"].back().get<double>();
  const double waits = stage(file, 0, "release")["start"].get<double>() - carried;
  EXPECT_GT(waits, 0.5);
  EXPECT_NEAR(file["quality"]["idle_s"]["g"], waits, 1e-9);
}

TEST_F(Quality, ClearanceIsTheLeastDistance) {
  Json file = cell_.plan();
  // 30 mm beside the giver's fingers (open: 50 mm from the middle) on their way back home.
  file["scene"]["objects"].push_back(boxObject("wall", {0.02, 0.02, 0.04}, {-0.35, 0.09, 0.3}));
  const ProgramResult result = verify(cell_, file);
  EXPECT_EQ(result.exit_code, 0) << result.output;
  bool found = false;
  for (const Json& entry : result.json["quality"]["clearance"]) {
    if (entry["between"] != "furniture") continue;
    found = true;
    EXPECT_NEAR(entry["least_m"], 0.02, 3e-4) << result.output;
    EXPECT_EQ(entry["pair"].size(), 2u);
  }
  EXPECT_TRUE(found);
}

TEST_F(Quality, EveryWrongClaimIsFound) {
  const Json right = claimed({});
  const auto wrong = [&](const std::string& name, const std::function<void(Json&)>& fault) {
    Json file = right;
    fault(file["quality"]);
    const ProgramResult result = verify(cell_, file);
    EXPECT_THAT(result.kinds, testing::ElementsAre("quality")) << name << result.output;
    EXPECT_THAT(result.output, HasSubstr(name));
  };
  const auto fine = [&](const std::function<void(Json&)>& fault) {
    Json file = right;
    fault(file["quality"]);
    EXPECT_EQ(verify(cell_, file).exit_code, 0);
  };
  for (const char* name : {"duration_s", "object_s"}) {
    wrong(name, [&](Json& quality) { addTo(quality[name], 2e-6); });
    fine([&](Json& quality) { addTo(quality[name], 5e-7); });
  }
  wrong("bound_s", [](Json& quality) { addTo(quality["bound_s"], 2e-3); });
  wrong("idle_s", [](Json& quality) { addTo(quality["idle_s"]["g"], -2e-6); });
  wrong("idle_s", [](Json& quality) { quality["idle_s"].erase("r"); });
  wrong("tilt_deg", [](Json& quality) { addTo(quality["tilt_deg"], 0.11); });
  fine([](Json& quality) { addTo(quality["tilt_deg"], 0.09); });
  for (const std::size_t entry : {0, 1}) {
    wrong("object_turn_deg",
          [&](Json& quality) { addTo(quality["object_turn_deg"][entry], 0.11); });
  }
  wrong("limit_margin", [](Json& quality) {
    quality["limit_margin"] = quality["limit_margin"].get<double>() * 1.012;
  });
  fine([](Json& quality) {
    quality["limit_margin"] = quality["limit_margin"].get<double>() * 1.009;
  });
  wrong("limit_margin", [](Json& quality) { quality["limit_margin"] = nullptr; });
  wrong("jerk_share",
        [](Json& quality) { quality["jerk_share"] = quality["jerk_share"].get<double>() * 0.988; });
  for (std::size_t entry = 0; entry < right["quality"]["clearance"].size(); ++entry) {
    const std::string name = right["quality"]["clearance"][entry]["between"];
    wrong("clearance to " + name,
          [&](Json& quality) { addTo(quality["clearance"][entry]["least_m"], 8e-4); });
    wrong("clearance to " + name,
          [&](Json& quality) { quality["clearance"][entry]["least_m"] = -3e-3; });
    fine([&](Json& quality) { addTo(quality["clearance"][entry]["least_m"], 2e-4); });
    wrong("clearance says nothing of " + name,
          [&](Json& quality) { quality["clearance"].erase(entry); });
  }
}

TEST_F(Quality, TurningOfTheObjectIsSummedUp) {
  Json file = cell_.plan();
  // Out by 1 degree and back.
  addProfile(stage(file, 1, "carry"), 5, 1 * M_PI / 180, bump());
  const ProgramResult result = verify(cell_, file);
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NEAR(result.json["quality"]["object_turn_deg"][0], 2, 0.01);
  EXPECT_NEAR(result.json["quality"]["object_turn_deg"][1], 0, 1e-6);
  EXPECT_NEAR(result.json["quality"]["tilt_deg"], 1, 0.02);
}

TEST_F(Quality, IsMeasuredForJoinedStages) {
  const Json file = claimed(turning());
  EXPECT_EQ(verify(cell_, file).exit_code, 0);
  EXPECT_LT(file["quality"]["bound_s"].get<double>(), file["quality"]["duration_s"].get<double>());
}

}  // namespace
}  // namespace handover::verify::test
