// SPDX-License-Identifier: Apache-2.0
#include "verify/hermite.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

namespace handover::verify {
namespace {

TEST(HermiteQuintic, MeetsItsEnds) {
  const HermiteQuintic curve(0.5, {1, -2, 3}, {3, 0.25, -1});
  EXPECT_DOUBLE_EQ(curve.position(0), 1);
  EXPECT_DOUBLE_EQ(curve.velocity(0), -2);
  EXPECT_NEAR(curve.position(0.5), 3, 1e-12);
  EXPECT_NEAR(curve.velocity(0.5), 0.25, 1e-12);
  const Bernstein<3> qdd = curve.change().derivative().derivative();
  EXPECT_NEAR(qdd.part(0, 1e-6).upperBound(), 3, 1e-2);
  EXPECT_NEAR(qdd.part(0.5 - 1e-6, 0.5).lowerBound(), -1, 1e-2);
}

TEST(HermiteQuintic, FromRestToRestIsTheKnownPolynomial) {
  const double T = 1.7, d = 0.9;
  const HermiteQuintic curve(T, {0.1, 0, 0}, {0.1 + d, 0, 0});
  for (int k = 0; k <= 20; ++k) {
    const double u = k / 20.0;
    EXPECT_NEAR(curve.position(u * T), 0.1 + d * u * u * u * (10 + u * (-15 + 6 * u)), 1e-12);
  }
  const Bernstein<4> qd = curve.change().derivative();
  const Bernstein<3> qdd = qd.derivative();
  EXPECT_NEAR(qd.greatest(1e-12, 0).value, 1.875 * d / T, 1e-9);
  EXPECT_NEAR(qd.greatest(1e-12, 0).at, T / 2, 1e-4);
  EXPECT_NEAR(qdd.greatest(1e-12, 0).value, 10 / std::sqrt(3.0) * d / T / T, 1e-9);
  EXPECT_NEAR(qdd.derivative().greatest(1e-12, 0).value, 60 * d / T / T / T, 1e-9);
}

/// Values of f at many points of [0, h].
std::pair<double, double> range(double h, const std::function<double(double)>& f) {
  double low = 1e9, high = -1e9;
  for (int k = 0; k <= 2000; ++k) {
    low = std::min(low, f(h * k / 2000));
    high = std::max(high, f(h * k / 2000));
  }
  return {low, high};
}

TEST(HermiteQuintic, ExtremesBoundADenseSampling) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> value(-2, 2);
  for (int i = 0; i < 1000; ++i) {
    const double h = 0.05 + std::abs(value(random));
    const HermiteQuintic curve(h, {value(random), value(random), value(random)},
                               {value(random), value(random), value(random)});
    const auto expectSame = [&](const auto& polynomial, const std::function<double(double)>& f) {
      const auto [low, high] = range(h, f);
      const double steep = 1e-3 * (1 + polynomial.derivative().magnitude() * h);
      const double greatest = polynomial.greatest(1e-10, -1e9).value;
      const double least = -polynomial.scaled(-1).greatest(1e-10, -1e9).value;
      EXPECT_GE(greatest, high - 1e-9);
      EXPECT_LE(greatest, high + steep);
      EXPECT_LE(least, low + 1e-9);
      EXPECT_GE(least, low - steep);
      EXPECT_GE(polynomial.upperBound(), high - 1e-9);
      EXPECT_LE(polynomial.lowerBound(), low + 1e-9);
      EXPECT_GE(polynomial.magnitude(), std::max(std::abs(low), std::abs(high)) - 1e-9);
    };
    expectSame(curve.change().scaled(1, curve.first()),
               [&](double s) { return curve.position(s); });
    expectSame(curve.change().derivative(), [&](double s) { return curve.velocity(s); });
  }
}

TEST(HermiteQuintic, AMaximumThatIsSmallEnoughIsNotSought) {
  const HermiteQuintic curve(1, {0, 0, 0}, {1, 0, 0});
  const Bernstein<4> qd = curve.change().derivative();
  EXPECT_LE(qd.greatest(1e-9, 10).value, 10);
  EXPECT_NEAR(qd.greatest(1e-9, 1.8).value, 1.875, 1e-6);
}

TEST(Bernstein, PartsAreOnThePolynomial) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> value(-1, 1);
  for (int i = 0; i < 200; ++i) {
    const HermiteQuintic curve(2, {value(random), value(random), value(random)},
                               {value(random), value(random), value(random)});
    const double a = 1 + value(random) * 0.9, b = a + (2 - a) * 0.5;
    const Bernstein<5> part = curve.change().part(a, b);
    const auto [left, right] = part.split(0.3);
    const double middle = a + 0.3 * (b - a);
    EXPECT_NEAR(left.part(a, a + 1e-9).upperBound(), curve.position(a) - curve.first(), 1e-6);
    EXPECT_NEAR(right.part(middle, middle + 1e-9).upperBound(),
                curve.position(middle) - curve.first(), 1e-6);
    EXPECT_NEAR(right.part(b - 1e-9, b).upperBound(), curve.position(b) - curve.first(), 1e-6);
  }
}

TEST(HermiteQuintic, KeepsItsDigitsOverAMillisecond) {
  // Samples 1 ms apart around a large position: jerk must not drown in rounding.
  const double h = 1e-3, jerk = 4, q0 = 1234.5;
  const HermiteQuintic curve(h, {q0, 0.3, 0.2},
                             {q0 + 0.3 * h + 0.1 * h * h + jerk / 6 * h * h * h,
                              0.3 + 0.2 * h + jerk / 2 * h * h, 0.2 + jerk * h});
  EXPECT_NEAR(curve.change().derivative().derivative().derivative().magnitude(), jerk, 0.02);
}

}  // namespace
}  // namespace handover::verify
