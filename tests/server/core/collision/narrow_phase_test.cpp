// SPDX-License-Identifier: Apache-2.0
#include "core/collision/narrow_phase.hpp"

#include "random_shapes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace handover::test {
namespace {

Pose at(double x, double y, double z) {
  Pose X = Pose::Identity();
  X.translation() = Eigen::Vector3d(x, y, z);
  return X;
}

NarrowShape box(double x, double y, double z) {
  Shape shape;
  shape.geometry = BoxShape{Eigen::Vector3d(x, y, z)};
  return NarrowShape(shape);
}

NarrowShape sphere(double radius) {
  Shape shape;
  shape.geometry = SphereShape{radius};
  return NarrowShape(shape);
}

NarrowShape cylinder(double radius, double length) {
  Shape shape;
  shape.geometry = CylinderShape{radius, length};
  return NarrowShape(shape);
}

NarrowShape tetrahedron() {
  Shape shape;
  ConvexShape hull;
  hull.vertices = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}};
  hull.triangles = hullTriangles(hull.vertices);
  shape.geometry = hull;
  return NarrowShape(shape);
}

// A polytope in world, as the separating axis theorem wants it.
struct Polytope {
  std::vector<Eigen::Vector3d> vertices, normals, edges;

  Polytope(const Shape& shape, const Pose& X_WS) {
    if (const auto* box = std::get_if<BoxShape>(&shape.geometry)) {
      for (int i = 0; i < 8; ++i) {
        const Eigen::Vector3d sign((i & 1) * 2 - 1, (i & 2) - 1, (i & 4) / 2 - 1);
        vertices.push_back(X_WS * Eigen::Vector3d(0.5 * sign.cwiseProduct(box->size)));
      }
      for (int axis = 0; axis < 3; ++axis) normals.push_back(X_WS.linear().col(axis));
      edges = normals;
      return;
    }
    const auto& hull = std::get<ConvexShape>(shape.geometry);
    for (const Eigen::Vector3d& v : hull.vertices) vertices.push_back(X_WS * v);
    for (const std::array<int, 3>& t : hull.triangles) {
      const auto corner = [&](std::size_t i) { return vertices[static_cast<std::size_t>(t[i])]; };
      edges.push_back(corner(1) - corner(0));
      edges.push_back(corner(2) - corner(1));
      edges.push_back(corner(0) - corner(2));
      normals.push_back((corner(1) - corner(0)).cross(corner(2) - corner(0)));
    }
  }

  double reach(const Eigen::Vector3d& direction) const {
    double most = -std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3d& v : vertices) most = std::max(most, direction.dot(v));
    return most;
  }
};

// The least overlap over all face normals and pairs of edges; <= 0 when apart.
double depthBySeparatingAxes(const Shape& shape_a, const Pose& X_WA, const Shape& shape_b,
                             const Pose& X_WB) {
  const Polytope a(shape_a, X_WA), b(shape_b, X_WB);
  double least = std::numeric_limits<double>::infinity();
  const auto consider = [&](const Eigen::Vector3d& axis) {
    if (axis.norm() < 1e-12) return;
    const Eigen::Vector3d n = axis.normalized();
    least = std::min({least, a.reach(n) + b.reach(-n), b.reach(n) + a.reach(-n)});
  };
  for (const Eigen::Vector3d& n : a.normals) consider(n);
  for (const Eigen::Vector3d& n : b.normals) consider(n);
  for (const Eigen::Vector3d& e : a.edges) {
    for (const Eigen::Vector3d& f : b.edges) consider(e.cross(f));
  }
  return least;
}

