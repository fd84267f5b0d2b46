// SPDX-License-Identifier: Apache-2.0
#include "core/motion/ikbirrt.hpp"

#include "problems.hpp"

#include <handover/common/random.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <thread>

namespace handover {
namespace {

using test::DiscWorld;
using test::emptyProblem;
using test::joints;
using test::pathValid;
using test::wallProblem;

GoalSampler listOf(std::vector<ArmVector> goals) {
  return [goals = std::move(goals)](std::uint32_t i, ArmVector& q) {
    if (i >= goals.size()) return false;
    q = goals[i];
    return true;
  };
}

ArmVector randomJoints(const MotionProblem& problem, SeededRandom& random) {
  ArmVector q(problem.lower.size());
  for (int j = 0; j < q.size(); ++j) q[j] = random.uniform(problem.lower[j], problem.upper[j]);
  return q;
}

ArmVector randomValid(const MotionProblem& problem, SeededRandom& random) {
  for (;;) {
    const ArmVector q = randomJoints(problem, random);
    if (problem.valid(q)) return q;
  }
}

std::string bytesOf(const JointPath& path) {
  std::string bytes;
  for (const ArmVector& q : path.waypoints) {
    bytes.append(reinterpret_cast<const char*>(q.data()),
                 sizeof(double) * static_cast<std::size_t>(q.size()));
  }
  return bytes;
}

TEST(IkBiRrt, TakesTheStraightSegmentWhereItIsFree) {
  std::uint32_t goal = 9;
  const ArmVector start = joints({0, 0}), end = joints({1, 2});
  const auto path = planIkBiRrt(emptyProblem(2), start, listOf({end}), {}, {}, &goal);
  ASSERT_TRUE(path);
  ASSERT_EQ(path->waypoints.size(), 2u);
  EXPECT_EQ(path->waypoints[0], start);
  EXPECT_EQ(path->waypoints[1], end);
  EXPECT_EQ(goal, 0u);
}

TEST(IkBiRrt, PassesANarrowHoleInThePlane) {
  const MotionProblem problem = wallProblem(2, 0.05);
  const ArmVector start = joints({-2, -2}), end = joints({2, 2});
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const auto path = planIkBiRrt(problem, start, listOf({end}), {.seed = seed}, {});
    ASSERT_TRUE(path) << path.error().detail;
    EXPECT_EQ(path->waypoints.front(), start);
    EXPECT_EQ(path->waypoints.back(), end);
    EXPECT_TRUE(pathValid(problem, *path, problem.resolution));
  }
}

// A hole too narrow to be found, but somebody has been through it; or nearly.
TEST(IkBiRrt, BeginsWithKnownWays) {
  const MotionProblem problem = wallProblem(7, 0.02);
  const ArmVector start = ArmVector::Constant(7, -2), end = ArmVector::Constant(7, 2);
  ArmVector before = ArmVector::Constant(7, 0.5), behind = before;
  before[0] = -0.5;
  behind[0] = 0.5;
  IkBiRrtSettings settings{.max_iterations = 300};
  EXPECT_FALSE(planIkBiRrt(problem, start, listOf({end}), settings, {}));
  const std::vector<ArmVector> there{before, behind}, back{behind, before};
  for (const bool from_goal : {false, true}) {
    settings.from_start = from_goal ? std::vector<ArmVector>{} : there;
    settings.from_goal = from_goal ? back : std::vector<ArmVector>{};
    const auto path = planIkBiRrt(problem, start, listOf({end}), settings, {});
    ASSERT_TRUE(path) << path.error().detail;
    EXPECT_EQ(path->waypoints.front(), start);
    EXPECT_EQ(path->waypoints.back(), end);
    EXPECT_TRUE(pathValid(problem, *path, problem.resolution));
  }
  // Outside the limits, through the wall: not gone on from there.
  ArmVector outside = start;
  outside[1] = -9;
  settings.from_start = {outside, before, behind};
  settings.from_goal = {start, behind, before};
  EXPECT_FALSE(planIkBiRrt(problem, start, listOf({end}), settings, {}));
}

TEST(IkBiRrt, GrowsAlongASheetThatItsStatesAreProjectedOnto) {
  // A shell of a ball, and on it a wall with a way round at one side only.
  MotionProblem problem = emptyProblem(3);
  problem.valid = [](const ArmVector& q) {
    const bool wall = std::abs(q[0]) < 0.1 && q[1] > -1.2;
    return std::abs(q.norm() - 2) <= 0.02 && !wall;
  };
  const ArmVector start = joints({2, 0, 0}), end = joints({-1.2, 1.6, 0});
  IkBiRrtSettings settings;
  settings.max_iterations = 2'000;
  EXPECT_FALSE(planIkBiRrt(problem, start, listOf({end}), settings, {}));
  problem.project = [](ArmVector& q) {
    const double norm = q.norm();
    if (!(norm > 0.1)) return false;
    q *= 2 / norm;
    return true;
  };
  const auto path = planIkBiRrt(problem, start, listOf({end}), settings, {});
  ASSERT_TRUE(path) << path.error().detail;
  EXPECT_EQ(path->waypoints.front(), start);
  EXPECT_EQ(path->waypoints.back(), end);
  EXPECT_TRUE(pathValid(problem, *path, 0.01));
  const auto again = planIkBiRrt(problem, start, listOf({end}), settings, {});
  EXPECT_EQ(bytesOf(*again), bytesOf(*path));
}

TEST(IkBiRrt, PassesAHoleInSevenJoints) {
  const MotionProblem problem = wallProblem(7, 1.2);
  const ArmVector start = joints({-2, -2, -2, -2, -2, -2, -2}), end = joints({2, 2, 2, 2, 2, 2, 2});
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto path = planIkBiRrt(problem, start, listOf({end}), {.seed = seed}, {});
    ASSERT_TRUE(path) << path.error().detail;
    EXPECT_TRUE(pathValid(problem, *path, problem.resolution));
  }
}

