// SPDX-License-Identifier: Apache-2.0
// Where a cup holds, against what is known of simple bodies.
#include "core/grasp/grasp_set.hpp"
#include "test_hands.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace handover {
namespace {

using Eigen::Vector3d;

constexpr double kRadius = 0.015;

GraspSet graspsOf(const SceneObject& object, const RobotModel& model = suctionGripper(kRadius)) {
  const auto set = generateGrasps(object, model, ArmId(0), GraspParams{}, nullptr, Deadline());
  EXPECT_TRUE(set) << set.error().detail;
  return set ? *set : GraspSet{};
}

SceneObject parts(const std::vector<std::pair<Vector3d, Vector3d>>& boxes) {
  std::vector<Shape> shapes;
  for (const auto& [middle, size] : boxes) {
    Shape shape;
    shape.X_BS.translation() = middle;
    shape.geometry = BoxShape{size};
    shapes.push_back(shape);
  }
  return objectOf("parts", std::move(shapes));
}

Vector3d approachOf(const Grasp& grasp) { return grasp.X_OT.linear().col(2); }

/// The face of a box that a grasp is on: +-1, +-2, +-3 for x, y, z; 0: none.
int faceOf(const Grasp& grasp) {
  for (int axis = 0; axis < 3; ++axis) {
    const double along = -approachOf(grasp)[axis];
    if (std::abs(along) > std::cos(1e-6)) return along > 0 ? axis + 1 : -axis - 1;
  }
  return 0;
}

TEST(SuctionGrasps, OfABoxAreOnAllSixFacesFarEnoughFromTheEdges) {
  const Vector3d half(0.03, 0.035, 0.025);
  const GraspSet set = graspsOf(boxObject(2 * half));
  std::set<int> faces;
  for (const Grasp& grasp : set.grasps) {
    const int face = faceOf(grasp);
    ASSERT_NE(face, 0);
    faces.insert(face);
    const int axis = std::abs(face) - 1;
    const Vector3d p = grasp.X_OT.translation();
    const double above = std::abs(p[axis]) - half[axis];
    EXPECT_NEAR(above, kCupGap, 6e-5);  // this cup's lip is at the tool's origin
    for (int other = 0; other < 3; ++other) {
      if (other == axis) continue;
      EXPECT_LE(std::abs(p[other]), half[other] - kRadius + 2e-6);
    }
    ASSERT_EQ(grasp.contacts.size(), 1u);
    EXPECT_EQ(grasp.contacts[0].link, "cup");
    EXPECT_LT((grasp.contacts[0].p_O - p).norm(), 0.002);
    EXPECT_EQ(grasp.open.size(), 0);
    EXPECT_GT(grasp.quality, 0);
    EXPECT_LE(grasp.quality, 1);
  }
  EXPECT_EQ(faces.size(), 6u);
  EXPECT_TRUE(set.none_because.empty());
}

TEST(SuctionGrasps, AreBestWhereTheLineOfPullMeetsTheCentre) {
  const GraspSet set = graspsOf(boxObject({0.06, 0.06, 0.12}));
  ASSERT_FALSE(set.grasps.empty());
  const auto aside = [](const Grasp& grasp) {
    return grasp.X_OT.translation().cross(approachOf(grasp)).norm();
  };
  EXPECT_LT(aside(set.grasps.front()), 0.004);
  for (std::size_t i = 1; i < set.grasps.size(); ++i) {
    EXPECT_LE(set.grasps[i].quality, set.grasps[i - 1].quality);
    EXPECT_GE(aside(set.grasps[i]), aside(set.grasps[i - 1]) - 1e-4);
    EXPECT_LT(aside(set.grasps[i]), 2 * kRadius);  // of a flat patch nothing else counts
  }
}

TEST(SuctionGrasps, ComeInFourRolls) {
  const GraspSet set = graspsOf(boxObject({0.06, 0.06, 0.06}));
  std::set<std::pair<int, int>> rolls;
  for (const Grasp& grasp : set.grasps) {
    const Vector3d side = grasp.X_OT.linear().col(0);
    int axis = 0;
    const double along = side.cwiseAbs().maxCoeff(&axis);
    EXPECT_GT(along, 1 - 1e-6);
    rolls.insert({faceOf(grasp), side[axis] > 0 ? axis + 1 : -axis - 1});
  }
  EXPECT_EQ(rolls.size(), 24u);
}

TEST(SuctionGrasps, OfASmallSphereAreNoneAndTheSetSaysWhy) {
  const GraspSet set = graspsOf(sphereObject(0.02));
  EXPECT_TRUE(set.grasps.empty());
  EXPECT_THAT(set.none_because, testing::HasSubstr("a cup of radius 15 mm seals at none of"));
  EXPECT_THAT(set.none_because, testing::HasSubstr("bends by more than 1.5 mm"));
}

TEST(SuctionGrasps, OfABodyWhoseFlatPatchesAreFarFromItsCentreAreNone) {
  // A ball of 80 mm at a bar with a flat foot, 70 mm beside the centre.
  SceneObject spoon = parts({{{0.07, 0, 0}, {0.05, 0.05, 0.002}},  // the foot
                             {{0.04, 0, 0}, {0.04, 0.002, 0.002}}});
  spoon.shapes.push_back(sphereObject(0.04).shapes.front());
  const GraspSet set = graspsOf(spoon);
  EXPECT_TRUE(set.grasps.empty());
  EXPECT_THAT(set.none_because, testing::HasSubstr("more than 30 mm off the line of pull"));
}

TEST(SuctionGrasps, OfALargeSphereHoldUpToATenthOfTheRadius) {
  // The surface leaves the lip's plane by R - sqrt(R^2 - r^2): a tenth of r at R = 5.05 r.
  EXPECT_TRUE(graspsOf(sphereObject(4.8 * kRadius)).grasps.empty());
  const double R = 6 * kRadius;
  const GraspSet set = graspsOf(sphereObject(R));
  ASSERT_FALSE(set.grasps.empty());
  const double bend = (R - std::sqrt(R * R - kRadius * kRadius)) / (0.1 * kRadius);
  for (const Grasp& grasp : set.grasps) {
    const Vector3d p = grasp.X_OT.translation();
    EXPECT_NEAR(p.norm(), R + kCupGap, 1e-4);
    EXPECT_LT(p.normalized().dot(approachOf(grasp)), -std::cos(0.01));
    EXPECT_NEAR(grasp.quality, 1 - 0.5 * bend, 0.05);
  }
}

TEST(SuctionGrasps, OfABoxWithAHoleKeepOffIt) {
  // A plate of 120 x 120 x 20 mm round a square hole of 20 mm.
  const GraspSet set = graspsOf(parts({{{0.035, 0, 0}, {0.05, 0.12, 0.02}},
                                       {{-0.035, 0, 0}, {0.05, 0.12, 0.02}},
                                       {{0, 0.035, 0}, {0.02, 0.05, 0.02}},
                                       {{0, -0.035, 0}, {0.02, 0.05, 0.02}}}));
  ASSERT_FALSE(set.grasps.empty());
  for (const Grasp& grasp : set.grasps) {
    const Vector3d p = grasp.X_OT.translation();
    EXPECT_EQ(std::abs(faceOf(grasp)), 3);  // the hole's own walls are in the way of each other
    const Vector3d off(std::max(0.0, std::abs(p.x()) - 0.01), std::max(0.0, std::abs(p.y()) - 0.01),
                       0);
    EXPECT_GE(off.norm(), kRadius - 0.0012);  // a corner may reach in between two looks
  }
}

TEST(SuctionGrasps, OfAHoleSmallerThanTheCupAreNoneAboveIt) {
  // A hole of 8 mm: wherever it is below the seal, not only below the rim, air comes through.
  const GraspSet set = graspsOf(parts({{{0.022, 0, 0}, {0.036, 0.08, 0.02}},
                                       {{-0.022, 0, 0}, {0.036, 0.08, 0.02}},
                                       {{0, 0.022, 0}, {0.008, 0.036, 0.02}},
                                       {{0, -0.022, 0}, {0.008, 0.036, 0.02}}}));
  ASSERT_FALSE(set.grasps.empty());
  for (const Grasp& grasp : set.grasps) {
    const Vector3d p = grasp.X_OT.translation();
    if (std::abs(faceOf(grasp)) != 3) continue;
    const Vector3d off(std::max(0.0, std::abs(p.x()) - 0.004),
                       std::max(0.0, std::abs(p.y()) - 0.004), 0);
    EXPECT_GE(off.norm(), kRadius - 0.002);
  }
}

TEST(SuctionGrasps, OfAThinPlateAreNearTheMiddleOfBothSides) {
  const GraspSet set = graspsOf(parts({{{0, 0, 0}, {0.2, 0.2, 0.002}}}));
  std::set<int> faces;
  for (const Grasp& grasp : set.grasps) {
    faces.insert(faceOf(grasp));
    EXPECT_LT(grasp.X_OT.translation().head<2>().norm(), 2 * kRadius);
  }
  EXPECT_EQ(faces, (std::set<int>{-3, 3}));
}

TEST(SuctionGrasps, DoNotMindASeamBetweenParts) {
  const GraspSet set =
      graspsOf(parts({{{0.02, 0, 0}, {0.04, 0.08, 0.04}}, {{-0.02, 0, 0}, {0.04, 0.08, 0.04}}}));
  const auto over_seam = std::count_if(set.grasps.begin(), set.grasps.end(), [](const Grasp& it) {
    return std::abs(it.X_OT.translation().x()) < 0.005;
  });
  EXPECT_GT(over_seam, 20);
}

TEST(SuctionGrasps, KeepTheRestOfTheHandOffTheObject) {
  // In a trough 40 mm deep and 50 mm wide the cup would seal, but the body behind it does not fit.
  const SceneObject trough = parts({{{0, 0, -0.01}, {0.05, 0.2, 0.02}},
                                    {{0.035, 0, 0.01}, {0.02, 0.2, 0.06}},
                                    {{-0.035, 0, 0.01}, {0.02, 0.2, 0.06}}});
  const GraspSet set = graspsOf(trough);
  ASSERT_FALSE(set.grasps.empty());
  for (const Grasp& grasp : set.grasps) {
    const bool inside = grasp.X_OT.translation().z() > 0 && faceOf(grasp) == 3 &&
                        std::abs(grasp.X_OT.translation().x()) < 0.025;
    EXPECT_FALSE(inside);
  }
}

TEST(SuctionGrasps, NeedACupThatEndsAtTheToolsOrigin) {
  RobotModel model = suctionGripper(kRadius);
  Joint& tool = model.joints.back();
  tool.X_PJ.translation().z() -= 0.0005;  // the lip is 0.5 mm ahead: within the contract's 2 mm
  const GraspSet near = graspsOf(boxObject({0.06, 0.06, 0.06}), model);
  ASSERT_FALSE(near.grasps.empty());
  for (const Grasp& grasp : near.grasps) {
    EXPECT_NEAR(grasp.X_OT.translation().cwiseAbs().maxCoeff(), 0.03 + kCupGap + 0.0005, 6e-5);
  }
  model.joints.back().X_PJ.translation().z() -= 0.003;
  const GraspSet far = graspsOf(boxObject({0.06, 0.06, 0.06}), model);
  EXPECT_TRUE(far.grasps.empty());
  EXPECT_THAT(far.none_because, testing::HasSubstr("the hand is in the way"));
}

TEST(SuctionGrasps, AreTheSameTwice) {
  const GraspSet first = graspsOf(cylinderObject(0.09, 0.05));
  const GraspSet again = graspsOf(cylinderObject(0.09, 0.05));
  ASSERT_EQ(first.grasps.size(), again.grasps.size());
  ASSERT_FALSE(first.grasps.empty());
  for (std::size_t i = 0; i < first.grasps.size(); ++i) {
    EXPECT_EQ(first.grasps[i].X_OT.matrix(), again.grasps[i].X_OT.matrix());
  }
}

}  // namespace
}  // namespace handover
