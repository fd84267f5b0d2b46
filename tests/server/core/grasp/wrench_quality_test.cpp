// SPDX-License-Identifier: Apache-2.0
#include "core/grasp/wrench_quality.hpp"

#include <gtest/gtest.h>

#include <cmath>

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
  EXPECT_GE(largestBall(wrenches), exact - 1e-9);
  EXPECT_LE(largestBall(wrenches), 1.02 * exact);
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
  EXPECT_GE(largestBall(wrenches), exact - 1e-9);
  EXPECT_LE(largestBall(wrenches), 1.02 * exact);
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
  EXPECT_GE(largestBall(wrenches), 1.0 / 6 - 1e-9);
  EXPECT_LE(largestBall(wrenches), 1.02 / 6);
}

TEST(WrenchQuality, TwoOpposedSoftFingersHold) {
  EXPECT_GT(quality({{{0.03, 0, 0}, {1, 0, 0}}, {{-0.03, 0, 0}, {-1, 0, 0}}}), 0.01);
}

TEST(WrenchQuality, TwoOpposedPointFingersCannotStopTheTurnAboutTheirLine) {
  EXPECT_LT(quality({{{0.03, 0, 0}, {1, 0, 0}}, {{-0.03, 0, 0}, {-1, 0, 0}}}, {0.6, 0.0}), 1e-9);
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

TEST(WrenchQuality, DoesNotDependOnTheFrame) {
  const std::vector<ContactPoint> contacts{{{0.03, 0.02, 0}, {1, 0, 0}},
                                           {{0.03, -0.02, 0.01}, {1, 0, 0}},
                                           {{-0.03, 0, 0}, {-1, 0, 0}},
                                           {{0, 0, 0.04}, {0, 0, 1}}};
  Eigen::Matrix3d R;
  R << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  std::vector<ContactPoint> turned;
  for (const ContactPoint& c : contacts) turned.push_back({R * c.p, R * c.n});
  EXPECT_NEAR(quality(contacts), quality(turned), 0.05 * quality(contacts));
}

}  // namespace
}  // namespace handover