// Checked with 2 cm to spare, as the real checker inflates shapes: then half the step is free, too.
TEST(IkBiRrt, IsFreeAtHalfTheCheckingStep) {
  const MotionProblem problem = DiscWorld::problem(0.02), exact = DiscWorld::problem();
  SeededRandom random(23);
  int solved = 0;
  for (int run = 0; run < 40; ++run) {
    const ArmVector start = randomValid(problem, random);
    std::vector<ArmVector> goals;
    for (int i = 0; i < 8; ++i) goals.push_back(randomJoints(problem, random));
    std::uint32_t goal = 99;
    const auto path = planIkBiRrt(problem, start, listOf(goals), {.seed = 5}, {}, &goal);
    if (!path) {
      EXPECT_TRUE(std::none_of(goals.begin(), goals.end(), problem.valid)) << path.error().detail;
      continue;
    }
    ++solved;
    EXPECT_EQ(path->waypoints.front(), start);
    ASSERT_LT(goal, goals.size());
    EXPECT_EQ(path->waypoints.back(), goals[goal]);
    EXPECT_TRUE(pathValid(problem, *path, problem.resolution));
    EXPECT_TRUE(pathValid(exact, *path, 0.5 * problem.resolution));
    for (std::size_t i = 1; i < path->waypoints.size(); ++i) {
      EXPECT_NE(path->waypoints[i], path->waypoints[i - 1]);
      EXPECT_TRUE((path->waypoints[i].array() >= problem.lower.array()).all());
      EXPECT_TRUE((path->waypoints[i].array() <= problem.upper.array()).all());
    }
  }
  EXPECT_GT(solved, 35);
}