TEST(NarrowPhase, TouchesWithinTwoMarginsAndNotBeyond) {
  const NarrowShape thin = box(0.1, 0.1, 0.002);
  for (const NarrowShape* other : {&thin}) {
    EXPECT_TRUE(touching(thin, at(0, 0, 0), *other, at(0, 0, 0.0039)));
    EXPECT_FALSE(touching(thin, at(0, 0, 0), *other, at(0, 0, 0.0041)));
  }
  EXPECT_TRUE(touching(sphere(0.05), at(0, 0, 0), sphere(0.02), at(0.0719, 0, 0)));
  EXPECT_FALSE(touching(sphere(0.05), at(0, 0, 0), sphere(0.02), at(0.0721, 0, 0)));
  EXPECT_TRUE(touching(cylinder(0.05, 0.2), at(0, 0, 0), box(0.1, 0.1, 0.1), at(0.1019, 0, 0)));
  EXPECT_FALSE(touching(cylinder(0.05, 0.2), at(0, 0, 0), box(0.1, 0.1, 0.1), at(0.1021, 0, 0)));
  EXPECT_TRUE(touching(cylinder(0.05, 0.2), at(0, 0, 0), box(0.1, 0.1, 0.1), at(0, 0, 0.1519)));
  EXPECT_FALSE(touching(cylinder(0.05, 0.2), at(0, 0, 0), box(0.1, 0.1, 0.1), at(0, 0, 0.1521)));
  EXPECT_TRUE(touching(tetrahedron(), at(0, 0, 0), sphere(0.01), at(0.02, 0.02, -0.0119)));
  EXPECT_FALSE(touching(tetrahedron(), at(0, 0, 0), sphere(0.01), at(0.02, 0.02, -0.0121)));
}

TEST(NarrowPhase, OneInsideTheOtherTouches) {
  EXPECT_TRUE(touching(box(1, 1, 1), at(0, 0, 0), sphere(0.01), at(0, 0, 0)));
  EXPECT_TRUE(touching(tetrahedron(), at(0, 0, 0), sphere(0.001), at(0.02, 0.02, 0.02)));
  EXPECT_TRUE(touching(cylinder(0.3, 0.3), at(0, 0, 0), box(0.01, 0.01, 0.01), at(0.1, 0, 0)));
}

TEST(NarrowPhase, DistanceTakesTheMarginsOff) {
  const ShapeDistance found =
      shapeDistance(box(0.2, 0.2, 0.2), at(0, 0, 0), cylinder(0.05, 0.3), at(0.2, 0.02, 0));
  EXPECT_NEAR(found.distance, 0.05, 1e-7);
  EXPECT_NEAR(found.n_W.x(), -1, 1e-6);
  EXPECT_NEAR(found.p_Wa.x(), 0.1, 1e-7);
  EXPECT_NEAR(found.p_Wb.x(), 0.15, 1e-7);
  const ShapeDistance ball = shapeDistance(sphere(0.05), at(0, 0, 0), sphere(0.02), at(0, 0, 0.1));
  EXPECT_NEAR(ball.distance, 0.03, 1e-12);
  EXPECT_NEAR(ball.p_Wa.z(), 0.05, 1e-12);
  EXPECT_NEAR(ball.p_Wb.z(), 0.08, 1e-12);
}

TEST(NarrowPhase, OverlapIsNegativeAlongTheShortestWayOut) {
  const ShapeDistance found =
      shapeDistance(box(0.2, 0.2, 0.2), at(0, 0, 0), box(0.2, 0.2, 0.2), at(0.01, 0.02, 0.195));
  EXPECT_NEAR(found.distance, -0.005, 1e-9);
  EXPECT_NEAR(found.n_W.z(), -1, 1e-9);
  const ShapeDistance ball =
      shapeDistance(box(0.2, 0.2, 0.2), at(0, 0, 0), sphere(0.02), at(0.09, 0, 0));
  EXPECT_NEAR(ball.distance, -0.03, 1e-9);
  EXPECT_NEAR(ball.n_W.x(), -1, 1e-9);
  const ShapeDistance same = shapeDistance(sphere(0.02), at(0, 0, 0), sphere(0.03), at(0, 0, 0));
  EXPECT_NEAR(same.distance, -0.05, 1e-9);
  EXPECT_NEAR(same.n_W.norm(), 1, 1e-12);
}

