// SPDX-License-Identifier: Apache-2.0
#include "draw.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

namespace handover::ctl {
namespace {

using client::Json;
using testing::ElementsAre;

const std::vector<Variation> kVariations{
    {"r.base.rpy_deg", {0, 0, -15}, {0, 0, 15}, {{0.0, 0.0}}, {}},
    {"r.base.xyz", {1.18, -1.1, 0.98}, {1.18, 0.5, 0.98}, {}, {}},
    {"o.height", {0.02}, {0.08}, {}, {}},
    {"r.posture", {}, {}, {}, {"home", "[1, 2.5]", "3"}}};

/// What the drawn yaw adds to the direction to the origin [deg].
double turnOf(const Json& drawn) {
  const Json& place = drawn["r.base.xyz"];
  const double direction = std::atan2(-place[1].get<double>(), -place[0].get<double>());
  const double turn = drawn["r.base.rpy_deg"][2].get<double>() - direction * 180 / std::numbers::pi;
  return std::remainder(turn, 360.0);
}

TEST(Draw, StaysInTheRangesAndReachesAllOfThem) {
  double lowest = 1e9, highest = -1e9, least_turn = 1e9, most_turn = -1e9;
  std::set<std::string> chosen;
  for (std::uint64_t run = 0; run < 2000; ++run) {
    const Json drawn = draw(kVariations, {1, run, 0}, 1.0);
    const auto place = drawn["r.base.xyz"].get<std::vector<double>>();
    ASSERT_THAT(place,
                ElementsAre(1.18, testing::AllOf(testing::Ge(-1.1), testing::Le(0.5)), 0.98));
    lowest = std::min(lowest, place[1]);
    highest = std::max(highest, place[1]);
    ASSERT_LE(std::abs(turnOf(drawn)), 15 + 1e-9);
    least_turn = std::min(least_turn, turnOf(drawn));
    most_turn = std::max(most_turn, turnOf(drawn));
    const double height = drawn["o.height"].get<double>();
    ASSERT_TRUE(height >= 0.02 && height <= 0.08) << height;
    chosen.insert(drawn["r.posture"].dump());
  }
  EXPECT_LT(lowest, -1.09);
  EXPECT_GT(highest, 0.49);
  EXPECT_LT(least_turn, -14.8);
  EXPECT_GT(most_turn, 14.8);
  EXPECT_THAT(chosen, ElementsAre("\"home\"", "3", "[1,2.5]"));
}

TEST(Draw, IsTheSameForTheSameRunAndAnotherForAnother) {
  const Json drawn = draw(kVariations, {7, 12, 0}, 1.0);
  EXPECT_EQ(draw(kVariations, {7, 12, 0}, 1.0), drawn);
  EXPECT_NE(draw(kVariations, {7, 13, 0}, 1.0), drawn);
  EXPECT_NE(draw(kVariations, {8, 12, 0}, 1.0), drawn);
  EXPECT_NE(draw(kVariations, {7, 12, 1}, 1.0), drawn);
}

TEST(Draw, StretchScalesRangesAboutTheirMiddles) {
  const Json middle = draw(kVariations, {1, 0, 0}, 0.0);
  EXPECT_NEAR(middle["r.base.xyz"][1].get<double>(), -0.3, 1e-12);
  EXPECT_NEAR(turnOf(middle), 0, 1e-9);
  for (std::uint64_t run = 0; run < 50; ++run) {
    const double once = draw(kVariations, {1, run, 0}, 1.0)["o.height"].get<double>() - 0.05;
    const double twice = draw(kVariations, {1, run, 0}, 2.0)["o.height"].get<double>() - 0.05;
    EXPECT_NEAR(twice, 2 * once, 1e-12);
  }
}

TEST(Draw, SaysOverridesAsTheyAreTyped) {
  Json drawn = Json::object();
  drawn["a.xyz"] = {1.0, -0.1, 1.0 / 3.0};
  drawn["a.posture"] = "home";
  drawn["a.radius"] = 0.03;
  EXPECT_THAT(overridesOf(drawn),
              ElementsAre(Override{"a.xyz", "[1.0, -0.1, 0.3333333333333333]"},
                          Override{"a.posture", "home"}, Override{"a.radius", "0.03"}));
}

}  // namespace
}  // namespace handover::ctl