TEST(IkBiRrt, StillComesWhenTheFirstTwentyGoalsAreBlocked) {
  const MotionProblem problem = wallProblem(2, 0.3);
  std::vector<ArmVector> goals;
  for (int i = 0; i < 20; ++i) goals.push_back(joints({0.0, -2 + 0.01 * i}));
  for (int i = 0; i < 5; ++i) goals.push_back(joints({2, 1 + 0.1 * i}));
  std::uint32_t goal = 0;
  const auto path = planIkBiRrt(problem, joints({-2, -2}), listOf(goals), {}, {}, &goal);
  ASSERT_TRUE(path);
  ASSERT_GE(goal, 20u);
  EXPECT_EQ(path->waypoints.back(), goals[goal]);
}

TEST(IkBiRrt, StillComesWhenTheFirstTwentyGoalsAreValidButWalledIn) {
  // Pockets so tight that no tree grows out of them: later goals have to enter during the search.
  MotionProblem problem = emptyProblem(2);
  problem.valid = [](const ArmVector& q) {
    if (q[0] < 2.5) return std::abs(q[0] - 1) > 0.2 || std::abs(q[1]) < 0.4;
    return (q - joints({2.8, 2.8})).norm() < 0.02;
  };
  std::vector<ArmVector> goals;
  for (int i = 0; i < 20; ++i) goals.push_back(joints({2.8 + 0.0005 * i, 2.8}));
  goals.push_back(joints({2.2, 2}));
  std::uint32_t asked = 0, goal = 0;
  const GoalSampler list = listOf(goals);
  const auto path = planIkBiRrt(
      problem, joints({-2, -2}),
      [&](std::uint32_t i, ArmVector& q) {
        EXPECT_EQ(i, asked++);
        return list(i, q);
      },
      {}, {}, &goal);
  ASSERT_TRUE(path) << path.error().detail;
  EXPECT_EQ(goal, 20u);
  EXPECT_EQ(path->waypoints.back(), goals[20]);
  // The problem tests what it says: with the goals of the beginning alone there is no path.
  EXPECT_FALSE(planIkBiRrt(problem, joints({-2, -2}), listOf(goals),
                           {.max_iterations = 2000, .goal_period = 1'000'000}, {}));
}

TEST(IkBiRrt, SkipsGoalsThatAreNoConfigurations) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const ArmVector end = joints({1, 1});
  std::uint32_t goal = 0;
  const auto path =
      planIkBiRrt(emptyProblem(2), joints({0, 0}),
                  listOf({joints({nan, 0}), joints({4, 0}), joints({1}), joints({0, -3.1}), end}),
                  {}, {}, &goal);
  ASSERT_TRUE(path);
  EXPECT_EQ(goal, 4u);
  EXPECT_EQ(path->waypoints.back(), end);
}

TEST(IkBiRrt, EndsByTheIterationCount) {
  MotionProblem problem = wallProblem(3, 0);
  std::uint64_t checks = 0;
  const auto inner = problem.valid;
  problem.valid = [&](const ArmVector& q) {
    ++checks;
    return inner(q);
  };
  const auto plan = [&](std::uint32_t iterations) {
    checks = 0;
    const auto path = planIkBiRrt(problem, joints({-2, 0, 0}), listOf({joints({2, 0, 0})}),
                                  {.max_iterations = iterations}, {});
    EXPECT_FALSE(path);
    if (!path) {
      EXPECT_EQ(path.error().code, ErrorCode::kNoPath);
    }
    return checks;
  };
  const std::uint64_t few = plan(100), more = plan(1000);
  EXPECT_GT(few, 100u);
  EXPECT_GT(more, 2 * few);
  EXPECT_EQ(plan(100), few);
}

