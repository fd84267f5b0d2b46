// SPDX-License-Identifier: Apache-2.0
#include "cells/nearest_fix.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace handover {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

const ReachBall kFixedArm{{0.0, 0.3, 1.2}, 0.9};
const Eigen::Vector3d kBase(2.2, -0.4, 0.9);
const ReachBall kMovedArm{{2.1, -0.2, 1.1}, 0.7};

/// The balls meet after the move.
bool meet(const BaseMove& move) {
  const Eigen::AngleAxisd turn(move.turn * M_PI / 18, Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d p =
      kBase + turn * (kMovedArm.p_WShoulder - kBase) + 0.05 * Eigen::Vector3d(move.i, move.j, 0);
  return (p - kFixedArm.p_WShoulder).norm() <= kMovedArm.radius + kFixedArm.radius;
}

SceneRobot robotAt(const Pose& X_WB) {
  SceneRobot robot;
  robot.name = "hubo";
  robot.X_WB = X_WB;
  return robot;
}

TEST(MovesByCost, AreAllThatBringTheBallsTogetherCheapestFirst) {
  const auto moves = movesByCost(kBase, {kMovedArm}, {kFixedArm});
  std::size_t expected = 0;
  for (int turn = -17; turn <= 18; ++turn) {
    for (int i = -100; i <= 100; ++i) {
      for (int j = -100; j <= 100; ++j) {
        const BaseMove move{i, j, turn};
        if (move != BaseMove{} && meet(move)) ++expected;
      }
    }
  }
  EXPECT_EQ(moves.size(), expected);
  for (std::size_t m = 0; m < moves.size(); ++m) {
    ASSERT_TRUE(meet(moves[m]));
    if (m > 0) {
      ASSERT_LE(moves[m - 1].cost(), moves[m].cost());
    }
  }
}

TEST(MovesByCost, OfTwoArmsAreMadeOnce) {
  const auto one = movesByCost(kBase, {kMovedArm}, {kFixedArm});
  EXPECT_EQ(movesByCost(kBase, {kMovedArm, kMovedArm}, {kFixedArm, kFixedArm}), one);
  EXPECT_THAT(movesByCost(kBase, {}, {kFixedArm}), IsEmpty());
}

TEST(BaseMove, CostsItsWayAndHalfAMetrePerRadian) {
  EXPECT_DOUBLE_EQ((BaseMove{3, -4, 0}.cost()), 0.25);
  EXPECT_DOUBLE_EQ((BaseMove{0, 0, -9}.cost()), 0.25 * M_PI);
}

TEST(OverrideOf, IsTheMovedBaseInTheWorld) {
  const Pose X_WB = Eigen::Translation3d(1.18, -0.3, 0.98) *
                    Eigen::AngleAxisd(165.7354877 * M_PI / 180, Eigen::Vector3d::UnitZ());
  const Override change = overrideOf({-2, 1, 3}, robotAt(X_WB));
  EXPECT_EQ(change.path, "robots.hubo.base");
  EXPECT_EQ(change.value, "{xyz: [1.08, -0.25, 0.98], rpy_deg: [0, 0, -164.265]}");
}

/// What a search for a fix asked.
struct Asked {
  int maps = 0, plans = 0;
};

NearestFix search(const std::vector<BaseMove>& moves,
                  const std::function<bool(const Override&)>& maps_allow,
                  const std::function<bool(const Override&)>& plans, Asked& asked,
                  const Deadline& deadline = Deadline()) {
  return findNearestFix(
      robotAt(Pose(Eigen::Translation3d(kBase))), moves,
      [&](const Override& change) {
        ++asked.maps;
        return maps_allow(change);
      },
      [&](const Override& change) {
        ++asked.plans;
        return plans(change);
      },
      deadline);
}

TEST(NearestFix, IsTheCheapestMoveThatPlans) {
  const auto moves = movesByCost(kBase, {kMovedArm}, {kFixedArm});
  const std::string wanted =
      overrideOf(moves[30], robotAt(Pose(Eigen::Translation3d(kBase)))).value;
  const std::string ruled_out =
      overrideOf(moves[4], robotAt(Pose(Eigen::Translation3d(kBase)))).value;
  Asked asked;
  const NearestFix fix = search(
      moves, [&](const Override& change) { return change.value != ruled_out; },
      [&](const Override& change) { return change.value == wanted; }, asked);
  ASSERT_EQ(fix.overrides.size(), 1u);
  EXPECT_EQ(fix.overrides[0].value, wanted);
  EXPECT_EQ(asked.maps, 31);
  EXPECT_EQ(asked.plans, 30);
  EXPECT_THAT(fix.text, HasSubstr("1 nearer place(s) were ruled out by the maps, 29 planned"));
}

TEST(NearestFix, GivesUpAfterTwoHundredPlansAndSaysSo) {
  const auto moves = movesByCost(kBase, {kMovedArm}, {kFixedArm});
  ASSERT_GT(moves.size(), 300u);
  Asked asked;
  const NearestFix fix = search(
      moves, [](const Override&) { return true; }, [](const Override&) { return false; }, asked);
  EXPECT_THAT(fix.overrides, IsEmpty());
  EXPECT_EQ(asked.plans, 200);
  EXPECT_THAT(fix.text, HasSubstr("No move of hubo that was tried"));
}

TEST(NearestFix, StopsAtTheDeadline) {
  Deadline deadline;
  deadline.cancel();
  Asked asked;
  const NearestFix fix = search(
      {{1, 0, 0}}, [](const Override&) { return true; }, [](const Override&) { return true; },
      asked, deadline);
  EXPECT_THAT(fix.overrides, IsEmpty());
  EXPECT_EQ(asked.maps, 0);
  EXPECT_THAT(fix.text, HasSubstr("deadline"));
}

}  // namespace
}  // namespace handover
