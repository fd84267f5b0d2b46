// SPDX-License-Identifier: Apache-2.0
// Our collision shapes: convex and closed as written, and as large as the published meshes.
#include "core/model_io/mesh_reader.hpp"
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
    const LinkId link = model.findLink(row[0]);
    ASSERT_TRUE(link.valid()) << row[0];
    const auto triple = [&row](std::size_t i) {
      return Vector3d(std::stod(row.at(i)), std::stod(row.at(i + 1)), std::stod(row.at(i + 2)));
    };
    const Vector3d half = triple(1) / 2, centre = triple(4);
    const auto ours = boundsOf(model.links[link].collision);
    const double off = std::max((ours.min() - (centre - half)).cwiseAbs().maxCoeff(),
                                (ours.max() - (centre + half)).cwiseAbs().maxCoeff());
    EXPECT_LT(off, 0.01) << row[0];
    worst = std::max(worst, off);
    ++compared;
  }
  EXPECT_EQ(compared, 2 * 17 + 5 + 2 * 13 + 3 * 7);
  EXPECT_LT(worst, 0.003);
}

/// Bounds of the part of some convex shapes that lies within lo..hi of an axis.
Eigen::AlignedBox3d sliceBounds(const std::vector<Shape>& shapes, int axis, double lo, double hi) {
  Eigen::AlignedBox3d bounds;
  for (const Shape& shape : shapes) {
    const auto& hull = std::get<ConvexShape>(shape.geometry);
    for (const auto& t : hull.triangles) {
      for (std::size_t i = 0; i < 3; ++i) {
        const Vector3d a = shape.X_BS * hull.vertices[static_cast<std::size_t>(t[i])];
        const Vector3d b = shape.X_BS * hull.vertices[static_cast<std::size_t>(t[(i + 1) % 3])];
        if (a[axis] >= lo && a[axis] <= hi) bounds.extend(a);
        for (const double cut : {lo, hi}) {
          if ((a[axis] - cut) * (b[axis] - cut) < 0) {
            bounds.extend(Vector3d(a + (cut - a[axis]) / (b[axis] - a[axis]) * (b - a)));
          }
        }
      }
    }
  }
  return bounds;
}

TEST(Links, CoverThePublishedMeshesSliceBySlice) {
  RobotModel model;
  double worst = 0;
  int compared = 0;
  const auto compare = [&](const std::string& link, int axis, Eigen::AlignedBox3d theirs) {
    const LinkId index = model.findLink(link);
    ASSERT_TRUE(index.valid()) << link;
    const auto ours =
        sliceBounds(model.links[index].collision, axis, theirs.min()[axis], theirs.max()[axis]);
    ASSERT_FALSE(ours.isEmpty()) << link;
    // Along the axis itself only the end slices are bounded by the mesh.
    Vector3d short_by = (ours.min() - theirs.min()).cwiseMax(theirs.max() - ours.max());
    short_by[axis] = 0;
    EXPECT_LT(short_by.maxCoeff(), 0.005) << link << " from " << theirs.min()[axis];
    worst = std::max(worst, short_by.maxCoeff());
    ++compared;
  };
  for (const auto& row : testing::readTable(std::filesystem::path(HANDOVER_SOURCE_DIR) /
                                            "tests/robots/link_extents.txt")) {
    if (row[0] == "robot") {
      model = testing::loadBody(row.at(1));
      continue;
    }
    const int axis = row.at(1)[0] - 'x', u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
    Vector3d low, high;
    std::size_t column = 2;
    for (const int coordinate : {axis, u, v}) {
      low[coordinate] = std::stod(row.at(column++)) / 1000;
      high[coordinate] = std::stod(row.at(column++)) / 1000;
    }
    compare(row[0], axis, {low, high});
    if (row[0].starts_with("left_")) {
      compare("right_" + row[0].substr(5), axis, {low, high});
    } else if (row[0].starts_with("Body_L")) {
      const Vector3d mirrored_low(low.x(), -high.y(), low.z());
      const Vector3d mirrored_high(high.x(), -low.y(), high.z());
      compare("Body_R" + row[0].substr(6), axis, {mirrored_low, mirrored_high});
    }
  }
  EXPECT_EQ(compared, 2 * 31 + 21 + 2 * 53);
  EXPECT_LT(worst, 0.004);
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
      {"stool", {-0.200, -0.394, -0.475}, {0.1965, 0.218, 0.605}},
      // Its paws reach down to the floor; the published ones end at -0.386.
      {"dog", {-0.109, -0.266, -0.420}, {0.109, 0.528, 0.277}},
  };
  for (const Row& row : rows) {
    const auto bounds = objectBounds(row.name);
    EXPECT_LT((bounds.min() - row.min).cwiseAbs().maxCoeff(), 1e-3) << row.name;
    EXPECT_LT((bounds.max() - row.max).cwiseAbs().maxCoeff(), 1e-3) << row.name;
  }
}

