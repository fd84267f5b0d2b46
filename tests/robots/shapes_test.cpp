// SPDX-License-Identifier: Apache-2.0
// Our collision shapes: convex and closed as written, and as large as the published meshes.
#include "core/model/mesh_reader.hpp"
#include "robot_files.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <numbers>
#include <sstream>

namespace handover {
namespace {

using Eigen::Vector3d;

struct Part {
  std::string name;
  std::vector<Vector3d> vertices;
  std::vector<std::array<int, 3>> triangles;

  double volume() const {
    double sum = 0;
    for (const auto& t : triangles) sum += corner(t, 0).dot(corner(t, 1).cross(corner(t, 2))) / 6;
    return sum;
  }

  const Vector3d& corner(const std::array<int, 3>& t, std::size_t i) const {
    return vertices[static_cast<std::size_t>(t[i])];
  }
};

/// The file as written, not as a mesh library mends it.
std::vector<Part> readParts(const std::filesystem::path& file) {
  std::vector<Part> parts;
  std::ifstream in(file);
  int before = 0;
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string key;
    words >> key;
    if (key == "o") {
      if (!parts.empty()) before += static_cast<int>(parts.back().vertices.size());
      parts.emplace_back();
      words >> parts.back().name;
    } else if (key == "v") {
      Vector3d v;
      words >> v.x() >> v.y() >> v.z();
      parts.back().vertices.push_back(v);
    } else if (key == "f") {
      std::array<int, 3> t{};
      words >> t[0] >> t[1] >> t[2];
      for (int& index : t) index -= before + 1;
      parts.back().triangles.push_back(t);
    }
  }
  return parts;
}

std::vector<std::filesystem::path> meshFiles() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(testing::robotsFolder())) {
    if (entry.path().extension() == ".obj") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

TEST(Meshes, ConsistOfFewSmallClosedConvexParts) {
  const auto files = meshFiles();
  ASSERT_GE(files.size(), 50u);
  for (const auto& file : files) {
    for (const Part& part : readParts(file)) {
      SCOPED_TRACE(file.filename().string() + " " + part.name);
      EXPECT_LE(part.vertices.size(), 32u);
      EXPECT_GT(part.volume(), 1e-7);
      std::map<std::pair<int, int>, int> edges;
      double outside = 0;
      for (const auto& t : part.triangles) {
        const Vector3d normal =
            (part.corner(t, 1) - part.corner(t, 0)).cross(part.corner(t, 2) - part.corner(t, 0));
        ASSERT_GT(normal.norm(), 0);
        for (const Vector3d& v : part.vertices) {
          outside = std::max(outside, normal.normalized().dot(v - part.corner(t, 0)));
        }
        for (std::size_t i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
      }
      EXPECT_LT(outside, 1e-6);
      for (const auto& [edge, count] : edges) {
        EXPECT_EQ(count, 1);
        EXPECT_TRUE(edges.contains({edge.second, edge.first}));
      }
    }
  }
}

TEST(Meshes, AreReadPartByPart) {
  for (const auto& file : meshFiles()) {
    EXPECT_EQ(readConvexMesh(file, Vector3d::Ones()).size(), readParts(file).size()) << file;
  }
}

Eigen::AlignedBox3d boundsOf(const std::vector<Shape>& shapes) {
  Eigen::AlignedBox3d bounds;
  for (const Shape& shape : shapes) {
    if (const auto* hull = std::get_if<ConvexShape>(&shape.geometry)) {
      for (const Vector3d& v : hull->vertices) bounds.extend(shape.X_BS * v);
    }
  }
  return bounds;
}

TEST(Links, AreAsLargeAsThePublishedMeshes) {
  RobotModel model;
  int compared = 0;
  double worst = 0;
  for (const auto& row : testing::readTable(std::filesystem::path(HANDOVER_SOURCE_DIR) /
                                            "tests/robots/link_boxes.txt")) {
    if (row[0] == "robot") {
      model = testing::loadBody(row.at(1));
      continue;
    }
    const int link = model.findLink(row[0]);
    ASSERT_GE(link, 0) << row[0];
    const auto triple = [&row](std::size_t i) {
      return Vector3d(std::stod(row.at(i)), std::stod(row.at(i + 1)), std::stod(row.at(i + 2)));
    };
    const Vector3d half = triple(1) / 2, centre = triple(4);
    const auto ours = boundsOf(model.links[static_cast<std::size_t>(link)].collision);
    const double off = std::max((ours.min() - (centre - half)).cwiseAbs().maxCoeff(),
                                (ours.max() - (centre + half)).cwiseAbs().maxCoeff());
    EXPECT_LT(off, 0.01) << row[0];
    worst = std::max(worst, off);
    ++compared;
  }
  EXPECT_EQ(compared, 2 * 17 + 5 + 2 * 13 + 3 * 7);
  EXPECT_LT(worst, 0.003);
}

TEST(Links, EveryLinkOfTheArmsAndHandsHasAShape) {
  for (const char* name : {"crichton", "hubo"}) {
    const RobotModel model = testing::loadBody(name);
    for (const Link& link : model.links) {
      const bool frame = link.name.ends_with("_tool") || link.name.ends_with("Palm") ||
                         link.name.ends_with("Foot") || link.name.ends_with("grasp_link") ||
                         link.name.ends_with("L0_link");
      EXPECT_EQ(link.collision.empty(), frame) << name << " " << link.name;
    }
  }
}

/// The mirror image of a right link's shape is the left link's.
TEST(Links, HubosRightSideMirrorsItsLeft) {
  const auto meshes = testing::robotsFolder() / "hubo/meshes";
  for (const char* link : {"SP", "SR", "SY", "EP", "WY", "WP", "WR", "HY", "HR", "HP", "KP", "AP",
                           "AR", "Fx1", "Fx2", "Fx3"}) {
    const auto left = boundsOf(
        readConvexMesh(meshes / ("Body_L" + std::string(link) + ".obj"), Vector3d::Ones()));
    const auto right = boundsOf(
        readConvexMesh(meshes / ("Body_R" + std::string(link) + ".obj"), Vector3d(1, -1, 1)));
    EXPECT_LT((left.min() - right.min()).norm() + (left.max() - right.max()).norm(), 1e-9) << link;
  }
}

/// Bounds of an object's mesh.
Eigen::AlignedBox3d objectBounds(const std::string& name) {
  return boundsOf(readConvexMesh(testing::robotsFolder() / "objects" / name / (name + ".obj"),
                                 Vector3d::Ones()));
}

TEST(Objects, HaveThePublishedSizes) {
  struct Row {
    const char* name;
    Vector3d min, max;
  };

  // scenes of ana-GT/commonData @ 258f6e1; the cup with z for its axis.
  const Row rows[] = {
      {"table", {0, 0, 0}, {0.6096, 1.8288, 2.197}},
      {"cart", {-0.012, 0.017, 0}, {0.998, 0.567, 0.963}},
      {"milk_carton", {-0.0435, -0.0435, -0.1195}, {0.0435, 0.0435, 0.1195}},
      {"hammer", {-0.016, -0.075, -0.170}, {0.016, 0.057, 0.160}},
      {"dog_plate", {-0.149, -0.149, -0.05}, {0.149, 0.149, 0.05}},
      {"stool", {-0.1985, -0.394, -0.475}, {0.1985, 0.218, 0.605}},
      {"dog", {-0.109, -0.266, -0.420}, {0.109, 0.528, 0.243}},
  };
  for (const Row& row : rows) {
    const auto bounds = objectBounds(row.name);
    EXPECT_LT((bounds.min() - row.min).cwiseAbs().maxCoeff(), 1e-3) << row.name;
    EXPECT_LT((bounds.max() - row.max).cwiseAbs().maxCoeff(), 1e-3) << row.name;
  }
}

TEST(Cup, IsOpenUpwardsWithThinWalls) {
  const auto parts = readParts(testing::robotsFolder() / "objects/cup/cup.obj");
  ASSERT_EQ(parts.size(), 10u);
  double material = 0, rim = 0, base = 0;
  for (const Part& part : parts) {
    material += part.volume();
    for (const Vector3d& v : part.vertices) {
      EXPECT_LE(std::abs(v.z()), 0.0755 + 1e-9);
      if (v.z() > 0.0755 - 1e-6) rim = std::max(rim, v.head<2>().norm());
      if (v.z() < -0.0755 + 1e-6) base = std::max(base, v.head<2>().norm());
    }
  }
  EXPECT_NEAR(rim, 0.046, 1e-6);
  EXPECT_NEAR(base, 0.034, 1e-6);
  // Nine panels of 3 mm and a bottom of 3 mm: what a filled cup would hold is not there.
  const double sides = 9 * std::tan(std::numbers::pi / 9);
  const double mid = 0.040 * std::cos(std::numbers::pi / 9) - 0.0015;
  EXPECT_NEAR(material, 0.003 * (2 * sides * mid * 0.148 + sides * 0.033 * 0.033), 5e-6);
}

}  // namespace
}  // namespace handover
