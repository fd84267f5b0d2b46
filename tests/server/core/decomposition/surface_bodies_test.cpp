// SPDX-License-Identifier: Apache-2.0
#include "core/decomposition/surface_bodies.hpp"

#include "support/meshes.hpp"

#include <gtest/gtest.h>

namespace handover {
namespace {

using Eigen::Vector3d;

TriangleMesh someOf(const TriangleMesh& mesh, std::size_t first, std::size_t end) {
  TriangleMesh some{mesh.vertices, {}};
  some.triangles.assign(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(first),
                        mesh.triangles.begin() + static_cast<std::ptrdiff_t>(end));
  return some;
}

TriangleMesh joined(const std::vector<TriangleMesh>& meshes) {
  TriangleMesh all;
  for (const TriangleMesh& mesh : meshes) test::append(all, mesh);
  return all;
}

const TriangleMesh kBox = test::boxMesh({0, 0, 0}, {0.1, 0.2, 0.3});

TEST(BodiesOf, AClosedSurfaceCutInTwoPiecesAreOne) {
  const auto bodies = bodiesOf({someOf(kBox, 0, 5), someOf(kBox, 5, 12)});
  ASSERT_EQ(bodies.size(), 1u);
  EXPECT_EQ(bodies[0].open_edges, 0);
  EXPECT_EQ(bodies[0].mesh.vertices.size(), 8u);
  EXPECT_NEAR(signedVolume(bodies[0].mesh), 0.006, 1e-12);
}

TEST(BodiesOf, LooseComponentsAreEachOne) {
  std::vector<TriangleMesh> cubes;
  for (const double x : {0.0, 2.0, 4.0}) {
    cubes.push_back(test::boxMesh({x, 0, 0}, {x + 0.05, 0.05, 0.05}));
  }
  const auto bodies = bodiesOf({joined(cubes)});
  ASSERT_EQ(bodies.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(bodies[i].mesh.vertices.front().x(), 2.0 * static_cast<double>(i));
    EXPECT_EQ(bodies[i].open_edges, 0);
  }
}

TEST(BodiesOf, SolidsThatShareAnEdgeOrAFaceStayApart) {
  const TriangleMesh by_edge = test::boxMesh({0.1, 0.2, 0}, {0.2, 0.3, 0.3});
  const TriangleMesh by_face = test::boxMesh({0.1, 0, 0}, {0.2, 0.2, 0.3});
  EXPECT_EQ(bodiesOf({joined({kBox, by_edge})}).size(), 2u);
  const auto bodies = bodiesOf({kBox, by_face});  // each is closed by itself
  ASSERT_EQ(bodies.size(), 2u);
  for (const SurfaceBody& body : bodies) EXPECT_EQ(body.open_edges, 0);
}

TEST(BodiesOf, TrianglesAreWoundOutwardHoweverTheyWere) {
  TriangleMesh mixed = test::sphereMesh(0.1);
  for (std::size_t t = 0; t < mixed.triangles.size(); t += 3) {
    std::swap(mixed.triangles[t][1], mixed.triangles[t][2]);
  }
  const auto bodies = bodiesOf({mixed});
  ASSERT_EQ(bodies.size(), 1u);
  EXPECT_NEAR(signedVolume(bodies[0].mesh), signedVolume(test::sphereMesh(0.1)), 1e-12);
}

TEST(BodiesOf, OpenPiecesAreOneWhereTheirBoxesMeet) {
  const TriangleMesh lid = someOf(kBox, 2, 4), rest = someOf(kBox, 4, 12);
  const Pose aside(Eigen::Translation3d(0, 0, 1));
  EXPECT_EQ(bodiesOf({joined({rest, test::moved(lid, aside)})}).size(), 2u);
  // A lid of finer triangles shares no edge with the rest, and is of it all the same.
  const TriangleMesh fine{
      {{0, 0, 0.3}, {0.1, 0, 0.3}, {0.1, 0.2, 0.3}, {0, 0.2, 0.3}, {0.05, 0, 0.3}},
      {{0, 4, 3}, {4, 1, 2}, {4, 2, 3}}};
  const auto bodies = bodiesOf({joined({rest, fine})});
  ASSERT_EQ(bodies.size(), 1u);
  EXPECT_GT(bodies[0].open_edges, 0);
}

TEST(BodiesOf, CountsOpenEdges) {
  EXPECT_EQ(bodiesOf({someOf(kBox, 1, 12)}).at(0).open_edges, 3);
  EXPECT_EQ(bodiesOf({test::sheetMesh()}).at(0).open_edges, 50);
}

TEST(BodiesOf, TooManyAreOne) {
  std::vector<TriangleMesh> cubes;
  for (int i = 0; i < 513; ++i) {
    cubes.push_back(test::boxMesh(Vector3d(i, 0, 0), Vector3d(i + 0.5, 1, 1)));
  }
  EXPECT_EQ(bodiesOf({joined(cubes)}).size(), 1u);
  cubes.pop_back();
  EXPECT_EQ(bodiesOf({joined(cubes)}).size(), 512u);
}

TEST(BodiesOf, NothingIsNone) { EXPECT_TRUE(bodiesOf({TriangleMesh{}}).empty()); }

}  // namespace
}  // namespace handover
