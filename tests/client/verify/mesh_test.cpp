// SPDX-License-Identifier: Apache-2.0
#include "verify/mesh.hpp"

#include "support/temporary_folder.hpp"
#include "verify/unreadable.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

namespace handover::verify {
namespace {

namespace fs = std::filesystem;

class MeshFileTest : public testing::Test {
 protected:
  fs::path write(const std::string& name, const std::string& text) const {
    return folder_.write(name, text);
  }

  /// All parts of the file in one.
  static Mesh readWhole(const fs::path& file, const Eigen::Vector3d& scale) {
    Mesh whole;
    for (const Mesh& part : readMesh(file, scale)) whole.append(part);
    return whole;
  }

  static Eigen::AlignedBox3d boxOf(const Mesh& mesh) {
    Eigen::AlignedBox3d box;
    for (const auto& vertex : mesh.vertices) box.extend(vertex);
    return box;
  }

  handover::test::TemporaryFolder folder_;
};

constexpr const char* kTetrahedron =
    "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

TEST_F(MeshFileTest, ReadsObjAndScales) {
  const Mesh mesh = readWhole(write("a.obj", kTetrahedron), {2, 1, 1});
  EXPECT_EQ(mesh.triangles.size(), 4u);
  EXPECT_TRUE(boxOf(mesh).max().isApprox(Eigen::Vector3d(2, 2, 3)));
}

TEST_F(MeshFileTest, ReadsATextStlWithAnEmptySolid) {
  const std::string text =
      "solid none\nendsolid none\nsolid one\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n"
      "vertex 1 0 0\nvertex 0 2e0 0\nendloop\nendfacet\nendsolid one\n";
  const Mesh mesh = readWhole(write("a.stl", text), {1, 1, 1});
  EXPECT_EQ(mesh.triangles.size(), 1u);
  EXPECT_TRUE(boxOf(mesh).max().isApprox(Eigen::Vector3d(1, 2, 0)));
  EXPECT_THROW(readWhole(write("b.stl", "solid none\nendsolid none\n"), {1, 1, 1}), Unreadable);
  EXPECT_THROW(readWhole(write("c.stl", "solid one\nvertex 1 2 x\n"), {1, 1, 1}), Unreadable);
}

TEST_F(MeshFileTest, MirroredMeshesStaySolid) {
  const Mesh mesh = readWhole(write("a.obj", kTetrahedron), {1, -1, 1});
  const auto shells = shellsOf(mesh);
  ASSERT_EQ(shells.size(), 1u);
  EXPECT_TRUE(shells[0].closed);
  EXPECT_TRUE(shells[0].contains({0.1, -0.2, 0.1}));
  EXPECT_FALSE(shells[0].contains({0.1, 0.2, 0.1}));
}

TEST_F(MeshFileTest, SplitsObjectsOfOneFileIntoShells) {
  std::string text = std::string("o first\n") + kTetrahedron +
                     "o second\nv 10 0 0\nv 11 0 0\nv 10 2 0\nv 10 0 3\nf 5 7 6\nf 5 6 8\n";
  const auto shells = shellsOf(readWhole(write("a.obj", text), {1, 1, 1}));
  ASSERT_EQ(shells.size(), 2u);
  EXPECT_TRUE(shells[0].closed);
  EXPECT_FALSE(shells[1].closed);  // two faces are missing
  EXPECT_FALSE(shells[1].contains({10.1, 0.2, 0.1}));
}

TEST_F(MeshFileTest, KeepsPartsThatShareCornersApart) {
  const std::string text = std::string("o first\n") + kTetrahedron +
                           "o second\nv 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 -3\nf 5 6 7\nf 5 8 6\nf 6 8 "
                           "7\nf 7 8 5\n";
  const auto parts = readMesh(write("a.obj", text), {1, 1, 1});
  ASSERT_EQ(parts.size(), 2u);
  for (const Mesh& part : parts) {
    const auto shells = shellsOf(part);
    ASSERT_EQ(shells.size(), 1u);
    EXPECT_TRUE(shells[0].closed);
  }
}

TEST_F(MeshFileTest, ASolidCutByItsMaterialsIsOne) {
  std::string text = kTetrahedron;
  text.insert(text.find("f "), "usemtl red\n");
  text.insert(text.rfind("f "), "usemtl blue\n");
  const auto parts = readMesh(write("a.obj", text), {1, 1, 1});
  ASSERT_EQ(parts.size(), 1u);
  const auto shells = shellsOf(parts[0]);
  ASSERT_EQ(shells.size(), 1u);
  EXPECT_TRUE(shells[0].closed);
  EXPECT_TRUE(shells[0].contains({0.1, 0.2, 0.1}));
}

TEST_F(MeshFileTest, ReadsTextStl) {
  const Mesh mesh =
      readWhole(write("a.stl",
                      "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 "
                      "0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n"),
                {1, 1, 1});
  EXPECT_EQ(mesh.triangles.size(), 1u);
}

TEST_F(MeshFileTest, HonoursUnitsAndNodesOfColladaButNotItsUpAxis) {
  const std::string text = R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
 <asset><unit name="centimeter" meter="0.01"/><up_axis>Z_UP</up_axis></asset>
 <library_geometries><geometry id="g" name="g"><mesh>
  <source id="p"><float_array id="pa" count="9">0 0 0 100 0 0 0 0 100</float_array>
   <technique_common><accessor source="#pa" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
  <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
  <triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
 </mesh></geometry></library_geometries>
 <library_visual_scenes><visual_scene id="s"><node id="n"><matrix>2 0 0 0  0 2 0 0  0 0 2 300  0 0 0 1</matrix><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
 <scene><instance_visual_scene url="#s"/></scene>
</COLLADA>)";
  const Eigen::AlignedBox3d box = boxOf(readWhole(write("a.dae", text), {1, 1, 1}));
  EXPECT_TRUE(box.min().isApprox(Eigen::Vector3d(0, 0, 3), 1e-6)) << box.min().transpose();
  EXPECT_TRUE(box.max().isApprox(Eigen::Vector3d(2, 0, 5), 1e-6)) << box.max().transpose();
}

TEST_F(MeshFileTest, RefusesWhatIsNoMesh) {
  EXPECT_THROW(readMesh(write("a.obj", "v 0 0 0\n"), {1, 1, 1}), Unreadable);
  EXPECT_THROW(readMesh(write("a.stl", "nonsense"), {1, 1, 1}), Unreadable);
  EXPECT_THROW(readMesh(write("a.dae", "<COLLADA"), {1, 1, 1}), Unreadable);
}

TEST(Primitives, AreClosedAndEncloseTheTrueShape) {
  for (const Mesh& mesh : {boxMesh({1, 2, 3}), cylinderMesh(1, 2), sphereMesh(1)}) {
    const auto shells = shellsOf(mesh);
    ASSERT_EQ(shells.size(), 1u);
    EXPECT_TRUE(shells[0].closed);
    EXPECT_TRUE(shells[0].contains({0.1, 0.2, 0.3}));
    EXPECT_FALSE(shells[0].contains({2, 2, 2}));
  }
  const Shell sphere = shellsOf(sphereMesh(1)).front();
  const Shell cylinder = shellsOf(cylinderMesh(1, 2)).front();
  for (double a = 0.01; a < 6.28; a += 0.05) {
    for (double b = -1.5; b < 1.5; b += 0.1) {
      const Eigen::Vector3d p(std::cos(b) * std::cos(a), std::cos(b) * std::sin(a), std::sin(b));
      EXPECT_TRUE(sphere.contains(p * 0.9999));
      EXPECT_FALSE(sphere.contains(p * 1.0101));
    }
    EXPECT_TRUE(cylinder.contains({0.9999 * std::cos(a), 0.9999 * std::sin(a), 0.9}));
    EXPECT_FALSE(cylinder.contains({1.0008 * std::cos(a), 1.0008 * std::sin(a), 0.9}));
  }
}

TEST(NearestOnTriangle, CoversFaceEdgesAndCorners) {
  const Eigen::Vector3d a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  const auto nearest = [&](double x, double y, double z) {
    return nearestOnTriangle({x, y, z}, a, b, c);
  };
  EXPECT_TRUE(nearest(0.2, 0.2, 5).isApprox(Eigen::Vector3d(0.2, 0.2, 0)));
  EXPECT_TRUE(nearest(-1, -1, 1).isZero());
  EXPECT_TRUE(nearest(3, -1, 0).isApprox(b));
  EXPECT_TRUE(nearest(-1, 3, 0).isApprox(c));
  EXPECT_TRUE(nearest(0.5, -1, 0).isApprox(Eigen::Vector3d(0.5, 0, 0)));
  EXPECT_TRUE(nearest(1, 1, 0).isApprox(Eigen::Vector3d(0.5, 0.5, 0)));
}

}  // namespace
}  // namespace handover::verify
