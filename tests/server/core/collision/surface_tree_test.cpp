// SPDX-License-Identifier: Apache-2.0
// Surfaces of triangles, against the convex shapes that they bound.
#include "core/collision/surface_tree.hpp"

#include "core/collision/narrow_phase.hpp"
#include "support/meshes.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace handover {
namespace {

using Eigen::Vector3d;

/// A body that is divided, whatever its parts.
struct Divided {
  explicit Divided(TriangleMesh mesh) : bodies{{std::move(mesh), 0, 0, 0, 0}} {}

  DividedBodies bodies;
  SurfaceTree tree{{}, &bodies};
};

Pose randomPose(std::mt19937_64& random, double far) {
  std::uniform_real_distribution<double> any(-1, 1);
  Pose X = Pose::Identity();
  X.linear() = Eigen::Quaterniond(any(random), any(random), any(random), any(random))
                   .normalized()
                   .toRotationMatrix();
  X.translation() = far * Vector3d(any(random), any(random), any(random));
  return X;
}

TEST(SurfaceTree, OfABoxesTrianglesIsAsFarAsTheBox) {
  const Vector3d half(0.03, 0.05, 0.02);
  const Shape box{Pose::Identity(), BoxShape{2 * half}};
  const Shape pin{Pose::Identity(), CylinderShape{0.01, 0.08}};
  const Divided surface(test::boxMesh(-half, half));
  const SurfaceTree exact({pin});
  std::mt19937_64 random(3);
  int apart = 0;
  for (int i = 0; i < 2000; ++i) {
    const Pose X_WA = randomPose(random, 0.15), X_WB = randomPose(random, 0.05);
    const auto found = SurfaceTree::distance(exact, X_WA, surface.tree, X_WB, 0.05);
    const ShapeDistance truth = shapeDistance(NarrowShape(pin), X_WA, NarrowShape(box), X_WB);
    if (truth.distance > 0.05 + 1e-6) {
      EXPECT_FALSE(found) << i;
    } else if (truth.distance > 1e-6 && truth.distance < 0.05 - 1e-6) {
      ASSERT_TRUE(found) << i;
      EXPECT_NEAR(found->distance, truth.distance, 1e-6) << i;
      EXPECT_NEAR((found->p_Wa - found->p_Wb).norm(), truth.distance, 1e-6) << i;
      EXPECT_NEAR((found->p_Wa - found->p_Wb).dot(found->n_W), truth.distance, 1e-6) << i;
      ++apart;
    }
  }
  EXPECT_GT(apart, 300);
}

TEST(SurfaceTree, OfManyTrianglesIsAsFarAsTheBallTheyStandFor) {
  const Divided ball(test::sphereMesh(0.05, 96)), other(test::sphereMesh(0.02, 96));
  std::mt19937_64 random(4);
  for (int i = 0; i < 200; ++i) {
    const Pose X_WA = randomPose(random, 0.1), X_WB = randomPose(random, 0.1);
    const double truth = (X_WA.translation() - X_WB.translation()).norm() - 0.07;
    if (truth < 0) continue;
    const auto found = SurfaceTree::distance(ball.tree, X_WA, other.tree, X_WB, 1);
    ASSERT_TRUE(found);
    EXPECT_GE(found->distance, truth - 1e-7);  // facets are inscribed
    EXPECT_LE(found->distance, truth + 1.2e-4);
  }
}

TEST(SurfaceTree, WhereSurfacesMeetTheyAreNotApart) {
  const Divided a(test::boxMesh({0, 0, 0}, {1, 1, 1})),
      b(test::boxMesh({0.9, 0.2, 0.2}, {2, 1, 1}));
  const auto found = SurfaceTree::distance(a.tree, Pose::Identity(), b.tree, Pose::Identity(), 1);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->distance, 0);
}

TEST(SurfaceTree, AWayOutOfABodyPassesThroughItsSurfaceAnOddNumberOfTimes) {
  const Divided cup(test::cupMesh());
  const auto crossings = [&](const Vector3d& from) {
    int count = 0;
    cup.tree.forEachCrossing(from, from + Vector3d(0.31, 0.17, 0.53),
                             [&](const SurfaceTree::Piece&, double along) {
                               EXPECT_GE(along, 0);
                               EXPECT_LE(along, 1);
                               ++count;
                             });
    return count;
  };
  EXPECT_EQ(crossings({0.034, 0.001, 0.05}) % 2, 1);   // in the wall
  EXPECT_EQ(crossings({0.001, 0.001, 0.05}) % 2, 0);   // in the cavity
  EXPECT_EQ(crossings({0.001, 0.001, 0.002}) % 2, 1);  // in the bottom
  EXPECT_EQ(crossings({0.05, 0.05, 0.05}), 0);
}

TEST(SurfaceTree, VisitsEveryPairWithinReachAndNoOther) {
  const Divided plate(test::boxMesh({-0.1, -0.1, -0.01}, {0.1, 0.1, 0}));
  const SurfaceTree pin({Shape{Pose::Identity(), BoxShape{{0.01, 0.01, 0.01}}}});
  const Pose X_WA(Eigen::Translation3d(0.02, 0.021, 0.006));
  std::set<int> near;
  SurfaceTree::forEachNear(pin, X_WA, plate.tree, Pose::Identity(), 0.002,
                           [&](const SurfaceTree::Piece&, const SurfaceTree::Piece& triangle,
                               const BodyDistance& distance) {
                             EXPECT_NEAR(distance.distance, 0.001, 1e-7);
                             EXPECT_GT(normalOf(plate.bodies[0].surface, triangle.triangle).z(),
                                       0.99);
                             near.insert(triangle.triangle);
                           });
  EXPECT_EQ(near.size(), 2u);  // the pin stands over the diagonal of the upper face
}

}  // namespace
}  // namespace handover
