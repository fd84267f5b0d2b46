// SPDX-License-Identifier: Apache-2.0
#include "core/motion/timing.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <random>

namespace handover {
namespace {

using Eigen::VectorXd;

TimingLimits uniformLimits(int dof, double position, double velocity, double acceleration) {
  return {VectorXd::Constant(dof, -position), VectorXd::Constant(dof, position),
          VectorXd::Constant(dof, velocity), VectorXd::Constant(dof, acceleration)};
}

// The LWA4's orders of magnitude.
TimingLimits armLimits() {
  TimingLimits limits = uniformLimits(7, 3.0, 1.2, 0.4);
  for (int j = 0; j < 7; ++j) limits.velocity[j] = 0.9 + 0.1 * j;
  return limits;
}

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }

  VectorXd point(const TimingLimits& limits) {
    VectorXd q(limits.lower.size());
    for (int j = 0; j < q.size(); ++j) q[j] = uniform(limits.lower[j], limits.upper[j]);
    return q;
  }

 private:
  std::mt19937_64 engine_;
};

// Bernstein form, to be independent of the code under test.
VectorXd hermite(const TimedPath& path, std::size_t i, double x) {
  const double h = path.t[i + 1] - path.t[i], y = 1 - x;
  return y * y * y * path.q[i] + 3 * y * y * x * (path.q[i] + h / 3 * path.qd[i]) +
         3 * y * x * x * (path.q[i + 1] - h / 3 * path.qd[i + 1]) + x * x * x * path.q[i + 1];
}

void expectSound(const TimedPath& path, const std::vector<VectorXd>& waypoints,
                 const TimingLimits& limits, const TimingSettings& settings) {
  ASSERT_GE(path.t.size(), 2u);
  ASSERT_EQ(path.t.size(), path.q.size());
  ASSERT_EQ(path.t.size(), path.qd.size());
  EXPECT_EQ(path.t.front(), 0);
  EXPECT_EQ(path.q.front(), waypoints.front());
  EXPECT_EQ(path.q.back(), waypoints.back());
  EXPECT_EQ(path.qd.front().cwiseAbs().maxCoeff(), 0);
  EXPECT_EQ(path.qd.back().cwiseAbs().maxCoeff(), 0);
  for (std::size_t i = 0; i + 1 < path.t.size(); ++i) {
    EXPECT_LT(path.t[i], path.t[i + 1]);
    EXPECT_LE(path.t[i + 1] - path.t[i],
              settings.max_sample_gap / settings.speed_scale * (1 + 1e-9));
    EXPECT_TRUE(path.q[i].allFinite());
    EXPECT_TRUE(path.qd[i].allFinite());
  }
  const LimitUse use = limitUse(path, limits);
  EXPECT_LE(use.velocity, 1.0);
  EXPECT_LE(use.acceleration, 1.0);
  EXPECT_LE(positionExcess(path, limits), 1e-9);
  // Nothing between the samples beats the exact extremes.
  for (std::size_t i = 0; i + 1 < path.t.size(); ++i) {
    const double h = path.t[i + 1] - path.t[i];
    for (int k = 0; k <= 6; ++k) {
      const VectorXd q = hermite(path, i, k / 6.0);
      EXPECT_LE((q - limits.upper).maxCoeff(), 1e-9);
      EXPECT_LE((limits.lower - q).maxCoeff(), 1e-9);
      if (h < 1e-3 || k == 0 || k == 6) continue;
      const VectorXd ahead = hermite(path, i, (k + 0.01) / 6),
                     behind = hermite(path, i, (k - 0.01) / 6);
      const VectorXd speed = (ahead - behind).cwiseAbs() / (0.02 / 6 * h);
      EXPECT_LE((speed.array() / limits.velocity.array()).maxCoeff(), use.velocity + 1e-4);
    }
  }
}

// Distance of q from the polyline.
double deviation(const std::vector<VectorXd>& waypoints, const VectorXd& q) {
  double best = (q - waypoints[0]).norm();
  for (std::size_t i = 0; i + 1 < waypoints.size(); ++i) {
    const VectorXd d = waypoints[i + 1] - waypoints[i];
    const double s =
        std::clamp(d.dot(q - waypoints[i]) / std::max(d.squaredNorm(), 1e-300), 0.0, 1.0);
    best = std::min(best, (q - waypoints[i] - s * d).norm());
  }
  return best;
}

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

TEST(Timing, MatchesTheTrapezoidOnOneSegment) {
  const TimingLimits limits = armLimits();
  Random random(7);
  for (int run = 0; run < 200; ++run) {
    const VectorXd from = random.point(limits);
    const VectorXd to = from + (random.point(limits) - from) * std::pow(10, random.uniform(-4, 0));
    const auto path = parameterize({from, to}, limits, {});
    ASSERT_TRUE(path);
    expectSound(*path, {from, to}, limits, {});
    const double best = trapezoid(to - from, limits);
    EXPECT_GE(path->duration(), best * (1 - 1e-9));
    EXPECT_LE(path->duration(), best * 1.02) << run;
  }
}