/// How far a point is outside the nearest of some convex shapes, by their planes.
double outside(const std::vector<Shape>& shapes, const Vector3d& p) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Shape& shape : shapes) {
    const auto& hull = std::get<ConvexShape>(shape.geometry);
    const Vector3d p_S = shape.X_BS.inverse() * p;
    double farthest = -nearest;
    for (const auto& t : hull.triangles) {
      const auto corner = [&](std::size_t i) {
        return hull.vertices[static_cast<std::size_t>(t[i])];
      };
      const Vector3d normal = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
      farthest = std::max(farthest, normal.dot(p_S - corner(0)));
    }
    nearest = std::min(nearest, farthest);
  }
  return nearest;
}

/// Points of the published furniture (ana-GT/commonData @ 258f6e1, objects/) that a simpler shape
/// would leave out.
TEST(Objects, HaveTheFurnituresPartsToo) {
  struct Row {
    const char* name;
    std::vector<Vector3d> points;
  };

  const Row rows[] = {
      // A U handle at each end, the three shelves' edges, the wheels.
      {"cart",
       {{0.026, 0.29, 0.96},
        {0.948, 0.29, 0.96},
        {0.037, 0.033, 0.94},
        {0.959, 0.55, 0.94},
        {0.036, 0.044, 0.5},
        {0.949, 0.54, 0.3},
        {0.034, 0.29, 0.786},
        {0.952, 0.031, 0.816},
        {0.5, 0.553, 0.479},
        {0.5, 0.031, 0.159},
        {-0.011, 0.02, 0.05},
        {0.997, 0.565, 0.05}}},
      // Rails joined by a bar, a brace behind, legs up to 0.42, steps of 38 mm.
      {"stool",
       {{0, 0.11, 0.604},
        {0, 0.15, 0.586},
        {0, 0.137, 0.556},
        {0.1, 0.168, -0.316},
        {-0.19, 0.074, 0.42},
        {0.19, 0.045, 0.36},
        {-0.199, -0.393, -0.474},
        {0, -0.2, 0.013},
        {0, 0.15, 0.275}}},
      // Struts of the posts, legs 25 mm inside the corners, the letters of the sign.
      {"table",
       {{0.192, 0.01, 0.674},
        {0.418, 1.82, 0.674},
        {0.26, 0.02, 0.72},
        {0.305, 0.125, 0.674},
        {0.305, 1.73, 1.89},
        {0.026, 0.026, 0.1},
        {0.583, 1.80, 0.6},
        {0.323, 0.9, 2.1}}},
      {"dog",
       {{0.085, -0.13, 0.276},
        {0, -0.26, 0.1},
        {0.05, -0.09, -0.38},
        {0.108, -0.03, -0.1},
        {0.05, 0.28, -0.38},
        {0, 0.52, 0.11},
        {0, 0.48, 0.148}}},
  };
  for (const Row& row : rows) {
    const auto shapes = readConvexMesh(
        testing::robotsFolder() / "objects" / row.name / (row.name + std::string(".obj")),
        Vector3d::Ones());
    for (const Vector3d& p : row.points) {
      EXPECT_LT(outside(shapes, p), 0.005) << row.name << " " << p.transpose();
    }
    EXPECT_GT(outside(shapes, {3, 0, 0}), 1) << row.name;
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
