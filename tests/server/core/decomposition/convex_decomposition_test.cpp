// SPDX-License-Identifier: Apache-2.0
#include "core/decomposition/convex_decomposition.hpp"

#include "support/meshes.hpp"

#include <gmock/gmock.h>

#include <ctime>
#include <functional>
#include <limits>
#include <random>

namespace handover {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

constexpr double kCovered = 1e-4;  // [m] a point of the mesh may stand out of the parts by this

struct Planes {
  std::vector<Eigen::Vector4d> faces;

  explicit Planes(const TriangleMesh& part) {
    for (const auto& t : part.triangles) {
      const auto at = [&](std::size_t k) { return part.vertices[static_cast<std::size_t>(t[k])]; };
      const Vector3d area = (at(1) - at(0)).cross(at(2) - at(0));
      if (area.norm() < 1e-12) continue;
      const Vector3d normal = area.normalized();
      faces.emplace_back(normal.x(), normal.y(), normal.z(), normal.dot(at(0)));
    }
  }

  /// How far p stands out of the worst plane; negative inside.
  double out(const Vector3d& p) const {
    double most = -std::numeric_limits<double>::infinity();
    for (const auto& face : faces) most = std::max(most, face.head<3>().dot(p) - face[3]);
    return most;
  }
};

double out(const std::vector<Planes>& parts, const Vector3d& p) {
  double least = std::numeric_limits<double>::infinity();
  for (const Planes& part : parts) least = std::min(least, part.out(p));
  return least;
}

std::vector<Planes> planesOf(const std::vector<TriangleMesh>& parts) {
  return {parts.begin(), parts.end()};
}

/// Points spread over a mesh by area.
std::vector<Vector3d> surfacePoints(const TriangleMesh& mesh, int count) {
  std::vector<double> areas;
  for (const auto& t : mesh.triangles) {
    const auto at = [&](std::size_t k) { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
    areas.push_back((at(1) - at(0)).cross(at(2) - at(0)).norm());
  }
  std::mt19937_64 random(7);
  std::discrete_distribution<std::size_t> pick(areas.begin(), areas.end());
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Vector3d> points;
  for (int i = 0; i < count; ++i) {
    const auto& t = mesh.triangles[pick(random)];
    const auto at = [&](std::size_t k) { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
    double u = unit(random), v = unit(random);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    points.push_back(at(0) + u * (at(1) - at(0)) + v * (at(2) - at(0)));
  }
  return points;
}

double triangleDistance(const Vector3d& p, const Vector3d& a, const Vector3d& b,
                        const Vector3d& c) {
  const Vector3d normal = (b - a).cross(c - a);
  const auto beside = [&](const Vector3d& from, const Vector3d& to) {
    return normal.cross(to - from).dot(p - from) < 0;
  };
  if (normal.norm() > 0 && !beside(a, b) && !beside(b, c) && !beside(c, a)) {
    return std::abs(normal.normalized().dot(p - a));
  }
  const auto segment = [&](const Vector3d& from, const Vector3d& to) {
    const Vector3d way = to - from;
    const double s =
        way.squaredNorm() > 0 ? std::clamp(way.dot(p - from) / way.squaredNorm(), 0.0, 1.0) : 0.0;
    return (from + s * way - p).norm();
  };
  return std::min({segment(a, b), segment(b, c), segment(c, a)});
}

double surfaceDistance(const TriangleMesh& mesh, const Vector3d& p) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& t : mesh.triangles) {
    const auto at = [&](std::size_t k) { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
    least = std::min(least, triangleDistance(p, at(0), at(1), at(2)));
  }
  return least;
}

double volumeOf(const TriangleMesh& mesh) {
  double volume = 0;
  for (const auto& t : mesh.triangles) {
    const auto at = [&](std::size_t k) { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
    volume += at(0).dot(at(1).cross(at(2))) / 6;
  }
  return volume;
}

double volumeOf(const std::vector<TriangleMesh>& parts) {
  double volume = 0;
  for (const TriangleMesh& part : parts) volume += volumeOf(part);
  return volume;
}

/// Points of the solid, at least `depth` below its surface.
std::vector<Vector3d> innerPoints(const TriangleMesh& mesh,
                                  const std::function<bool(const Vector3d&)>& inside,
                                  double depth) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& v : mesh.vertices) box.extend(v);
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Vector3d> points;
  for (int i = 0; i < 2000; ++i) {
    const Vector3d part(unit(random), unit(random), unit(random));
    const Vector3d p = box.min() + part.cwiseProduct(box.sizes());
    if (inside(p) && surfaceDistance(mesh, p) > depth) points.push_back(p);
  }
  return points;
}

double radius(const Vector3d& p) { return std::hypot(p.x(), p.y()); }

bool inBox(const Vector3d& p, const Vector3d& low, const Vector3d& high) {
  return (p.array() >= low.array()).all() && (p.array() <= high.array()).all();
}

bool inCup(const Vector3d& p) {
  return p.z() >= 0 && p.z() <= 0.095 && radius(p) <= 0.036 &&
         (p.z() <= 0.004 || radius(p) >= 0.032);
}

bool inBowl(const Vector3d& p) {
  const double r = (p - Vector3d(0, 0, 0.08)).norm();
  return p.z() <= 0.08 && r <= 0.08 && r >= 0.075;
}

bool inAngle(const Vector3d& p) {
  return inBox(p, {0, 0, 0}, {0.1, 0.1, 0.03}) && (p.x() <= 0.02 || p.y() <= 0.02);
}

bool inTorus(const Vector3d& p) { return std::hypot(radius(p) - 0.06, p.z()) <= 0.015; }

bool inHammer(const Vector3d& p) {
  return inBox(p, {-0.05, -0.015, 0.27}, {0.05, 0.015, 0.305}) ||
         (radius(p) <= 0.014 && p.z() >= 0 && p.z() <= 0.30);
}

bool inBoxOrCup(const Vector3d& p) {
  return inBox(p, {0, 0, 0}, {0.04, 0.04, 0.04}) || inCup(p - Vector3d(0.1, 0, 0));
}

TriangleMesh boxAndCup() {
  TriangleMesh two = test::boxMesh({0, 0, 0}, {0.04, 0.04, 0.04});
  test::append(two, test::moved(test::cupMesh(), Pose(Eigen::Translation3d(0.1, 0, 0))));
  return two;
}

/// A body with a formula for what is inside it: of the ideal body, a hair larger than its mesh.
struct Body {
  std::string name;
  TriangleMesh mesh;
  std::function<bool(const Vector3d&)> inside;
  std::size_t most_parts;  ///< as measured, with some room
  double most_volume;      ///< of the parts, as a multiple of the mesh's; 0: it has none
};

std::vector<Body> bodies() {
  return {{"cup", test::cupMesh(), inCup, 48, 1.4},
          {"bowl", test::bowlMesh(), inBowl, 80, 1.5},
          {"angle", test::angleMesh(), inAngle, 2, 1.01},
          {"torus", test::torusMesh(), inTorus, 48, 1.1},
          {"hammer", test::hammerMesh(), inHammer, 6, 1.05},
          {"sphere", test::sphereMesh(0.05), [](const Vector3d& p) { return p.norm() <= 0.05; }, 1,
           1.02},
          {"sheet", test::sheetMesh(), [](const Vector3d&) { return false; }, 16, 0},
          {"box and cup", boxAndCup(), inBoxOrCup, 64, 1.5}};
}

std::vector<TriangleMesh> divided(const TriangleMesh& mesh) {
  const auto parts = convexParts(mesh);
  if (!parts) throw std::runtime_error(parts.error().detail);
  return *parts;
}

struct Placed {
  const char* name;
  Pose X = Pose::Identity();
  double scale = 1;
};

/// What holds for every mesh, here for all bodies placed in one way.
class ConvexPartsOf : public ::testing::TestWithParam<Placed> {};

TEST_P(ConvexPartsOf, CoverTheMeshAndKeepClose) {
  const Placed& placed = GetParam();
  for (const Body& body : bodies()) {
    SCOPED_TRACE(body.name);
    const TriangleMesh mesh = test::moved(body.mesh, placed.X, placed.scale);
    const auto inside = [&](const Vector3d& p) {
      return body.inside(placed.X.inverse() * p / placed.scale);
    };
    const std::vector<TriangleMesh> parts = divided(mesh);
    const std::vector<Planes> planes(parts.begin(), parts.end());
    EXPECT_LE(parts.size(), body.most_parts);

    double uncovered = 0;
    for (const Vector3d& p : surfacePoints(mesh, 4000)) {
      uncovered = std::max(uncovered, out(planes, p));
    }
    for (const Vector3d& p : innerPoints(mesh, inside, 0.002)) {
      uncovered = std::max(uncovered, out(planes, p));
    }
    EXPECT_LE(uncovered, kCovered);

    double farthest = 0, bulge = 0;
    for (const TriangleMesh& part : parts) {
      const auto shell = surfacePoints(part, static_cast<int>(1500 / parts.size()));
      for (std::size_t i = 0; i < shell.size(); ++i) {
        // On the hull, and within it.
        const Vector3d between = 0.5 * (shell[i] + shell[shell.size() - 1 - i]);
        for (const Vector3d& p : {shell[i], between}) {
          if (!inside(p)) farthest = std::max(farthest, surfaceDistance(mesh, p));
        }
      }
      const Planes hull(part);
      for (const Vector3d& v : part.vertices) bulge = std::max(bulge, hull.out(v));
      EXPECT_GT(volumeOf(part), 0);
    }
    EXPECT_LE(farthest, kMostReach);
    EXPECT_LE(bulge, 1e-6) << "not convex, or not outward";
    if (body.most_volume > 0) {
      EXPECT_LE(volumeOf(parts), body.most_volume * volumeOf(mesh));
      EXPECT_GE(volumeOf(parts), 0.9 * volumeOf(mesh));  // the hammer's mesh overlaps itself
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Placements, ConvexPartsOf,
    ::testing::Values(Placed{"AsMade"},
                      Placed{"TurnedAndSmaller",
                             Pose(Eigen::Translation3d(0.3, -0.2, 1) *
                                  Eigen::AngleAxisd(0.7, Vector3d(1, 2, -0.5).normalized())),
                             0.5}),
    [](const auto& placement) { return std::string(placement.param.name); });

const std::vector<TriangleMesh>& cupParts() {
  static const std::vector<TriangleMesh> parts = divided(test::cupMesh());
  return parts;
}

TEST(ConvexParts, LeaveACupOpen) {
  const std::vector<Planes> planes = planesOf(cupParts());
  for (double z = 0.004 + 0.002; z < 0.12; z += 0.001) {
    for (const double x : {0.0, 0.015, 0.030}) {
      for (const double angle : {0.0, 1.0, 2.0, 4.5}) {
        const Vector3d p(x * std::cos(angle), x * std::sin(angle), z);
        EXPECT_GT(out(planes, p), 0) << p.transpose();
      }
    }
  }
}

TEST(ConvexParts, MeetTheOutsideOfACupExactly) {
  for (const TriangleMesh& part : cupParts()) {
    for (const Vector3d& v : part.vertices) EXPECT_LE(radius(v), 0.036 + 1e-9);
  }
}

TEST(ConvexParts, FillWhatIsHidden) {
  TriangleMesh hollow = test::sphereMesh(0.05);
  test::append(hollow, test::sphereMesh(0.04));
  const auto parts = divided(hollow);
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_LT(out(planesOf(parts), Vector3d::Zero()), 0);
}

TEST(ConvexParts, TakeAnyWindingAndDoubledTriangles) {
  const TriangleMesh mesh = test::cupMesh();
  TriangleMesh odd = mesh;
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
    std::swap(odd.triangles[i][0], odd.triangles[i][1]);
    if (i % 2 == 0) odd.triangles.push_back(mesh.triangles[i]);
  }
  const auto parts = divided(odd);
  const std::vector<Planes> planes = planesOf(parts);
  for (const Vector3d& p : surfacePoints(mesh, 1000)) EXPECT_LE(out(planes, p), kCovered);
  EXPECT_GT(out(planes, {0, 0, 0.05}), 0);
  EXPECT_NEAR(volumeOf(parts), volumeOf(cupParts()), 0.05 * volumeOf(mesh));
}

TEST(ConvexParts, AreTheSameEachTime) {
  const auto &once = cupParts(), again = divided(test::cupMesh());
  ASSERT_EQ(once.size(), again.size());
  for (std::size_t i = 0; i < once.size(); ++i) {
    EXPECT_EQ(once[i].vertices, again[i].vertices);
    EXPECT_EQ(once[i].triangles, again[i].triangles);
  }
}

TEST(ConvexParts, TakeSecondsForThousandsOfTriangles) {
  const TriangleMesh mesh = test::cupMesh(64, 0.006);
  ASSERT_GT(mesh.triangles.size(), 5000u);
  const std::clock_t begin = std::clock();
  EXPECT_LE(divided(mesh).size(), 32u);
  EXPECT_LT(std::clock() - begin, 10 * CLOCKS_PER_SEC);  // measured: 0.7 s
}

std::string faultOf(const TriangleMesh& mesh) {
  const auto parts = convexParts(mesh);
  if (parts) return "divided";
  EXPECT_EQ(parts.error().code, ErrorCode::kInvalidInput);
  return parts.error().detail;
}

TEST(ConvexParts, RefuseWhatIsBeyondTheBounds) {
  EXPECT_THAT(faultOf({}), HasSubstr("no triangles"));

  TriangleMesh mesh = test::cupMesh();
  mesh.vertices[3].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(faultOf(mesh), HasSubstr("not finite"));

  EXPECT_THAT(faultOf(test::moved(test::cupMesh(), Pose::Identity(), 30)),
              HasSubstr("too large to be divided into convex parts to 5 mm"));

  mesh = test::cupMesh();
  mesh.triangles.resize(200001, mesh.triangles[0]);
  EXPECT_THAT(faultOf(mesh), HasSubstr("has 200001 triangles"));
}

TEST(ConvexParts, RefuseTooManyParts) {
  TriangleMesh many;
  for (int x = 0; x < 25; ++x) {
    for (int y = 0; y < 25; ++y) {
      const Vector3d at(0.02 * x, 0.02 * y, 0);
      test::append(many, test::boxMesh(at, at + Vector3d(0.002, 0.002, 0.002)));
    }
  }
  EXPECT_THAT(faultOf(many), HasSubstr("more than 512 convex parts"));
}

TEST(ConvexParts, OfASingleTriangleAreThin) {
  const TriangleMesh triangle{{{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}}, {{0, 1, 2}}};
  const auto parts = divided(triangle);
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_NEAR(volumeOf(parts), 0.005 * 0.0002, 1e-9);
}

TEST(ConvexParts, OfPointsAndNeedlesHaveAVolume) {
  EXPECT_GT(volumeOf(divided({{{1, 2, 3}}, {{0, 0, 0}}})), 0);
  EXPECT_GT(volumeOf(divided({{{0, 0, 0}, {0.1, 0.1, 0}, {0.2, 0.2, 0}}, {{0, 1, 2}}})), 0);
}

}  // namespace
}  // namespace handover
