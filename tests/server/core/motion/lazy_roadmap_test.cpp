// SPDX-License-Identifier: Apache-2.0
#include "core/motion/lazy_roadmap.hpp"

#include "problems.hpp"

#include <gtest/gtest.h>

namespace handover {
namespace {

using test::emptyProblem;
using test::joints;
using test::pathValid;
using test::wallProblem;

double length(const ArmVector& a, const ArmVector& b) { return (b - a).norm(); }

TEST(CheapestWay, IsTheStraightSegmentWhereThatIsFree) {
  const ArmVector from = joints({-2, 0}), to = joints({2, 1});
  const auto way =
      lazyShortestPath(emptyProblem(2), from, to, {joints({0, 0.5})}, length, {.most = 10}, {});
  ASSERT_TRUE(way);
  EXPECT_EQ(way->waypoints, (std::vector<ArmVector>{from, to}));
}

TEST(CheapestWay, IsTheCheapestOfThoseThatAreFree) {
  const MotionProblem problem = wallProblem(2, 0.1);  // a hole at 0.5
  const ArmVector from = joints({-2, 0}), to = joints({2, 0});
  const ArmVector before = joints({-0.3, 0.5}), after = joints({0.3, 0.5});
  const ArmVector blocked = joints({0, 0}), far = joints({-2, 0.5}), farther = joints({2, 0.5});
  const auto way = lazyShortestPath(problem, from, to, {far, farther, blocked, after, before},
                                    length, {.most = 10}, {});
  ASSERT_TRUE(way);
  EXPECT_EQ(way->waypoints, (std::vector<ArmVector>{from, before, after, to}));
  EXPECT_TRUE(pathValid(problem, *way, problem.resolution));
}

TEST(CheapestWay, IsNoneWhenItCostsTooMuchOrTakesTooManyChecks) {
  const MotionProblem problem = wallProblem(2, 0.1);
  const ArmVector from = joints({-2, 0}), to = joints({2, 0});
  const std::vector<ArmVector> vias{joints({-0.3, 0.5}), joints({0.3, 0.5})};
  EXPECT_TRUE(lazyShortestPath(problem, from, to, vias, length, {.most = 4.2}, {}));
  EXPECT_FALSE(lazyShortestPath(problem, from, to, vias, length, {.most = 4.1}, {}));
  EXPECT_FALSE(
      lazyShortestPath(problem, from, to, vias, length, {.most = 10, .most_checks = 3}, {}));
  EXPECT_FALSE(lazyShortestPath(problem, from, to, {}, length, {.most = 10}, {}));
  const Deadline cancelled;
  cancelled.cancel();
  EXPECT_FALSE(lazyShortestPath(problem, from, to, vias, length, {.most = 10}, cancelled));
}

TEST(CheapestWay, HasCornersThatCanBeRounded) {
  MotionProblem problem = wallProblem(2, 0.1);
  const ArmVector from = joints({-2, 0}), to = joints({2, 0});
  // At the wall's edge: what rounds the corners there runs into it.
  const std::vector<ArmVector> tight{joints({-0.21, 0.405}), joints({0.21, 0.405})};
  EXPECT_TRUE(lazyShortestPath(problem, from, to, tight, length, {.most = 10}, {}));
  problem.rounding = 0.05;
  EXPECT_FALSE(lazyShortestPath(problem, from, to, tight, length, {.most = 10}, {}));
  const std::vector<ArmVector> roomy{joints({-0.6, 0.5}), joints({0.6, 0.5})};
  const auto way = lazyShortestPath(problem, from, to, roomy, length, {.most = 10}, {});
  ASSERT_TRUE(way);
  EXPECT_TRUE(cornerValid(problem, way->waypoints[0], way->waypoints[1], way->waypoints[2]));
}

}  // namespace
}  // namespace handover
