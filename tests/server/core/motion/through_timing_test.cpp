// SPDX-License-Identifier: Apache-2.0
#include "core/motion/through_timing.hpp"

#include "timing_cases.hpp"

namespace handover::test {
namespace {

constexpr double kBlend = 0.05;

std::vector<VectorXd> lineFrom(const VectorXd& from, const VectorXd& way, int pieces) {
  std::vector<VectorXd> line;
  for (int i = 0; i <= pieces; ++i) line.emplace_back(from + way * i / pieces);
  return line;
}

/// A way to a line's begin, and the line; some waypoints before.
std::vector<MovementPart> randomApproach(Random& random, const TimingLimits& limits, int between) {
  const VectorXd begin = 0.8 * random.point(limits);
  const VectorXd way = 0.08 * random.point(limits);
  std::vector<VectorXd> free{0.8 * random.point(limits)};
  for (int i = 0; i < between; ++i) free.push_back(0.8 * random.point(limits));
  free.push_back(begin);
  return {{free, false}, {lineFrom(begin, way, 8), true}};
}

std::vector<MovementPart> reversed(std::vector<MovementPart> parts) {
  std::reverse(parts.begin(), parts.end());
  for (MovementPart& part : parts) std::reverse(part.waypoints.begin(), part.waypoints.end());
  return parts;
}

std::vector<VectorXd> endsOf(const std::vector<MovementPart>& parts) {
  return {parts.front().waypoints.front(), parts.back().waypoints.back()};
}

TEST(ThroughMovement, IsSound) {
  const TimingLimits limits = armLimits();
  Random random(41);
  for (int run = 0; run < 60; ++run) {
    SCOPED_TRACE(run);
    std::vector<MovementPart> parts = randomApproach(random, limits, run % 3);
    if (run % 2 == 1) parts = reversed(parts);
    const ThroughMovement movement(parts, std::nullopt, limits, kBlend, 1);
    if (!movement.found()) continue;
    const JoinedTiming timing = movement.timing({});
    expectSound(timing.path, endsOf(parts), limits, {});
    EXPECT_GE(timing.path.duration(), movement.duration() - 1e-9);
    EXPECT_LE(timing.path.duration(), movement.duration() + 0.35);
  }
}

TEST(ThroughMovement, KeepsToItsLineFromTheJunctionOn) {
  const TimingLimits limits = armLimits();
  Random random(42);
  int looked = 0;
  for (int run = 0; run < 40; ++run) {
    SCOPED_TRACE(run);
    const bool back = run % 2 == 1;
    const std::vector<MovementPart> parts =
        back ? reversed(randomApproach(random, limits, 1)) : randomApproach(random, limits, 1);
    const ThroughMovement movement(parts, std::nullopt, limits, kBlend, 1);
    if (!movement.found()) continue;
    const JoinedTiming timing = movement.timing({});
    ASSERT_EQ(timing.junctions.size(), 1u);
    const Junction& junction = timing.junctions.front();
    const std::vector<VectorXd>& line = (back ? parts.front() : parts.back()).waypoints;
    const double from = back ? 0 : timing.path.t[junction.last];
    const double to = back ? timing.path.t[junction.first] : timing.path.duration();
    if (to <= from) continue;
    ++looked;
    for (int k = 0; k <= 100; ++k) {
      const VectorXd q = evaluate(timing.path, from + (to - from) * k / 100);
      EXPECT_LE(deviation(line, q), 1e-6);
    }
  }
  EXPECT_GT(looked, 25);
}

TEST(ThroughMovement, PassesItsWaypoints) {
  const TimingLimits limits = armLimits(3);
  const std::vector<VectorXd> points{VectorXd::Constant(3, -1), VectorXd::Constant(3, 0),
                                     Eigen::Vector3d(1, 0.5, 1)};
  const ThroughMovement movement({{points, false}}, std::nullopt, limits, kBlend, 1);
  ASSERT_TRUE(movement.found());
  const JoinedTiming timing = movement.timing({});
  double nearest = 1;
  for (int k = 0; k <= 2000; ++k) {
    const double t = timing.path.duration() * k / 2000;
    nearest = std::min(nearest, (evaluate(timing.path, t) - points[1]).norm());
  }
  EXPECT_LT(nearest, 0.01);  // smoothing bends it by a little
  EXPECT_GT(timing.path.qd[timing.path.qd.size() / 2].norm(), 0.1);  // and does not stop there
}

TEST(ThroughMovement, MovesJointsAsideWithinTheirPart) {
  TimingLimits limits = armLimits(7);
  const std::vector<MovementPart> parts = [&] {
    Random random(43);
    return randomApproach(random, armLimits(5), 0);
  }();
  const JointsAside aside{0, VectorXd::Constant(2, -0.2), VectorXd::Constant(2, 0.1)};
  const ThroughMovement movement(parts, aside, limits, kBlend, 1);
  ASSERT_TRUE(movement.found());
  const JoinedTiming timing = movement.timing({});
  EXPECT_LE((timing.path.q.front().tail(2) - aside.from).cwiseAbs().maxCoeff(), 1e-12);
  for (std::size_t i = timing.junctions[0].last; i < timing.path.t.size(); ++i) {
    EXPECT_LE((timing.path.q[i].tail(2) - aside.to).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(ThroughMovement, IsNoneWhereAPartDoesNotMove) {
  const TimingLimits limits = armLimits(2);
  const VectorXd q = VectorXd::Zero(2);
  EXPECT_FALSE(ThroughMovement({{{q, q}, false}}, std::nullopt, limits, kBlend, 1).found());
}

TEST(ThroughMovement, TakesLongerAtAScaledSpeed) {
  const TimingLimits limits = armLimits();
  Random random(44);
  const std::vector<MovementPart> parts = randomApproach(random, limits, 1);
  const ThroughMovement movement(parts, std::nullopt, limits, kBlend, 1);
  ASSERT_TRUE(movement.found());
  TimingSettings half;
  half.speed_scale = 0.5;
  EXPECT_NEAR(movement.timing(half).path.duration(), 2 * movement.timing({}).path.duration(), 1e-3);
}

}  // namespace
}  // namespace handover::test
