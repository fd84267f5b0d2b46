// SPDX-License-Identifier: Apache-2.0
#include "core/motion/trajectory.hpp"

#include "timing_cases.hpp"

#include <stdexcept>

namespace handover::test {
namespace {

VectorXd one(double x) { return VectorXd::Constant(1, x); }

/// Any samples, at any times: quintics that no smooth motion would have.
TimedPath randomSamples(Random& random, int dof, int count) {
  TimedPath path;
  double t = 0;
  for (int i = 0; i < count; ++i) {
    path.t.push_back(t);
    t += random.uniform(0.01, 0.5);
    VectorXd q(dof), qd(dof), qdd(dof);
    for (int j = 0; j < dof; ++j) {
      q[j] = random.uniform(-1, 1);
      qd[j] = random.uniform(-2, 2);
      qdd[j] = random.uniform(-20, 20);
    }
    path.q.push_back(q);
    path.qd.push_back(qd);
    path.qdd.push_back(qdd);
  }
  return path;
}

TEST(TimedPath, IsTheQuinticHermiteCurve) {
  Random random(13);
  const TimedPath path = randomSamples(random, 3, 20);
  VectorXd q, qd, qdd;
  for (std::size_t i = 0; i + 1 < path.t.size(); ++i) {
    for (const double x : {0.0, 0.25, 0.8, 0.999999}) {
      const double t = path.t[i] + x * (path.t[i + 1] - path.t[i]);
      evaluate(path, t, q, qd, qdd);
      const State state = hermite(path, i, x);
      EXPECT_LT((q - state.q).norm(), 1e-12);
      EXPECT_LT((qd - state.qd).norm(), 1e-10);
      EXPECT_LT((qdd - state.qdd).norm(), 1e-7);
      VectorXd q_only = evaluate(path, t), q_two, qd_two;
      evaluate(path, t, q_two, qd_two);
      EXPECT_EQ(q_only, q);
      EXPECT_EQ(q_two, q);
      EXPECT_EQ(qd_two, qd);
    }
  }
}

TEST(TimedPath, EndsWithItsSamples) {
  Random random(14);
  const TimedPath path = randomSamples(random, 2, 5);
  VectorXd q, qd, qdd;
  for (const double beyond : {0.0, 1.0}) {
    evaluate(path, -beyond, q, qd, qdd);
    EXPECT_EQ(q, path.q.front());
    EXPECT_EQ(qd, path.qd.front());
    EXPECT_EQ(qdd, path.qdd.front());
    evaluate(path, path.duration() + beyond, q, qd, qdd);
    EXPECT_EQ(q, path.q.back());
    EXPECT_EQ(qd, path.qd.back());
    EXPECT_EQ(qdd, path.qdd.back());
  }
}

TEST(TimedPath, ReproducesAPolynomialOfDegreeFive) {
  const auto q = [](double t) { return 1 + t * (2 - t * (3 - t * (0.5 + t * (1.5 - 0.7 * t)))); };
  const auto qd = [](double t) { return 2 + t * (-6 + t * (1.5 + t * (6 - 3.5 * t))); };
  const auto qdd = [](double t) { return -6 + t * (3 + t * (18 - 14 * t)); };
  const TimedPath path{
      {0, 2}, {one(q(0)), one(q(2))}, {one(qd(0)), one(qd(2))}, {one(qdd(0)), one(qdd(2))}};
  for (double t = 0; t <= 2; t += 0.1) EXPECT_NEAR(evaluate(path, t)[0], q(t), 1e-13);
}

TEST(LimitUse, FindsExtremesBetweenSamples) {
  // From rest to rest, 1 in 1 s, 10 x^3 - 15 x^4 + 6 x^5: the speed peaks at 15/8 in the middle,
  // the acceleration at 10/sqrt(3), the jerk at 60 at the ends.
  TimedPath path{{0, 1}, {one(0), one(1)}, {one(0), one(0)}, {one(0), one(0)}};
  const TimingLimits limits = uniformLimits(1, 1, 1, 1);
  EXPECT_NEAR(limitUse(path, limits).velocity, 1.875, 1e-9);
  EXPECT_NEAR(limitUse(path, limits).acceleration, 10 / std::sqrt(3.0), 1e-9);
  EXPECT_NEAR(limitUse(path, limits).jerk, 6, 1e-9);
  EXPECT_NEAR(positionExcess(path, limits), 0, 1e-9);
  // t - t^2: up to 0.25 and back, the acceleration is -2 throughout.
  path = {{0, 1}, {one(0), one(0)}, {one(1), one(-1)}, {one(-2), one(-2)}};
  EXPECT_NEAR(limitUse(path, limits).velocity, 1, 1e-9);
  EXPECT_NEAR(limitUse(path, limits).acceleration, 2, 1e-9);
  EXPECT_NEAR(limitUse(path, limits).jerk, 0, 1e-9);
  EXPECT_NEAR(positionExcess(path, uniformLimits(1, 0.2, 1, 1)), 0.05, 1e-9);
}

TEST(LimitUse, IsNoLessThanAnyStateAndNoMoreThanSome) {
  Random random(15);
  for (int run = 0; run < 50; ++run) {
    const TimedPath path = randomSamples(random, 3, 2);
    const TimingLimits limits = armLimits(3);
    const LimitUse use = limitUse(path, limits);
    const double excess = positionExcess(path, limits);
    LimitUse seen;
    double seen_excess = -1e300;
    constexpr int kParts = 2000;
    for (int k = 0; k <= kParts; ++k) {
      const State state = hermite(path, 0, static_cast<double>(k) / kParts);
      seen.velocity = std::max(seen.velocity, share(state.qd, limits.velocity));
      seen.acceleration = std::max(seen.acceleration, share(state.qdd, limits.acceleration));
      seen.jerk = std::max(seen.jerk, share(state.jerk, limits.jerk));
      seen_excess = std::max(
          {seen_excess, (state.q - limits.upper).maxCoeff(), (limits.lower - state.q).maxCoeff()});
    }
    EXPECT_GE(use.velocity, seen.velocity * (1 - 1e-12));
    EXPECT_GE(use.acceleration, seen.acceleration * (1 - 1e-12));
    EXPECT_GE(use.jerk, seen.jerk * (1 - 1e-12));
    EXPECT_GE(excess, seen_excess - 1e-12);
    EXPECT_NEAR(use.velocity, seen.velocity, 1e-5 * seen.velocity);
    EXPECT_NEAR(use.acceleration, seen.acceleration, 1e-5 * seen.acceleration);
    EXPECT_NEAR(use.jerk, seen.jerk, 1e-5 * seen.jerk);
    EXPECT_NEAR(excess, seen_excess, 1e-5);
  }
}

TEST(Slice, CutsAtASampleAndJoinsAgain) {
  Random random(16);
  const TimedPath path = randomSamples(random, 4, 12);
  const TimedPath before = slice(path, 0, 5), after = slice(path, 5, 11);
  EXPECT_EQ(before.t.size(), 6u);
  EXPECT_EQ(after.t.front(), 0);
  EXPECT_EQ(before.q.back(), after.q.front());
  EXPECT_EQ(before.qd.back(), after.qd.front());
  EXPECT_EQ(before.qdd.back(), after.qdd.front());
  EXPECT_NEAR(before.duration() + after.duration(), path.duration(), 1e-12);
  for (double t = 0; t <= after.duration(); t += 0.05) {
    EXPECT_LT((evaluate(after, t) - evaluate(path, path.t[5] + t)).norm(), 1e-10);
  }
  TimedPath joined = before;
  append(joined, after);
  EXPECT_EQ(joined.q, path.q);
  EXPECT_EQ(joined.qdd, path.qdd);
  for (std::size_t i = 0; i < path.t.size(); ++i) EXPECT_NEAR(joined.t[i], path.t[i], 1e-12);
  EXPECT_THROW(slice(path, 5, 5), std::invalid_argument);
  EXPECT_THROW(slice(path, 5, 12), std::invalid_argument);
}

}  // namespace
}  // namespace handover::test
