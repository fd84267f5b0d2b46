// SPDX-License-Identifier: Apache-2.0
#include "core/grasp/wrench_quality.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace handover {
namespace {

using Eigen::Vector3d;

double quality(const std::vector<ContactPoint>& contacts, const ContactModel& model = {}) {
  return largestBall(contactWrenches(contacts, Vector3d::Zero(), 0.05, model));
}

TEST(WrenchQuality, OfACrossPolytopeIsItsInnerRadius) {
  std::vector<Wrench> wrenches;
  for (int i = 0; i < 6; ++i) {
    wrenches.push_back(Wrench::Unit(i));
    wrenches.push_back(-Wrench::Unit(i));
  }
  const double exact = 1 / std::sqrt(6.0);
  EXPECT_LE(largestBall(wrenches, 0.99), exact + 1e-6);
  EXPECT_GE(largestBall(wrenches, 0.99), 0.99 * exact - 1e-6);
}

TEST(WrenchQuality, OfAStretchedCrossPolytopeIsItsInnerRadius) {
  std::vector<Wrench> wrenches;
  const double half[] = {1, 1, 1, 0.5, 0.5, 0.1};
  double inverse_squares = 0;
  for (int i = 0; i < 6; ++i) {
    wrenches.push_back(half[i] * Wrench::Unit(i));
    wrenches.push_back(-half[i] * Wrench::Unit(i));
    inverse_squares += 1 / (half[i] * half[i]);
  }
  const double exact = 1 / std::sqrt(inverse_squares);
  EXPECT_LE(largestBall(wrenches, 0.99), exact + 1e-6);
  EXPECT_GE(largestBall(wrenches, 0.99), 0.99 * exact - 1e-6);
}

TEST(WrenchQuality, OfASimplexIsItsInnerRadius) {
  // The regular simplex of 7 corners on the unit sphere has inner radius 1/6.
  std::vector<Wrench> wrenches;
  for (int i = 0; i < 6; ++i) {
    const Wrench w = Wrench::Unit(i) * std::sqrt(7.0 / 6.0) +
                     Wrench::Constant((1 - std::sqrt(7.0)) / (6 * std::sqrt(6.0)));
    wrenches.push_back(w);
  }
  wrenches.push_back(Wrench::Constant(-1 / std::sqrt(6.0)));
  for (const Wrench& w : wrenches) ASSERT_NEAR(w.norm(), 1.0, 1e-9);
  EXPECT_NEAR(largestBall(wrenches, 0.99), 1.0 / 6, 1e-6);  // its first polytope is the hull
}

TEST(WrenchQuality, TwoOpposedSoftFingersHold) {
  EXPECT_GT(quality({{{0.03, 0, 0}, {1, 0, 0}}, {{-0.03, 0, 0}, {-1, 0, 0}}}), 0.01);
}

TEST(WrenchQuality, TwoOpposedPointFingersCannotStopTheTurnAboutTheirLine) {
  EXPECT_LT(quality({{{0.03, 0, 0}, {1, 0, 0}}, {{-0.03, 0, 0}, {-1, 0, 0}}}, {0.6, 0.0}), 1e-6);
}

TEST(WrenchQuality, FingersOnOneSideDoNotHold) {
  EXPECT_LE(
      quality(
          {{{0.03, 0, 0}, {1, 0, 0}}, {{0.03, 0.02, 0}, {1, 0, 0}}, {{0.03, 0, 0.02}, {1, 0, 0}}}),
      1e-9);
}

TEST(WrenchQuality, AThirdFingerAndMoreFrictionHelp) {
  const std::vector<ContactPoint> two{{{0.03, 0, 0}, {1, 0, 0}}, {{-0.03, 0, 0}, {-1, 0, 0}}};
  const std::vector<ContactPoint> three{
      {{0.03, 0.02, 0}, {1, 0, 0}}, {{0.03, -0.02, 0}, {1, 0, 0}}, two[1]};
  EXPECT_GT(quality(three), quality(two));
  EXPECT_GT(quality(three, {0.9, 0.005}), quality(three, {0.6, 0.005}));
}

TEST(WrenchQuality, IsNeverAboveTheSupportInAnyDirection) {
  // Random contacts on a thin bar, as on a hammer's handle: the hull's support bounds the ball from
  // above.
  std::mt19937_64 generator(7);
  std::uniform_real_distribution<double> along(-0.15, 0.15);
  std::normal_distribution<double> normal;
  int holding = 0;
  for (int set = 0; set < 20; ++set) {
    std::vector<ContactPoint> contacts;
    for (int k = 0; k < 5; ++k) {
      const double side = k % 2 == 0 ? 1 : -1;
      contacts.push_back({{0.01 * side, 0, along(generator)}, {side, 0, 0}});
    }
    const std::vector<Wrench> wrenches = contactWrenches(contacts, Vector3d::Zero(), 0.15, {});
    const double ball = largestBall(wrenches);
    if (ball > 0) ++holding;  // not where all of one side lie to one end of the other's
    for (int k = 0; k < 20000; ++k) {
      Wrench u;
      for (int i = 0; i < 6; ++i) u[i] = normal(generator);
      double support = 0;
      for (const Wrench& w : wrenches) support = std::max(support, w.dot(u) / u.norm());
      ASSERT_GE(support, ball - 1e-6);
    }
  }
  EXPECT_GE(holding, 10);
}

TEST(WrenchQuality, DoesNotDependOnTheFrame) {
  const std::vector<ContactPoint> contacts{{{0.03, 0.02, 0}, {1, 0, 0}},
                                           {{0.03, -0.02, 0.01}, {1, 0, 0}},
                                           {{-0.03, 0, 0}, {-1, 0, 0}},
                                           {{0, 0, 0.04}, {0, 0, 1}}};
  Eigen::Matrix3d R;
  R << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  std::vector<ContactPoint> turned;
  for (const ContactPoint& c : contacts) turned.push_back({R * c.p, R * c.n});
  EXPECT_NEAR(quality(contacts), quality(turned), 0.1 * quality(contacts));
}

}  // namespace
}  // namespace handover