// A cup stands on its tray at a height that is right to the last digit: depth 0, not some other
// face's.
TEST(NarrowPhase, ExactTouchHasDepthZeroAndTheFacesNormal) {
  const NarrowShape plate = box(0.3, 0.2, 0.01), cup = cylinder(0.04, 0.15),
                    cube = box(0.05, 0.05, 0.05);
  for (const double x : {0.0, 0.03, -0.1, 0.1}) {
    const ShapeDistance round = shapeDistance(cup, at(x, 0.01, 0.08), plate, at(0, 0, 0));
    EXPECT_NEAR(round.distance, 0, 1e-9) << x;
    EXPECT_NEAR(round.n_W.z(), 1, 1e-4) << x;
    const ShapeDistance flat = shapeDistance(cube, at(x, 0.01, 0.03), plate, at(0, 0, 0));
    EXPECT_NEAR(flat.distance, 0, 1e-9) << x;
    EXPECT_NEAR(flat.n_W.z(), 1, 1e-4) << x;
  }
}

// A box on a table of corners, where EPA finds no normal but one along the table.
TEST(NarrowPhase, ExactTouchOfAConvexTableHasDepthZero) {
  ConvexShape top;
  for (const double x : {0.0, 0.6096}) {
    for (const double y : {0.0, 1.8288}) {
      for (const double z : {0.6477, 0.6731}) top.vertices.emplace_back(x, y, z);
    }
  }
  const NarrowShape table(Shape{Pose::Identity(), top});
  const ShapeDistance found =
      shapeDistance(box(0.05, 0.05, 0.18), at(0.42, -0.25, 0.7831), table, at(0.20, -0.91, 0.02));
  EXPECT_NEAR(found.distance, 0, 1e-9);
}

TEST(NarrowPhase, DepthsOfPolytopesAreThoseOfTheSeparatingAxes) {
  RandomShapes random(5);
  int overlapping = 0;
  while (overlapping < 1000) {
    Shape a, b;
    if (random.uniform(0, 1) < 0.5)
      a.geometry = random.box();
    else
      a.geometry = random.hull();
    b.geometry = random.hull();
    const Pose X_WA = random.pose(0.1), X_WB = random.pose(0.1);
    const double depth = depthBySeparatingAxes(a, X_WA, b, X_WB);
    if (depth <= 0) continue;
    ++overlapping;
    EXPECT_NEAR(shapeDistance(NarrowShape(a), X_WA, NarrowShape(b), X_WB).distance, -depth, 1e-9);
  }
}

// The equation in the header: moving `a` by -distance along the normal brings the shapes to touch.
TEST(NarrowPhase, MovingByTheDistanceTouches) {
  RandomShapes random(7);
  int deep = 0;
  for (int i = 0; i < 5000; ++i) {
    const NarrowShape a(random.any()), b(random.any());
    Pose X_WA = random.pose(0.15);
    const Pose X_WB = random.pose(0.15);
    const ShapeDistance found = shapeDistance(a, X_WA, b, X_WB);
    EXPECT_NEAR(found.n_W.norm(), 1, 1e-9);
    EXPECT_NEAR(found.n_W.dot(found.p_Wa - found.p_Wb), found.distance, 1e-6);
    if (found.distance < 0) ++deep;
    X_WA.translation() -= (found.distance - 1e-5) * found.n_W;
    const double apart = shapeDistance(a, X_WA, b, X_WB).distance;
    EXPECT_GE(apart, 0) << "pair " << i << " from " << found.distance;
    if (found.distance > 0) {
      EXPECT_NEAR(apart, 1e-5, 1e-6) << "pair " << i;
    }
  }
  EXPECT_GT(deep, 500);
}