TEST(IkBiRrt, HasNoPathWithoutAValidGoal) {
  for (const auto& goals : {std::vector<ArmVector>{}, {joints({0, 0})}}) {
    const auto path = planIkBiRrt(wallProblem(2, 0.1), joints({-2, 0}), listOf(goals), {}, {});
    ASSERT_FALSE(path);
    EXPECT_EQ(path.error().code, ErrorCode::kNoPath);
  }
  // Endless invalid goals end by the count, too.
  std::uint32_t asked = 0;
  const auto path = planIkBiRrt(wallProblem(2, 0.1), joints({-2, 0}),
                                [&](std::uint32_t i, ArmVector& q) {
                                  asked = i + 1;
                                  q = joints({0, 0});
                                  return true;
                                },
                                {.max_iterations = 500}, {});
  ASSERT_FALSE(path);
  EXPECT_EQ(path.error().code, ErrorCode::kNoPath);
  EXPECT_LE(asked, 500u);
}

TEST(IkBiRrt, ReturnsPromptlyWhenCancelled) {
  const Deadline deadline;
  MotionProblem problem = wallProblem(3, 0);
  const auto inner = problem.valid;
  std::uint64_t checks = 0, after = 0;
  problem.valid = [&](const ArmVector& q) {
    if (++checks == 5000) deadline.cancel();
    if (checks > 5000) ++after;
    return inner(q);
  };
  const auto path = planIkBiRrt(problem, joints({-2, 0, 0}), listOf({joints({2, 0, 0})}),
                                {.max_iterations = 4'000'000'000u}, deadline);
  ASSERT_FALSE(path);
  EXPECT_EQ(path.error().code, ErrorCode::kCancelled);
  EXPECT_LT(after, 1000u);

  const Deadline past(Deadline::Clock::now() - std::chrono::seconds(1));
  const auto late =
      planIkBiRrt(problem, joints({-2, 0, 0}), listOf({joints({-1, 0, 0})}), {}, past);
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, ErrorCode::kDeadline);
  const Deadline soon(Deadline::Clock::now() + std::chrono::milliseconds(20));
  const auto cut = planIkBiRrt(problem, joints({-2, 0, 0}), listOf({joints({2, 0, 0})}),
                               {.max_iterations = 4'000'000'000u}, soon);
  ASSERT_FALSE(cut);
  EXPECT_EQ(cut.error().code, ErrorCode::kDeadline);
}

TEST(IkBiRrt, RejectsBadInput) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const MotionProblem good = emptyProblem(2);
  const ArmVector start = joints({0, 0});
  const auto code = [](const MotionProblem& problem, const ArmVector& from,
                       const IkBiRrtSettings& settings) {
    const auto path = planIkBiRrt(problem, from, listOf({joints({1, 1})}), settings, {});
    return path ? std::optional<ErrorCode>() : path.error().code;
  };
  const auto changed = [&](auto change) {
    MotionProblem problem = good;
    change(problem);
    return problem;
  };
  const auto invalid = ErrorCode::kInvalidInput;
  EXPECT_EQ(code(good, start, {}), std::nullopt);
  EXPECT_EQ(code(good, joints({nan, 0}), {}), invalid);
  EXPECT_EQ(code(good, joints({0, 0, 0}), {}), invalid);
  EXPECT_EQ(code(good, joints({0, 3.1}), {}), invalid);
  EXPECT_EQ(code(good, start, {.range = 0}), invalid);
  EXPECT_EQ(code(good, start, {.range = nan}), invalid);
  EXPECT_EQ(code(good, start, {.goal_period = 0}), invalid);
  EXPECT_EQ(code(changed([](auto& p) { p.resolution = 0; }), start, {}), invalid);
  EXPECT_EQ(code(changed([](auto& p) { p.valid = nullptr; }), start, {}), invalid);
  EXPECT_EQ(code(changed([&](auto& p) { p.lower[0] = nan; }), start, {}), invalid);
  EXPECT_EQ(code(changed([](auto& p) { p.lower[0] = 3.5; }), start, {}), invalid);
  EXPECT_EQ(code(changed([](auto& p) { p.upper = joints({1}); }), start, {}), invalid);
  EXPECT_EQ(code(wallProblem(2, 0.1), start, {}), ErrorCode::kInCollision);
  // A joint with one position only, and a start on the limit to rounding.
  EXPECT_EQ(code(changed([](auto& p) { p.lower[1] = p.upper[1] = 1; }), joints({3 + 1e-12, 1}), {}),
            std::nullopt);
}

TEST(IkBiRrt, RepeatsToTheByteInThreadsAndAmongOtherPlanning) {
  const MotionProblem problem = DiscWorld::problem();
  SeededRandom random(31);
  const ArmVector start = randomValid(problem, random), other = randomValid(problem, random);
  std::vector<ArmVector> goals;
  for (int i = 0; i < 30; ++i) goals.push_back(randomJoints(problem, random));
  const IkBiRrtSettings settings{.seed = 12, .direct_goals = 0};
  const auto run = [&] {
    const auto path = planIkBiRrt(problem, start, listOf(goals), settings, {});
    return path ? bytesOf(*path) + bytesOf(shortcut(problem, *path, 3, 60, {}))
                : path.error().detail;
  };
  const std::string first = run();
  ASSERT_GT(first.size(), 4 * 7 * sizeof(double));
  for (int i = 0; i < 50; ++i) {
    // Unrelated planning, of another amount each time, moves OMPL's process-wide seeds.
    for (int k = 0; k < i % 4; ++k) {
      (void)planIkBiRrt(problem, other, listOf({goals[0], goals[1]}),
                        {.seed = static_cast<std::uint64_t>(100 * i + k), .max_iterations = 50},
                        {});
    }
    ASSERT_EQ(run(), first) << i;
  }
  std::string a, b;
  std::thread left([&] {
    for (int i = 0; i < 10; ++i) a += run();
  });
  std::thread right([&] {
    for (int i = 0; i < 10; ++i) b += run();
  });
  left.join();
  right.join();
  EXPECT_EQ(a, b);
  EXPECT_EQ(a.substr(0, first.size()), first);
  // Another seed searches elsewhere.
  const auto different =
      planIkBiRrt(problem, start, listOf(goals), {.seed = 13, .direct_goals = 0}, {});
  ASSERT_TRUE(different);
  EXPECT_NE(bytesOf(*different), first.substr(0, bytesOf(*different).size()));
}

TEST(SegmentValid, ChecksEveryStepAndBothEnds) {
  MotionProblem problem = emptyProblem(2);
  problem.resolution = 0.1;
  std::vector<double> seen;
  problem.valid = [&](const ArmVector& q) {
    seen.push_back(q[0]);
    return true;
  };
  for (const double to : {0.0, 0.05, 0.1, 0.33, 1.0, 1.7}) {
    seen.clear();
    EXPECT_TRUE(segmentValid(problem, joints({0, 0}), joints({to, -to / 2})));
    std::sort(seen.begin(), seen.end());
    EXPECT_EQ(seen.front(), 0);
    EXPECT_EQ(seen.back(), to);
    EXPECT_EQ(seen.size(), static_cast<std::size_t>(std::max(2.0, std::ceil(to / 0.1) + 1)));
    for (std::size_t i = 1; i < seen.size(); ++i) EXPECT_LE(seen[i] - seen[i - 1], 0.1 + 1e-12);
  }
  for (const double blocked : {0.0, 0.5, 0.9, 1.0}) {
    problem.valid = [&](const ArmVector& q) { return std::abs(q[0] - blocked) > 0.01; };
    EXPECT_FALSE(segmentValid(problem, joints({0, 0}), joints({1, 0})));
  }
  problem.valid = [](const ArmVector&) { return true; };
  EXPECT_FALSE(
      segmentValid(problem, joints({0, 0}), joints({std::numeric_limits<double>::quiet_NaN(), 0})));
}

TEST(Shortcut, NeverLengthensAndStaysValid) {
  const MotionProblem problem = DiscWorld::problem();
  SeededRandom random(41);
  double before = 0, after = 0;
  for (int run = 0; run < 40; ++run) {
    const ArmVector start = randomValid(problem, random), end = randomValid(problem, random);
    const auto path =
        planIkBiRrt(problem, start, listOf({end}), {.seed = 2, .direct_goals = 0}, {});
    ASSERT_TRUE(path) << path.error().detail;
    const JointPath shorter = shortcut(problem, *path, 7, 100, {});
    EXPECT_EQ(shorter.waypoints.front(), start);
    EXPECT_EQ(shorter.waypoints.back(), end);
    EXPECT_LE(test::length(shorter), test::length(*path) + 1e-12);
    EXPECT_TRUE(pathValid(problem, shorter, problem.resolution));
    before += test::length(*path);
    after += test::length(shorter);
  }
  EXPECT_LT(after, 0.7 * before);
}

TEST(Shortcut, FindsTheStraightSegmentAndKeepsShortPaths) {
  const MotionProblem problem = emptyProblem(2);
  const JointPath detour{{joints({0, 0}), joints({1, 2}), joints({2, -1}), joints({2, 0})}};
  EXPECT_EQ(shortcut(problem, detour, 1, 10, {}).waypoints,
            (std::vector<ArmVector>{joints({0, 0}), joints({2, 0})}));
  const JointPath two{{joints({0, 0}), joints({1, 2})}}, one{{joints({0, 0})}};
  EXPECT_EQ(shortcut(problem, two, 1, 10, {}).waypoints, two.waypoints);
  EXPECT_EQ(shortcut(problem, one, 1, 10, {}).waypoints, one.waypoints);
  EXPECT_TRUE(shortcut(problem, {}, 1, 10, {}).waypoints.empty());
  const Deadline cancelled;
  cancelled.cancel();
  EXPECT_EQ(shortcut(problem, detour, 1, 10, cancelled).waypoints, detour.waypoints);
}

TEST(IkBiRrt, TakesMilliseconds) {
  MotionProblem problem = DiscWorld::problem();
  std::uint64_t checks = 0;
  problem.valid = [&](const ArmVector& q) {
    ++checks;
    return DiscWorld::clearance(q) > 0;
  };
  SeededRandom random(47);
  using Clock = std::chrono::steady_clock;
  const auto ms = [](Clock::duration d) {
    return std::chrono::duration<double, std::milli>(d).count();
  };
  std::vector<double> plan_ms, cut_ms, empty_ms;
  std::uint64_t plan_checks = 0, cut_checks = 0;
  constexpr int kRuns = 200;
  for (int run = 0; run < kRuns; ++run) {
    const ArmVector start = randomValid(problem, random), end = randomValid(problem, random);
    checks = 0;
    const auto t0 = Clock::now();
    const auto path = planIkBiRrt(problem, start, listOf({end}), {}, {});
    const auto t1 = Clock::now();
    ASSERT_TRUE(path);
    plan_checks += checks;
    checks = 0;
    (void)shortcut(problem, *path, 1, 60, {});
    const auto t2 = Clock::now();
    cut_checks += checks;
    (void)planIkBiRrt(emptyProblem(7), start, listOf({end}), {}, {});
    plan_ms.push_back(ms(t1 - t0));
    cut_ms.push_back(ms(t2 - t1));
    empty_ms.push_back(ms(Clock::now() - t2));
  }
  const auto report = [](const char* what, std::vector<double>& v, double n) {
    std::sort(v.begin(), v.end());
    std::printf("%s: median %.3f ms, p95 %.3f ms, %.0f checks on average\n", what, v[v.size() / 2],
                v[v.size() * 95 / 100], n / kRuns);
  };
  report("plan among discs", plan_ms, static_cast<double>(plan_checks));
  report("shortcut, 60 attempts", cut_ms, static_cast<double>(cut_checks));
  report("plan in free space", empty_ms, 0);
  EXPECT_LT(plan_ms[kRuns / 2], 200);  // loose: sanitizers and shared cores
}

}  // namespace
}  // namespace handover