TEST(Timing, KeepsEveryLimitOnRandomPaths) {
  const TimingLimits limits = armLimits();
  Random random(11);
  double worst_stretch = 1;
  for (int run = 0; run < 400; ++run) {
    std::vector<VectorXd> waypoints{random.point(limits)};
    const int count = 1 + static_cast<int>(random.uniform(1, 9));
    for (int i = 0; i < count; ++i) {
      const double size = std::pow(10, random.uniform(-3, 0));
      waypoints.push_back(waypoints.back() + size * (random.point(limits) - waypoints.back()));
    }
    TimingSettings settings;
    settings.blend = run % 3 == 0 ? 0.005 : run % 3 == 1 ? 0.05 : 0.3;
    double stretch = 0;
    const auto path = parameterize(waypoints, limits, settings, &stretch);
    ASSERT_TRUE(path) << path.error().detail;
    SCOPED_TRACE(run);
    expectSound(*path, waypoints, limits, settings);
    for (const VectorXd& q : path->q) EXPECT_LE(deviation(waypoints, q), settings.blend + 1e-4);
    worst_stretch = std::max(worst_stretch, stretch);
    EXPECT_LT(stretch, 1.05);
  }
  RecordProperty("worst_stretch", std::to_string(worst_stretch));
}

TEST(Timing, UsesSomeLimitNearlyAlways) {
  const TimingLimits limits = armLimits();
  Random random(3);
  for (int run = 0; run < 50; ++run) {
    std::vector<VectorXd> waypoints;
    for (int i = 0; i < 5; ++i) waypoints.push_back(random.point(limits));
    const auto path = parameterize(waypoints, limits, {});
    ASSERT_TRUE(path);
    // Time-optimal motion is bang-bang: sum up the time in which a joint is within 15 % of a limit.
    double busy = 0;
    for (std::size_t i = 0; i + 1 < path->t.size(); ++i) {
      const TimedPath piece{{0, path->t[i + 1] - path->t[i]},
                            {path->q[i], path->q[i + 1]},
                            {path->qd[i], path->qd[i + 1]}};
      const LimitUse use = limitUse(piece, limits);
      if (use.velocity > 0.85 || use.acceleration > 0.85) busy += piece.duration();
    }
    EXPECT_GT(busy, 0.9 * path->duration()) << run;
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
  double stretch = 0;
  const auto path = parameterize(waypoints, limits, {}, &stretch);
  ASSERT_TRUE(path);
  expectSound(*path, waypoints, limits, {});
  EXPECT_LT(stretch, 1.05);
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
  EXPECT_LE(path->duration(), 1.02 * (4.0 + 0.5));
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
  EXPECT_NEAR(path->duration(), 2.5 + 1.5, 0.02 * 4);
  for (const VectorXd& q : path->q) EXPECT_LE(deviation(waypoints, q), 1e-9);
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
    ASSERT_EQ(path->t, (std::vector<double>{0, 1e-3}));
    EXPECT_EQ(path->q[0], q);
    EXPECT_EQ(path->q[1], q);
    EXPECT_EQ(path->qd[0].norm() + path->qd[1].norm(), 0);
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
  const TimedPath slower = slowed(*full, 0.25);
  for (double x : {0.0, 0.1, 0.37, 0.9, 1.0}) {
    const double t = x * full->duration();
    EXPECT_LT((evaluate(*full, t) - evaluate(slower, 4 * t)).norm(), 1e-9);
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

TEST(Timing, EvaluatesTheHermiteCurve) {
  const TimingLimits limits = armLimits();
  Random random(13);
  std::vector<VectorXd> waypoints;
  for (int i = 0; i < 5; ++i) waypoints.push_back(random.point(limits));
  const auto path = parameterize(waypoints, limits, {});
  ASSERT_TRUE(path);
  EXPECT_EQ(evaluate(*path, -1), path->q.front());
  EXPECT_EQ(evaluate(*path, path->duration() + 1), path->q.back());
  VectorXd q, qd;
  for (std::size_t i = 0; i + 1 < path->t.size(); ++i) {
    for (double x : {0.0, 0.25, 0.8}) {
      const double t = path->t[i] + x * (path->t[i + 1] - path->t[i]);
      evaluate(*path, t, q, qd);
      EXPECT_LT((q - hermite(*path, i, x)).norm(), 1e-12);
      EXPECT_LT((evaluate(*path, t) - q).norm(), 1e-15);
      if (x > 0) {
        const double e = 1e-6;
        EXPECT_LT(((evaluate(*path, t + e) - evaluate(*path, t - e)) / (2 * e) - qd).norm(), 1e-5);
      }
    }
  }
}

TEST(Timing, FindsExtremesBetweenSamples) {
  // One joint from 0 to 0 with speeds 1 and -1 in 1 s: q = t - t^2, top 0.25, |qdd| = 2, |qd| = 1.
  TimedPath path{
      {0, 1}, {VectorXd::Zero(1), VectorXd::Zero(1)}, {VectorXd::Ones(1), -VectorXd::Ones(1)}};
  TimingLimits limits = uniformLimits(1, 0.2, 0.5, 0.5);
  EXPECT_NEAR(limitUse(path, limits).velocity, 2, 1e-12);
  EXPECT_NEAR(limitUse(path, limits).acceleration, 4, 1e-12);
  EXPECT_NEAR(positionExcess(path, limits), 0.05, 1e-12);
  // From rest to rest, 1 in 1 s: the speed peaks at 1.5 in the middle, the acceleration at 6 at the
  // ends.
  path = {{0, 1}, {VectorXd::Zero(1), VectorXd::Ones(1)}, {VectorXd::Zero(1), VectorXd::Zero(1)}};
  limits = uniformLimits(1, 1, 1, 1);
  EXPECT_NEAR(limitUse(path, limits).velocity, 1.5, 1e-12);
  EXPECT_NEAR(limitUse(path, limits).acceleration, 6, 1e-12);
  EXPECT_NEAR(positionExcess(path, limits), 0, 1e-15);
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
}  // namespace handover
