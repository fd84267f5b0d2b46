// SPDX-License-Identifier: Apache-2.0
#include "verify/body.hpp"

#include <gtest/gtest.h>

#include <random>

namespace handover::verify {
namespace {

Body make(const Geometry& geometry) {
  return Body({{Pose::Identity(), geometry}}, [](const MeshFile&) { return std::vector<Mesh>(); });
}

Pose at(double x, double y, double z) {
  Pose X = Pose::Identity();
  X.translation() = Eigen::Vector3d(x, y, z);
  return X;
}

constexpr double kFar = 10;

TEST(Clearance, OfBoxesIsExact) {
  const Body a = make(Box{{1, 1, 1}});
  const Body b = make(Box{{1, 2, 3}});
  const Clearance gap = clearance(a, at(0, 0, 0), b, at(1.25, 0.3, 0.1), kFar);
  EXPECT_FALSE(gap.touching);
  EXPECT_NEAR(gap.distance, 0.25, 1e-12);
  EXPECT_TRUE(clearance(a, at(0, 0, 0), b, at(0.999, 0, 0), kFar).touching);
  EXPECT_FALSE(clearance(a, at(0, 0, 0), b, at(1.001, 0, 0), kFar).touching);
}

TEST(Clearance, OfTurnedBoxesIsExact) {
  const Body a = make(Box{{1, 1, 1}});
  Pose X = at(2, 0, 0);
  X.linear() = Eigen::AngleAxisd(M_PI / 4, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Clearance gap = clearance(a, at(0, 0, 0), a, X, kFar);
  EXPECT_NEAR(gap.distance, 2 - 0.5 - std::sqrt(0.5), 1e-9);
}

TEST(Clearance, IsALowerBoundBeyondNear) {
  const Body a = make(Box{{1, 1, 1}});
  const Clearance gap = clearance(a, at(0, 0, 0), a, at(3, 3, 0), 0.1);
  EXPECT_FALSE(gap.touching);
  EXPECT_GE(gap.distance, 0.1);
  EXPECT_LE(gap.distance, 2 * std::sqrt(2.0) + 1e-9);
}

TEST(Clearance, OfCurvedShapesIsALittleLess) {
  const Body sphere = make(Sphere{0.5});
  const Body cylinder = make(Cylinder{0.5, 1});
  for (const Body* other : {&sphere, &cylinder}) {
    const Clearance gap = clearance(sphere, at(0, 0, 0), *other, at(1.2, 0, 0), kFar);
    EXPECT_FALSE(gap.touching);
    EXPECT_LE(gap.distance, 0.2 + 1e-9);
    EXPECT_GE(gap.distance, 0.2 - 0.008);
  }
}

TEST(Clearance, DecidesContactOfCurvedShapesByTheTrueShape) {
  const Body sphere = make(Sphere{0.5});
  const Body cylinder = make(Cylinder{0.5, 1});
  const Body box = make(Box{{1, 1, 1}});
  for (const Body* other : {&sphere, &cylinder, &box}) {
    for (const auto& [d, touches] : {std::pair(1.0005, false), std::pair(0.9995, true)}) {
      // Turned so that no corner of the enclosing triangles lies on the line between them.
      Pose X = at(0, 0, 0);
      X.linear() = Eigen::AngleAxisd(0.03, Eigen::Vector3d::UnitX()).toRotationMatrix();
      EXPECT_EQ(clearance(sphere, X, *other, at(d, 0, 0), kFar).touching, touches) << d;
      EXPECT_EQ(clearance(*other, at(d, 0, 0), sphere, X, kFar).touching, touches) << d;
    }
  }
}

TEST(Clearance, SeesABodyInsideAnother) {
  const Body small = make(Box{{0.1, 0.1, 0.1}});
  const Body ball = make(Sphere{0.05});
  for (const Geometry& geometry :
       std::vector<Geometry>{Box{{1, 1, 1}}, Sphere{0.6}, Cylinder{0.6, 1}}) {
    const Body large = make(geometry);
    for (const Body* inner : {&small, &ball}) {
      EXPECT_TRUE(clearance(*inner, at(0.1, 0.2, 0.1), large, at(0, 0, 0), kFar).touching);
      EXPECT_TRUE(clearance(large, at(0, 0, 0), *inner, at(0.1, 0.2, 0.1), kFar).touching);
      EXPECT_FALSE(clearance(*inner, at(0.1, 0.2, 0.9), large, at(0, 0, 0), kFar).touching);
    }
  }
}

TEST(Clearance, LeavesTheHollowOfACupFree) {
  // Five walls of a box that is open above.
  const auto wall = [](double x, double y, double z, double sx, double sy, double sz) {
    return PlacedGeometry{at(x, y, z), Box{{sx, sy, sz}}};
  };
  const Body cup = make(Compound{{wall(0, 0, -0.5, 1, 1, 0.02), wall(0.5, 0, 0, 0.02, 1, 1),
                                  wall(-0.5, 0, 0, 0.02, 1, 1), wall(0, 0.5, 0, 1, 0.02, 1),
                                  wall(0, -0.5, 0, 1, 0.02, 1)}});
  const Body ball = make(Sphere{0.2});
  const Clearance gap = clearance(ball, at(0, 0, 0), cup, at(0, 0, 0), kFar);
  EXPECT_FALSE(gap.touching);
  EXPECT_NEAR(gap.distance, 0.29, 2e-3);
  EXPECT_TRUE(clearance(ball, at(0, 0, -0.3), cup, at(0, 0, 0), kFar).touching);
}

TEST(Clearance, ShrinksNoFasterThanTheBodiesMove) {
  // What the advancement along the motion rests on.
  const Body a =
      make(Compound{{{at(0.1, 0, 0), Box{{0.3, 0.1, 0.2}}}, {at(0, 0.2, 0), Cylinder{0.05, 0.3}}}});
  const Body b = make(Box{{0.2, 0.2, 0.4}});
  std::mt19937 random(3);
  std::uniform_real_distribution<double> value(-1, 1);
  for (int i = 0; i < 500; ++i) {
    Pose X = at(0.5 * value(random), 0.5 * value(random), 0.5 * value(random));
    X.linear() = Eigen::Quaterniond(value(random), value(random), value(random), value(random))
                     .normalized()
                     .toRotationMatrix();
    const double before = clearance(a, at(0, 0, 0), b, X, kFar).distance;
    const Eigen::Vector3d step =
        0.02 * Eigen::Vector3d(value(random), value(random), value(random));
    X.translation() += step;
    const Clearance after = clearance(a, at(0, 0, 0), b, X, kFar);
    EXPECT_GE(after.distance, before - step.norm() - 1e-9);
    EXPECT_LE(after.distance, before + step.norm() + 1e-9);
    if (after.touching) {
      EXPECT_LE(before, step.norm() + 1e-9);
    }
  }
}

}  // namespace
}  // namespace handover::verify