TEST(NarrowPhase, DistanceIsSymmetric) {
  RandomShapes random(8);
  for (int i = 0; i < 5000; ++i) {
    const NarrowShape a(random.any()), b(random.any());
    const Pose X_WA = random.pose(0.2), X_WB = random.pose(0.2);
    const ShapeDistance one = shapeDistance(a, X_WA, b, X_WB);
    const ShapeDistance other = shapeDistance(b, X_WB, a, X_WA);
    if (one.distance < 0) continue;
    EXPECT_NEAR(one.distance, other.distance, 1e-6);
    EXPECT_NEAR((one.n_W + other.n_W).norm() * one.distance, 0, 1e-3 * one.distance + 1e-6);
  }
}

TEST(NarrowPhase, RefusesSizesThatAreNone) {
  EXPECT_THROW(box(0.1, 0, 0.1), std::invalid_argument);
  EXPECT_THROW(sphere(-1), std::invalid_argument);
  EXPECT_THROW(cylinder(0.1, std::numeric_limits<double>::quiet_NaN()), std::invalid_argument);
  Shape empty;
  empty.geometry = ConvexShape{};
  EXPECT_THROW(NarrowShape{empty}, std::invalid_argument);
}

TEST(NarrowPhase, WhatIsProvenApartStaysApartWhileItMoves) {
  constexpr double kProven = 0.001, kReach = 0.5;  // of the shapes' points from their origins
  RandomShapes random(31);
  int apart = 0, moving = 0;
  for (int round = 0; round < 6000; ++round) {
    const NarrowShape a(random.any()), b(random.any());
    const Pose X_WA = random.pose(0.4), X_WB = random.pose(0.4);
    // Each turns about its origin, which goes straight on.
    const double size = round % 2 == 0 ? 0.05 : 0.2;
    const Eigen::Vector3d w_a = random.uniform(0, size) * random.direction(),
                          v_a = random.uniform(0, size) * random.direction();
    const bool still = round % 3 == 0;
    const Eigen::Vector3d w_b = still ? 0 * w_a : random.uniform(0, size) * random.direction(),
                          v_b = still ? 0 * v_a : random.uniform(0, size) * random.direction();
    PairMotion motion;
    motion.a = {w_a, v_a - w_a.cross(X_WA.translation())};
    motion.b = {w_b, v_b - w_b.cross(X_WB.translation())};
    const double extra = random.uniform(0, 0.02);  // and somewhere else besides
    motion.beyond = extra + 0.5 * kReach * (w_a.squaredNorm() + w_b.squaredNorm());
    motion.most = motion.beyond + v_a.norm() + v_b.norm() + kReach * (w_a.norm() + w_b.norm());
    const Nearness found = nearness(a, X_WA, b, X_WB, motion, 0.002, kProven);
    EXPECT_EQ(found == Nearness::kTouching, touching(a, X_WA, b, X_WB));
    if (found != Nearness::kApart) continue;
    ++apart;
    if (shapeDistance(a, X_WA, b, X_WB).distance < motion.most) ++moving;
    for (const double x : {-1.0, -0.6, -0.2, 0.0, 0.3, 0.7, 1.0}) {
      const auto moved = [&](const Pose& X, const Eigen::Vector3d& w, const Eigen::Vector3d& v) {
        Pose Y = X;
        Y.linear() = Eigen::AngleAxisd(x * w.norm(), w.normalized()) * X.linear();
        Y.translation() += x * v;
        return Y;
      };
      const double distance =
          shapeDistance(a, moved(X_WA, w_a, v_a), b, moved(X_WB, w_b, v_b)).distance;
      EXPECT_GE(distance, kProven + extra) << round << " at " << x;
    }
  }
  EXPECT_GT(apart, 1000);
  EXPECT_GT(moving, 300);  // those that the length of the way alone would not tell
}

}  // namespace
}  // namespace handover::test
