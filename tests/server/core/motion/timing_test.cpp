// SPDX-License-Identifier: Apache-2.0
#include "core/motion/timing.hpp"

#include "timing_cases.hpp"

#include <chrono>
#include <cstdio>
#include <limits>

namespace handover::test {
namespace {

// Rest to rest along one straight line: the slowest joint's trapezoid in closed form.
double trapezoid(const VectorXd& move, const TimingLimits& limits) {
  double v = 1e300, a = 1e300;
  for (int j = 0; j < move.size(); ++j) {
    if (move[j] == 0) continue;
    v = std::min(v, limits.velocity[j] / std::abs(move[j]));
    a = std::min(a, limits.acceleration[j] / std::abs(move[j]));
  }
  return v * v >= a ? 2 / std::sqrt(a) : 1 / v + v / a;
}

// How much longer a motion may take for its jerk, from rest to rest: acceleration builds up in
// 0.1 s with our limits, both ways in 0.2 s, and two steps of the samples come on top.
constexpr double kBuildUp = 0.1, kSteps = 0.04;

TEST(Timing, TakesOneBuildUpMoreThanTheTrapezoidOnOneSegment) {
  const TimingLimits limits = armLimits();
  Random random(7);
  for (int run = 0; run < 200; ++run) {
    const VectorXd from = random.point(limits);
    const VectorXd to = from + (random.point(limits) - from) * std::pow(10, random.uniform(-2, 0));
    const auto path = parameterize({from, to}, limits, {});
    ASSERT_TRUE(path);
    expectSound(*path, {from, to}, limits, {});
    // The closed form of the least with this limit of jerk, from rest to rest with a pause in
    // between or none.
    const double best = trapezoid(to - from, limits);
    EXPECT_GE(path->duration(), best + kBuildUp - 1e-6);
    EXPECT_LE(path->duration(), kBuildUp + std::hypot(kBuildUp, best) + 0.03) << run;
    for (int k = 0; k <= 50; ++k) {
      const VectorXd q = evaluate(*path, 0.02 * k * path->duration());
      EXPECT_LE(deviation({from, to}, q), 1e-9) << run;
    }
  }
}

TEST(Timing, KeepsEveryLimitOnRandomPaths) {
  Random random(11);
  for (const int dof : {1, 2, 7, 11}) {
    TimingLimits limits = armLimits(dof);
    for (int run = 0; run < 150; ++run) {
      SCOPED_TRACE(std::to_string(dof) + " joints, run " + std::to_string(run));
      for (int j = 0; j < dof; ++j) {
        limits.acceleration[j] = run % 2 == 0 ? 0.4 : std::pow(10, random.uniform(-1, 1));
        limits.jerk[j] = limits.acceleration[j] * (run % 2 == 0 ? 10 : random.uniform(3, 300));
      }
      const std::vector<VectorXd> waypoints = random.path(limits);
      TimingSettings settings;
      settings.blend = run % 3 == 0 ? 0.005 : run % 3 == 1 ? 0.05 : 0.3;
      const auto path = parameterize(waypoints, limits, settings);
      ASSERT_TRUE(path) << path.error().detail;
      expectSound(*path, waypoints, limits, settings);
    }
  }
}

TEST(Timing, OfMinutesIsSoundWithABoundedNumberOfSamples) {
  TimingLimits limits = armLimits();
  TimingSettings gaps;  // of what is looked at
  gaps.max_sample_gap = 1;
  Random random(13);
  for (const double velocity : {0.01, 0.003, 0.001}) {  // of one joint, down to the least
    limits.velocity[6] = velocity;
    for (int run = 0; run < 5; ++run) {
      SCOPED_TRACE(std::to_string(velocity) + " rad/s, run " + std::to_string(run));
      const std::vector<VectorXd> waypoints = random.path(limits);
      const auto path = parameterize(waypoints, limits, {});
      if (!path) continue;  // more than an hour
      EXPECT_LE(path->t.size(), 12'000u);
      expectSound(*path, waypoints, limits, gaps);
    }
  }
}

TEST(Timing, StaysNearThePolylineAndTheFastestMotion) {
  Random random(12);
  double longest = 0, farthest = 0;
  for (const int dof : {1, 2, 7, 11}) {
    const TimingLimits limits = armLimits(dof);
    TimingLimits no_jerk = limits;
    no_jerk.jerk.setConstant(1e4);
    for (int run = 0; run < 100; ++run) {
      SCOPED_TRACE(std::to_string(dof) + " joints, run " + std::to_string(run));
      const std::vector<VectorXd> waypoints = random.path(limits);
      TimingSettings settings;
      settings.blend = run % 2 == 0 ? 0.01 : 0.05;
      const auto path = parameterize(waypoints, limits, settings);
      const auto fastest = parameterize(waypoints, no_jerk, settings);
      ASSERT_TRUE(path && fastest);
      EXPECT_LE(path->duration(), fastest->duration() + 2 * kBuildUp + kSteps);
      longest = std::max(longest, path->duration() - fastest->duration());
      for (int k = 0; k <= 300; ++k) {
        const double off = deviation(waypoints, evaluate(*path, k / 300.0 * path->duration()));
        EXPECT_LE(off, settings.blend + 0.003);
        farthest = std::max(farthest, off - settings.blend);
      }
    }
  }
  RecordProperty("longest_over_fastest", std::to_string(longest));
  RecordProperty("farthest_beyond_blend", std::to_string(farthest));
}

TEST(Timing, KeepsALimitOfJerkOfAnySize) {
  Random random(21);
  for (const double per_acceleration : {0.01, 0.1, 1.0, 100.0, 1e4, 1e8}) {
    TimingLimits limits = armLimits(3);
    limits.jerk = per_acceleration * limits.acceleration;
    for (int run = 0; run < 20; ++run) {
      SCOPED_TRACE(per_acceleration);
      const std::vector<VectorXd> waypoints = random.path(limits);
      const auto path = parameterize(waypoints, limits, {});
      ASSERT_TRUE(path) << path.error().detail;
      expectSound(*path, waypoints, limits, {});
    }
  }
}

TEST(Timing, IsNearTheOptimumOfShortMotions) {
  // So short that acceleration never gets to its limit: 4 (d / 2 j)^(1/3) from rest to rest.
  const TimingLimits limits = uniformLimits(1, 1, 1, 0.4);
  for (const double d : {1e-3, 3e-4, 1e-4}) {
    const auto path = parameterize({VectorXd::Zero(1), VectorXd::Constant(1, d)}, limits, {});
    ASSERT_TRUE(path);
    expectSound(*path, {VectorXd::Zero(1), VectorXd::Constant(1, d)}, limits, {});
    const double best = 4 * std::cbrt(d / (2 * limits.jerk[0]));
    EXPECT_GE(path->duration(), best * (1 - 1e-9));
    EXPECT_LE(path->duration(), 1.15 * best + 0.006) << d;
  }
}

TEST(Timing, UsesSomeLimitNearlyAlways) {
  const TimingLimits limits = armLimits();
  Random random(3);
  for (int run = 0; run < 50; ++run) {
    std::vector<VectorXd> waypoints;
    for (int i = 0; i < 5; ++i) waypoints.push_back(random.point(limits));
    const auto path = parameterize(waypoints, limits, {});
    ASSERT_TRUE(path);
    // Sum up the time in which a joint is within 15 % of a limit of speed or acceleration.
    double busy = 0;
    for (std::size_t i = 0; i + 1 < path->t.size(); ++i) {
      const LimitUse use = limitUse(slice(*path, i, i + 1), limits);
      if (use.velocity > 0.85 || use.acceleration > 0.85) busy += path->t[i + 1] - path->t[i];
    }
    EXPECT_GT(busy, 0.85 * path->duration()) << run;
  }
}

TEST(Timing, PassesDensePathsWithoutStopping) {
  // 200 points, 5 mm apart, of a line and a bow as inverse kinematics would give them.
  const TimingLimits limits = armLimits();
  std::vector<VectorXd> waypoints;
  for (int i = 0; i < 200; ++i) {
    const double s = i / 199.0;
    VectorXd q(7);
    for (int j = 0; j < 7; ++j)
      q[j] = 0.3 * j - 1 + (0.4 - 0.1 * j) * s + 0.5 * std::sin(2 * s + j);
    for (int j = 0; j < 7; ++j) q[j] += 1e-9 * ((i * 31 + j * 17) % 13 - 6);
    waypoints.push_back(q);
  }
  const auto path = parameterize(waypoints, limits, {});
  ASSERT_TRUE(path);
  expectSound(*path, waypoints, limits, {});
  // As fast as the same curve by five times fewer points, and moving all the way.
  std::vector<VectorXd> sparse;
  for (int i = 0; i < 200; i += 5) sparse.push_back(waypoints[static_cast<std::size_t>(i)]);
  sparse.push_back(waypoints.back());
  const auto coarse = parameterize(sparse, limits, {});
  ASSERT_TRUE(coarse);
  EXPECT_LT(path->duration(), 1.03 * coarse->duration());
  for (std::size_t i = 1; i + 1 < path->t.size(); ++i) {
    if (path->t[i] < 0.3 || path->t[i] > path->duration() - 0.3) continue;
    EXPECT_GT(path->qd[i].norm(), 0.05) << path->t[i];
  }
}

TEST(Timing, CrossesACollinearWaypointAtFullSpeed) {
  const TimingLimits limits = uniformLimits(2, 10, 1, 2);
  const std::vector<VectorXd> waypoints{Eigen::Vector2d(0, 0), Eigen::Vector2d(1.3, 1.3),
                                        Eigen::Vector2d(1.3 + 1e-7, 1.3), Eigen::Vector2d(4, 4)};
  const auto path = parameterize(waypoints, limits, {});
  ASSERT_TRUE(path);
  EXPECT_LE(path->duration(), 1.02 * (4.0 + 0.5) + kBuildUp + kSteps);
}

TEST(Timing, StopsAtCornersWithoutBlend) {
  const TimingLimits limits = uniformLimits(2, 10, 1, 2);
  const std::vector<VectorXd> waypoints{Eigen::Vector2d(0, 0), Eigen::Vector2d(2, 0),
                                        Eigen::Vector2d(2, 1)};
  TimingSettings settings;
  settings.blend = 0;
  const auto path = parameterize(waypoints, limits, settings);
  ASSERT_TRUE(path);
  expectSound(*path, waypoints, limits, settings);
  EXPECT_NEAR(path->duration(), 2.5 + 1.5 + 2 * kBuildUp, 0.1);
  for (const VectorXd& q : path->q) EXPECT_LE(deviation(waypoints, q), 1e-9);
  const auto corner = std::find(path->q.begin(), path->q.end(), waypoints[1]);
  ASSERT_NE(corner, path->q.end());
  EXPECT_EQ(path->qd[static_cast<std::size_t>(corner - path->q.begin())].norm(), 0);
  EXPECT_EQ(path->qdd[static_cast<std::size_t>(corner - path->q.begin())].norm(), 0);
}

TEST(Timing, TurnsBackAtAJointLimit) {
  const TimingLimits limits = uniformLimits(2, 1, 1, 1);
  for (const double blend : {1e-6, 1e-3, 0.05, 1.0}) {
    const std::vector<VectorXd> waypoints{Eigen::Vector2d(0, -1),  Eigen::Vector2d(1, 1),
                                          Eigen::Vector2d(1, 0),   Eigen::Vector2d(-1, 0.5),
                                          Eigen::Vector2d(1, 0.5), Eigen::Vector2d(-1, -1)};
    TimingSettings settings;
    settings.blend = blend;
    const auto path = parameterize(waypoints, limits, settings);
    ASSERT_TRUE(path);
    SCOPED_TRACE(blend);
    expectSound(*path, waypoints, limits, settings);
  }
}

TEST(Timing, NamesPathsThatGoNowhere) {
  const TimingLimits limits = uniformLimits(3, 1, 1, 1);
  const VectorXd q = Eigen::Vector3d(0.1, 0.2, 1.0);
  for (const std::vector<VectorXd>& waypoints :
       {std::vector<VectorXd>{q}, std::vector<VectorXd>{q, q, q}}) {
    const auto path = parameterize(waypoints, limits, {});
    ASSERT_TRUE(path);
    ASSERT_EQ(path->t, (std::vector<double>{0, 2e-3}));
    EXPECT_EQ(path->q[0], q);
    EXPECT_EQ(path->q[1], q);
    EXPECT_EQ(path->qd[0].norm() + path->qd[1].norm(), 0);
    EXPECT_EQ(path->qdd[0].norm() + path->qdd[1].norm(), 0);
  }
}

TEST(Timing, MovesByTinyAmounts) {
  const TimingLimits limits = uniformLimits(1, 1, 1, 1);
  for (const double move : {1e-12, 1e-9, 1e-7, 1e-5, 1e-3}) {
    const std::vector<VectorXd> waypoints{VectorXd::Constant(1, 0.5),
                                          VectorXd::Constant(1, 0.5 + move)};
    const auto path = parameterize(waypoints, limits, {});
    ASSERT_TRUE(path);
    SCOPED_TRACE(move);
    expectSound(*path, waypoints, limits, {});
  }
}

TEST(Timing, StretchesBySpeedScale) {
  const TimingLimits limits = armLimits();
  Random random(5);
  std::vector<VectorXd> waypoints;
  for (int i = 0; i < 4; ++i) waypoints.push_back(random.point(limits));
  TimingSettings slow;
  slow.speed_scale = 0.25;
  const auto full = parameterize(waypoints, limits, {}),
             quarter = parameterize(waypoints, limits, slow);
  ASSERT_TRUE(full && quarter);
  EXPECT_NEAR(quarter->duration(), 4 * full->duration(), 1e-9 * quarter->duration());
  expectSound(*quarter, waypoints, limits, slow);
  EXPECT_LE(limitUse(*quarter, limits).acceleration, 1.0 / 16 + 1e-9);
  EXPECT_LE(limitUse(*quarter, limits).velocity, 1.0 / 4 + 1e-9);
  EXPECT_LE(limitUse(*quarter, limits).jerk, 1.0 / 64 + 1e-6);
  for (double x : {0.0, 0.1, 0.37, 0.9, 1.0}) {
    const double t = x * full->duration();
    EXPECT_LT((evaluate(*full, t) - evaluate(*quarter, 4 * t)).norm(), 1e-9);
  }
}

TEST(Timing, HasTheSameSamplesAtAnySpeed) {
  const TimingLimits limits = armLimits();
  Random random(23);
  std::vector<VectorXd> waypoints;
  for (int i = 0; i < 4; ++i) waypoints.push_back(random.point(limits));
  const auto full = parameterize(waypoints, limits, {});
  ASSERT_TRUE(full);
  for (const double speed_scale : {0.5, 1e-3, 1e-9}) {
    const auto slow = parameterize(waypoints, limits, {.speed_scale = speed_scale});
    ASSERT_TRUE(slow);
    EXPECT_EQ(slow->q, full->q);
    EXPECT_NEAR(slow->duration() * speed_scale, full->duration(), 1e-9 * full->duration());
  }
}

TEST(Timing, RejectsBadInput) {
  const TimingLimits good = uniformLimits(2, 1, 1, 1);
  const VectorXd a = Eigen::Vector2d(0, 0), b = Eigen::Vector2d(0.5, 0.5);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto code = [](const std::vector<VectorXd>& waypoints, const TimingLimits& limits,
                       const TimingSettings& settings) {
    const auto path = parameterize(waypoints, limits, settings);
    return path ? ErrorCode::kInternal : path.error().code;
  };
  const auto changed = [&](auto change) {
    TimingLimits limits = good;
    change(limits);
    return limits;
  };
  const auto invalid = ErrorCode::kInvalidInput;
  EXPECT_EQ(code({}, good, {}), invalid);
  EXPECT_EQ(code({VectorXd()}, good, {}), invalid);
  EXPECT_EQ(code({a, Eigen::Vector2d(0, nan)}, good, {}), invalid);
  EXPECT_EQ(code({a, Eigen::Vector3d(0, 0, 0)}, good, {}), invalid);
  EXPECT_EQ(code({a, Eigen::Vector2d(0, 1.001)}, good, {}), invalid);
  EXPECT_EQ(code({Eigen::Vector2d(-1.001, 0), b}, good, {}), invalid);
  EXPECT_EQ(code({a, b}, changed([](auto& l) { l.velocity[1] = 0; }), {}), invalid);
  EXPECT_EQ(code({a, b}, changed([](auto& l) { l.acceleration[0] = -1; }), {}), invalid);
  EXPECT_EQ(code({a, b}, changed([&](auto& l) { l.acceleration[0] = nan; }), {}), invalid);
  EXPECT_EQ(code({a, b}, changed([](auto& l) { l.jerk[0] = 0; }), {}), invalid);
  EXPECT_EQ(code({a, b}, changed([&](auto& l) { l.jerk[1] = nan; }), {}), invalid);
  EXPECT_EQ(code({a, b}, changed([](auto& l) { l.jerk = VectorXd(); }), {}), invalid);
  EXPECT_EQ(code({a, b}, changed([](auto& l) { l.velocity.setConstant(1e-5); }), {}), invalid);
  EXPECT_EQ(code({a, b}, changed([](auto& l) { l.jerk.setConstant(1e-12); }), {}), invalid);
  EXPECT_EQ(code({a, b}, changed([](auto& l) { l.lower[0] = 2; }), {}), invalid);
  EXPECT_EQ(code({a, b}, changed([](auto& l) { l.upper = Eigen::Vector3d(1, 1, 1); }), {}),
            invalid);
  EXPECT_EQ(code({a, b}, good, {.blend = -0.1}), invalid);
  EXPECT_EQ(code({a, b}, good, {.max_sample_gap = 0}), invalid);
  EXPECT_EQ(code({a, b}, good, {.speed_scale = 0}), invalid);
  EXPECT_EQ(code({a, b}, good, {.speed_scale = 1.5}), invalid);
}

TEST(Timing, RepeatsToTheByte) {
  const TimingLimits limits = armLimits();
  Random random(17);
  std::vector<VectorXd> waypoints;
  for (int i = 0; i < 6; ++i) waypoints.push_back(random.point(limits));
  const auto first = parameterize(waypoints, limits, {}),
             again = parameterize(waypoints, limits, {});
  ASSERT_TRUE(first && again);
  EXPECT_EQ(first->t, again->t);
  EXPECT_EQ(first->q, again->q);
  EXPECT_EQ(first->qd, again->qd);
  EXPECT_EQ(first->qdd, again->qdd);
}

TEST(Timing, TakesWellUnderAMillisecond) {
  const TimingLimits limits = armLimits();
  Random random(19);
  std::vector<VectorXd> waypoints;
  for (int i = 0; i < 6; ++i) waypoints.push_back(random.point(limits));
  const auto start = std::chrono::steady_clock::now();
  std::size_t samples = 0;
  constexpr int kRuns = 200;
  for (int run = 0; run < kRuns; ++run) samples = parameterize(waypoints, limits, {})->t.size();
  const double ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count() /
      kRuns;
  RecordProperty("ms_per_path", std::to_string(ms));
  RecordProperty("samples", std::to_string(samples));
  std::printf("timing: %.3f ms per 6-waypoint path of 7 joints, %zu samples\n", ms, samples);
  EXPECT_LT(ms, 20);  // loose: sanitizers and shared cores; the bench has the figure
}

}  // namespace
}  // namespace handover::test
