// SPDX-License-Identifier: Apache-2.0
#include "core/motion/least_time.hpp"

#include "timing_cases.hpp"

namespace handover::test {
namespace {

TEST(LeastTime, OfARestToRestMotionIsTheTrapezoids) {
  EXPECT_NEAR(leastTime(0.4, 0, 0, 1, 0.4), 2.0, 1e-12);       // 2 sqrt(d / a)
  EXPECT_NEAR(leastTime(-4, 0, 0, 1, 0.4), 4.0 + 2.5, 1e-12);  // d / v + v / a
  EXPECT_NEAR(leastTime(0, 0, 0, 1, 0.4), 0, 1e-12);
  EXPECT_NEAR(leastTime(0, 0.5, -0.5, 1, 0.5), 2.0, 1e-12);  // out and back
  EXPECT_NEAR(leastTime(1, 1, 1, 1, 0.5), 1.0, 1e-12);       // at full speed all the way
}

/// By a search over all motions of two accelerations, full either way, and a coast in between.
double leastBySearch(double way, double v, double v_to, double most_v, double a) {
  double least = std::numeric_limits<double>::infinity();
  for (const double side : {1.0, -1.0}) {
    for (int i = 0; i <= 20'000; ++i) {
      const double peak = side * most_v * i / 10'000 - side * most_v;
      const double up = (peak - v) / (side * a), down = (peak - v_to) / (side * a);
      if (up < 0 || down < 0) continue;
      const double left = way - 0.5 * (v + peak) * up - 0.5 * (peak + v_to) * down;
      if (std::abs(peak) < 1e-9 ? std::abs(left) > 1e-4 : left / peak < 0) continue;
      least = std::min(least, up + down + (std::abs(peak) < 1e-9 ? 0 : left / peak));
    }
  }
  return least;
}

TEST(LeastTime, IsThatOfASearchOverPeakSpeeds) {
  Random random(3);
  for (int run = 0; run < 100; ++run) {
    const double way = random.uniform(-3, 3), v = random.uniform(-0.9, 0.9);
    const double v_to = random.uniform(-0.9, 0.9);
    const double found = leastTime(way, v, v_to, 1, 0.5);
    const double searched = leastBySearch(way, v, v_to, 1, 0.5);
    EXPECT_LE(found, searched + 1e-9) << way << " " << v << " " << v_to;
    EXPECT_GE(found, searched - 0.02) << way << " " << v << " " << v_to;
  }
}

MotionState randomState(Random& random, const TimingLimits& limits, double speed) {
  MotionState state{random.point(limits), VectorXd(limits.lower.size())};
  for (int j = 0; j < state.qd.size(); ++j) {
    state.qd[j] = speed * random.uniform(-limits.velocity[j], limits.velocity[j]);
  }
  return state;
}

TEST(LeastTimeMotion, GoesFromStateToStateWithinLimits) {
  const TimingLimits limits = armLimits();
  Random random(5);
  int found = 0;
  for (int run = 0; run < 300; ++run) {
    SCOPED_TRACE(run);
    const double speed = run % 3 == 0 ? 0 : 0.3;
    const MotionState from = randomState(random, limits, speed);
    const MotionState to = randomState(random, limits, speed);
    const auto motion = LeastTimeMotion::between(from, to, limits);
    if (!motion) continue;
    ++found;
    EXPECT_GE(motion->duration(), leastTime(from, to, limits) - 1e-9);
    if (speed == 0) {
      EXPECT_LE(motion->duration(), 1.011 * leastTime(from, to, limits));
    }
    constexpr int kSteps = 400;
    const double step = motion->duration() / kSteps;
    VectorXd before(7), at(7), after(7);
    motion->at(0, before);
    EXPECT_LE((before - from.q).cwiseAbs().maxCoeff(), 1e-9);
    motion->at(step, at);
    EXPECT_LE(((at - before) / step - from.qd).cwiseAbs().maxCoeff(), 0.4 * step);
    for (int k = 2; k <= kSteps; ++k) {
      motion->at(k * step, after);
      EXPECT_LE(share(after - at, limits.velocity * step), 1 + 1e-6);
      EXPECT_LE(share(after - 2 * at + before, limits.acceleration * step * step), 1 + 1e-4);
      EXPECT_LE((after - limits.upper).maxCoeff(), 1e-6);
      EXPECT_LE((limits.lower - after).maxCoeff(), 1e-6);
      before = at;
      at = after;
    }
    EXPECT_LE((after - to.q).cwiseAbs().maxCoeff(), 1e-7);
    EXPECT_LE(((after - before) / step - to.qd).cwiseAbs().maxCoeff(), 0.4 * step + 1e-9);
  }
  EXPECT_GT(found, 200);
}

TEST(LeastTimeMotion, TakesLongerWhereItIsAsked) {
  const TimingLimits limits = armLimits(2);
  const MotionState from{VectorXd::Zero(2), VectorXd::Zero(2)};
  const MotionState to{VectorXd::Constant(2, 0.3), VectorXd::Zero(2)};
  const auto motion = LeastTimeMotion::between(from, to, limits, 5);
  ASSERT_TRUE(motion);
  EXPECT_DOUBLE_EQ(motion->duration(), 5);
}

TEST(LeastTimeMotion, IsNoneWhereAJointCannotTurnBackInTime) {
  const TimingLimits limits = armLimits(1);
  const MotionState from{limits.upper, VectorXd::Constant(1, 0.5)};  // at its limit, on its way out
  const MotionState to{VectorXd::Zero(1), VectorXd::Zero(1)};
  EXPECT_FALSE(LeastTimeMotion::between(from, to, limits));
}

}  // namespace
}  // namespace handover::test
