// SPDX-License-Identifier: Apache-2.0
#include "cells/nearest_fix.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>

namespace handover {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

const ReachBall kFixedArm{{0.0, 0.3, 1.2}, 0.9};
constexpr std::size_t kAll = 1'000'000;
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
  const auto moves = movesByCost(kBase, {kMovedArm}, {kFixedArm}, kAll, Deadline());
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
  const auto one = movesByCost(kBase, {kMovedArm}, {kFixedArm}, kAll, Deadline());
  EXPECT_EQ(movesByCost(kBase, {kMovedArm, kMovedArm}, {kFixedArm, kFixedArm}, kAll, Deadline()),
            one);
  EXPECT_THAT(movesByCost(kBase, {}, {kFixedArm}, kAll, Deadline()), IsEmpty());
}

TEST(MovesByCost, OfAFewAreTheCheapest) {
  const auto all = movesByCost(kBase, {kMovedArm}, {kFixedArm}, kAll, Deadline());
  const auto few = movesByCost(kBase, {kMovedArm}, {kFixedArm}, 50, Deadline());
  EXPECT_EQ(few, std::vector<BaseMove>(all.begin(), all.begin() + 50));
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

/// A search for a fix over moves in a row, and what it asked.
class NearestFixTest : public testing::Test {
 protected:
  NearestFix search(std::size_t moves) {
    std::vector<BaseMove> row;
    for (std::size_t i = 0; i < moves; ++i) row.push_back({static_cast<int>(i) + 1, 0, 0});
    const FixQuestions questions{[&](const Override& change) {
                                   ++looks;
                                   return promise(placeOf(change));
                                 },
                                 [&](const Override& change, std::uint64_t& work) {
                                   work += 10;
                                   planned.push_back(placeOf(change));
                                   return plans(planned.back());
                                 },
                                 [&] { return stop(); }};
    return findNearestFix(robotAt(Pose::Identity()), row, questions, most_work);
  }

  /// The number of the move in the row, from 1.
  static int placeOf(const Override& change) {
    double x = 0;
    std::sscanf(change.value.c_str(), "{xyz: [%lf", &x);
    return static_cast<int>(std::lround(x / 0.05));
  }

  std::function<std::size_t(int)> promise = [](int) { return 1; };
  std::function<bool(int)> plans = [](int) { return false; };
  std::function<std::string()> stop = [] { return ""; };
  std::uint64_t most_work = 1'000;
  std::uint32_t looks = 0;
  std::vector<int> planned;
};

TEST_F(NearestFixTest, EndsAfterTheWorkThatItMayTake) {
  most_work = 25;
  EXPECT_THAT(search(20).overrides, IsEmpty());
  EXPECT_EQ(planned.size(), 3u);  // of 10 each: none is begun beyond 25
}

TEST_F(NearestFixTest, IsTheCheapestMoveThatTheMapsPromiseAndThatPlans) {
  promise = [](int move) { return move > 4 ? 7 : 0; };
  plans = [](int move) { return move >= 5; };
  const NearestFix fix = search(20);
  ASSERT_EQ(fix.overrides.size(), 1u);
  EXPECT_EQ(placeOf(fix.overrides[0]), 5);
  EXPECT_EQ(planned, std::vector<int>{5});
  EXPECT_EQ(looks, 5u);
  EXPECT_THAT(fix.text, HasSubstr("moved by (0.25, 0.00) m"));
}

TEST_F(NearestFixTest, AfterAFailureThoseThatPromiseMoreComeFirst) {
  promise = [](int move) { return move == 6 ? 9 : 3; };
  plans = [](int move) { return move == 6; };
  EXPECT_EQ(placeOf(search(20).overrides.at(0)), 6);
  EXPECT_EQ(planned, (std::vector<int>{1, 6}));
}

TEST_F(NearestFixTest, MovesThatPromiseNoMoreThanAFailedOneArePassedOver) {
  promise = [](int move) { return move == 1 ? 5 : move == 3 ? 3 : move == 2 ? 5 : 9; };
  plans = [](int move) { return move == 4; };
  EXPECT_EQ(placeOf(search(20).overrides.at(0)), 4);
  EXPECT_EQ(planned, (std::vector<int>{1, 4}));  // 2 and 3 promise no more than 1, which failed
}

TEST_F(NearestFixTest, ThoseThatPromiseNoMoreAreTriedInTheEnd) {
  plans = [](int move) { return move == 3; };
  EXPECT_EQ(placeOf(search(20).overrides.at(0)), 3);
  EXPECT_EQ(planned, (std::vector<int>{1, 2, 3}));
  EXPECT_EQ(looks, 20u);
}

TEST_F(NearestFixTest, GivesUpAfterItsShareOfPlansAndSaysSo) {
  const NearestFix fix = search(300);
  EXPECT_THAT(fix.overrides, IsEmpty());
  EXPECT_EQ(planned.size(), kMostFixPlans);
  EXPECT_THAT(fix.text, HasSubstr("No move of hubo that was tried"));
  EXPECT_THAT(fix.text, HasSubstr("of 300 nearer moves that were looked at in the maps, 20 were"));
}

TEST_F(NearestFixTest, LooksAtTheMapsNoMoreThanItsShare) {
  promise = [](int) { return 0; };
  search(kMostMapLooks + 100);
  EXPECT_EQ(looks, kMostMapLooks);
}

TEST_F(NearestFixTest, IsNotSoughtWhereOthersWait) {
  stop = [] { return "others waited"; };
  const NearestFix fix = search(5);
  EXPECT_THAT(fix.overrides, IsEmpty());
  EXPECT_EQ(looks, 0u);
  EXPECT_EQ(fix.text, "Not sought: others waited.");
}

TEST_F(NearestFixTest, EndsInTheMiddleWhenItHasTo) {
  stop = [&] { return planned.size() == 1 ? "the deadline passed" : ""; };
  promise = [](int move) { return move; };
  const NearestFix fix = search(50);
  EXPECT_EQ(planned.size(), 1u);
  EXPECT_THAT(fix.text, HasSubstr("; then the deadline passed."));
}

}  // namespace
}  // namespace handover
