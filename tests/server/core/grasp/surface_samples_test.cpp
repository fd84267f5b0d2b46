// SPDX-License-Identifier: Apache-2.0
#include "core/grasp/surface_samples.hpp"

#include "core/decomposition/convex_decomposition.hpp"
#include "core/grasp/object_surface.hpp"
#include "support/meshes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace handover {
namespace {

using Eigen::Vector3d;

Shape shapeAt(const Vector3d& p,
              std::variant<BoxShape, SphereShape, CylinderShape, ConvexShape> geometry) {
  Shape shape;
  shape.X_BS.translation() = p;
  shape.geometry = std::move(geometry);
  return shape;
}

double spacing(const std::vector<SurfaceSample>& samples, std::size_t count) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j < i; ++j)
      least = std::min(least, (samples[i].p_O - samples[j].p_O).norm());
  }
  return least;
}

TEST(SurfaceSamples, LieOnTheSurfaceWithOutwardNormals) {
  const std::vector<Shape> shapes{shapeAt({0.3, 0, 0}, SphereShape{0.05})};
  for (const SurfaceSample& s : sampleSurface(ObjectSurface(shapes), {})) {
    const Vector3d out = s.p_O - Vector3d(0.3, 0, 0);
    EXPECT_NEAR(out.norm(), 0.05, 1e-12);
    EXPECT_NEAR(out.normalized().dot(s.n_O), 1.0, 1e-12);
  }
}

TEST(SurfaceSamples, CoverACylinderBySideAndCapsInProportion) {
  const std::vector<Shape> shapes{shapeAt({0, 0, 0}, CylinderShape{0.05, 0.18})};
  SamplingParams params;
  params.wanted = 400;
  const auto samples = sampleSurface(ObjectSurface(shapes), params);
  ASSERT_EQ(samples.size(), 400u);
  double side = 0;
  for (const SurfaceSample& s : samples) {
    if (std::abs(s.n_O.z()) < 0.5) ++side;
  }
  const double share = 0.18 / (0.18 + 0.05);  // 2 pi r l of 2 pi r (l + r)
  EXPECT_NEAR(side / 400.0, share, 0.05);
}

TEST(SurfaceSamples, EveryPrefixIsEven) {
  const std::vector<Shape> shapes{shapeAt({0, 0, 0}, BoxShape{{0.1, 0.06, 0.2}})};
  const auto samples = sampleSurface(ObjectSurface(shapes), {});
  const double area = 2 * (0.1 * 0.06 + 0.1 * 0.2 + 0.06 * 0.2);
  for (const std::size_t count : {50u, 100u, 400u}) {
    // A hexagonal lattice would stand sqrt(1.15 A / n) apart.
    EXPECT_GT(spacing(samples, count), 0.6 * std::sqrt(1.15 * area / static_cast<double>(count)));
  }
}

TEST(SurfaceSamples, LeaveOutFacesBetweenParts) {
  const std::vector<Shape> shapes{shapeAt({0, 0, 0.05}, BoxShape{{0.1, 0.1, 0.1}}),
                                  shapeAt({0, 0, -0.05}, BoxShape{{0.1, 0.1, 0.1}})};
  for (const SurfaceSample& s : sampleSurface(ObjectSurface(shapes), {})) {
    if (std::abs(s.n_O.z()) < 0.5) continue;
    EXPECT_NEAR(std::abs(s.p_O.z()), 0.1, 1e-12);
  }
}

TEST(SurfaceSamples, LeaveOutTheInsideOfACup) {
  std::vector<Shape> walls;
  for (int i = 0; i < 4; ++i) {
    const bool along_x = i % 2 == 0;
    const double at = i < 2 ? 0.05 : -0.05;
    walls.push_back(
        shapeAt(along_x ? Vector3d(at, 0, 0) : Vector3d(0, at, 0),
                BoxShape{along_x ? Vector3d(0.003, 0.1, 0.15) : Vector3d(0.1, 0.003, 0.15)}));
  }
  for (const SurfaceSample& s : sampleSurface(ObjectSurface(walls), {})) {
    if (std::abs(s.n_O.z()) > 0.5) continue;
    EXPECT_GT(s.n_O.dot(s.p_O), 0);
  }
}

