// SPDX-License-Identifier: Apache-2.0
#include "verify/hermite.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace handover::verify {
namespace {

TEST(HermiteCubic, MeetsItsEnds) {
  const HermiteCubic cubic(0.5, 1, -2, 3, 0.25);
  EXPECT_DOUBLE_EQ(cubic.position(0), 1);
  EXPECT_DOUBLE_EQ(cubic.velocity(0), -2);
  EXPECT_NEAR(cubic.position(0.5), 3, 1e-12);
  EXPECT_NEAR(cubic.velocity(0.5), 0.25, 1e-12);
}

TEST(HermiteCubic, ExtremesBoundADenseSampling) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> value(-2, 2);
  for (int i = 0; i < 2000; ++i) {
    const double h = 0.05 + std::abs(value(random));
    const HermiteCubic cubic(h, value(random), value(random), value(random), value(random));
    const auto range = [&](const auto& of, const std::vector<double>& at) {
      double low = 1e9, high = -1e9;
      for (const double s : at) {
        low = std::min(low, of(s));
        high = std::max(high, of(s));
      }
      return std::pair(low, high);
    };
    std::vector<double> dense;
    for (int k = 0; k <= 1000; ++k) dense.push_back(h * k / 1000);
    const auto position = [&](double s) { return cubic.position(s); };
    const auto velocity = [&](double s) { return cubic.velocity(s); };
    const auto acceleration = [&](double s) { return cubic.acceleration(s); };
    const auto expectSame = [&](const auto& of, const std::vector<double>& at, double tolerance) {
      const auto [low, high] = range(of, at);
      const auto [dense_low, dense_high] = range(of, dense);
      EXPECT_NEAR(low, dense_low, tolerance);
      EXPECT_NEAR(high, dense_high, tolerance);
      EXPECT_LE(low, dense_low + 1e-9);
      EXPECT_GE(high, dense_high - 1e-9);
    };
    expectSame(position, cubic.positionExtremes(), 1e-3);
    expectSame(velocity, cubic.velocityExtremes(), 1e-2);
    expectSame(acceleration, cubic.accelerationExtremes(), 1e-9);
  }
}

TEST(HermiteCubic, KnowsAStraightLine) {
  const HermiteCubic line(2, 1, 0.5, 2, 0.5);
  EXPECT_EQ(line.velocityExtremes().size(), 2u);
  EXPECT_NEAR(line.topSpeed(), 0.5, 1e-12);
}

}  // namespace
}  // namespace handover::verify