TEST(SurfaceSamples, RepeatForASeedAndDifferForAnother) {
  const std::vector<Shape> shapes{shapeAt({0, 0, 0}, CylinderShape{0.05, 0.18})};
  SamplingParams params;
  params.wanted = 50;
  const auto first = sampleSurface(ObjectSurface(shapes), params);
  const auto again = sampleSurface(ObjectSurface(shapes), params);
  params.seed = 2;
  const auto other = sampleSurface(ObjectSurface(shapes), params);
  for (std::size_t i = 0; i < first.size(); ++i) EXPECT_EQ(first[i].p_O, again[i].p_O);
  EXPECT_NE(first[1].p_O, other[1].p_O);
}

TEST(ConvexPart, MeetsSegmentsThatPassThroughIt) {
  const ConvexPart part = toConvexPart(shapeAt({0, 0, 0}, BoxShape{{0.1, 0.1, 0.1}}));
  EXPECT_TRUE(part.meetsSegment({-1, 0, 0}, {1, 0, 0}));
  EXPECT_TRUE(part.meetsSegment({0, 0, 0}, {0.01, 0, 0}));
  EXPECT_FALSE(part.meetsSegment({-1, 0.06, 0}, {1, 0.06, 0}));
  EXPECT_FALSE(part.meetsSegment({-1, 0, 0}, {-0.06, 0, 0}));
  EXPECT_FALSE(part.meetsSegment({0.11, 0, 0}, {0, 0.11, 0}));
}

TEST(ConvexPart, IsClosedAndOutwardForEveryShape) {
  const std::vector<Shape> shapes{shapeAt({0, 0, 0}, BoxShape{{0.1, 0.2, 0.3}}),
                                  shapeAt({0, 0, 0}, SphereShape{0.1}),
                                  shapeAt({0, 0, 0}, CylinderShape{0.1, 0.3})};
  const double volumes[] = {0.006, 4.0 / 3.0 * M_PI * 1e-3, M_PI * 0.01 * 0.3};
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    const ConvexPart part = toConvexPart(shapes[k]);
    double volume = 0;
    for (const auto& t : part.triangles) {
      const auto at = [&](std::size_t c) { return part.vertices[static_cast<std::size_t>(t[c])]; };
      volume += at(0).dot(at(1).cross(at(2))) / 6;
    }
    EXPECT_NEAR(volume, volumes[k], 0.01 * volumes[k]);
    EXPECT_TRUE(part.contains({0, 0, 0}, 0.04));
  }
}

TEST(SurfaceSamples, OfAMeshDividedIntoPartsLieOnItsOutside) {
  const auto parts = convexParts(test::cupMesh());
  ASSERT_TRUE(parts);
  std::vector<Shape> shapes;
  for (const TriangleMesh& part : *parts) {
    shapes.push_back(shapeAt({0, 0, 0}, ConvexShape{part.vertices, part.triangles}));
  }
  const auto samples = sampleSurface(ObjectSurface(shapes), {});
  EXPECT_GT(samples.size(), 1000u);
  std::size_t elsewhere = 0;
  for (const SurfaceSample& s : samples) {
    const double r = std::hypot(s.p_O.x(), s.p_O.y()), z = s.p_O.z();
    const Vector3d out(s.p_O.x() / r, s.p_O.y() / r, 0);
    const bool side = r > 0.0359 && s.n_O.dot(out) > 0.99;
    const bool below = z < 1e-6 && s.n_O.z() < -0.99;
    const bool rim = z > 0.0949 && s.n_O.z() > 0.99;
    const bool bottom = z > 0.003 && z < 0.006 && s.n_O.z() > 0.9;  // seen through the mouth
    if (!side && !below && !rim && !bottom) ++elsewhere;
  }
  // Where two parts meet, the last half millimetre of the faces between them counts as seen.
  EXPECT_LE(elsewhere, samples.size() / 50);
}

}  // namespace
}  // namespace handover
