// SPDX-License-Identifier: Apache-2.0
#include "core/grasp/surface_samples.hpp"

#include "core/grasp/object_surface.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

namespace handover {
namespace {

using Eigen::Vector3d;

constexpr int kAround = 64;     // facets of a circle
constexpr double kSkin = 5e-4;  // a face nearer than this to another part is hidden by it [m]

void addTriangle(ConvexPart& part, int a, int b, int c) { part.triangles.push_back({a, b, c}); }

ConvexPart boxPart(const Vector3d& size) {
  ConvexPart part;
  for (int i = 0; i < 8; ++i) {
    const Vector3d corner((i & 1) != 0 ? 0.5 : -0.5, (i & 2) != 0 ? 0.5 : -0.5,
                          (i & 4) != 0 ? 0.5 : -0.5);
    part.vertices.push_back(corner.cwiseProduct(size));
  }
  constexpr int kFaces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (const auto& f : kFaces) {
    addTriangle(part, f[0], f[1], f[2]);
    addTriangle(part, f[0], f[2], f[3]);
  }
  return part;
}

ConvexPart cylinderPart(double radius, double length) {
  ConvexPart part;
  for (int i = 0; i < kAround; ++i) {
    const double angle = 2.0 * M_PI * i / kAround;
    const Vector3d rim(radius * std::cos(angle), radius * std::sin(angle), 0.5 * length);
    part.vertices.push_back(rim - length * Vector3d::UnitZ());
    part.vertices.push_back(rim);
  }
  for (int i = 0; i < kAround; ++i) {
    const int a = 2 * i;
    const int b = 2 * ((i + 1) % kAround);
    addTriangle(part, a, b, b + 1);
    addTriangle(part, a, b + 1, a + 1);
    if (i < 1 || i + 1 >= kAround) continue;
    addTriangle(part, 0, b, a);
    addTriangle(part, 1, a + 1, b + 1);
  }
  return part;
}

ConvexPart spherePart(double radius) {
  ConvexPart part;
  constexpr int kRings = kAround / 2;
  part.vertices.emplace_back(0, 0, -radius);
  for (int r = 1; r < kRings; ++r) {
    const double tilt = M_PI * r / kRings;
    for (int i = 0; i < kAround; ++i) {
      const double angle = 2.0 * M_PI * i / kAround;
      part.vertices.push_back(radius * Vector3d(std::sin(tilt) * std::cos(angle),
                                                std::sin(tilt) * std::sin(angle), -std::cos(tilt)));
    }
  }
  part.vertices.emplace_back(0, 0, radius);
  const int top = static_cast<int>(part.vertices.size()) - 1;
  const auto at = [](int ring, int i) { return 1 + (ring - 1) * kAround + i % kAround; };
  for (int i = 0; i < kAround; ++i) {
    addTriangle(part, 0, at(1, i + 1), at(1, i));
    addTriangle(part, top, at(kRings - 1, i), at(kRings - 1, i + 1));
    for (int r = 1; r + 1 < kRings; ++r) {
      addTriangle(part, at(r, i), at(r, i + 1), at(r + 1, i + 1));
      addTriangle(part, at(r, i), at(r + 1, i + 1), at(r + 1, i));
    }
  }
  return part;
}

Vector3d areaVector(const ConvexPart& part, const std::array<int, 3>& t) {
  const auto at = [&](std::size_t k) { return part.vertices[static_cast<std::size_t>(t[k])]; };
  return 0.5 * (at(1) - at(0)).cross(at(2) - at(0));
}

void addPlanes(ConvexPart& part) {
  for (const auto& t : part.triangles) {
    const Vector3d a = areaVector(part, t);
    if (a.norm() < 1e-14) continue;
    Eigen::Vector4d plane;
    plane << a.normalized(), 0.0;
    plane[3] = plane.head<3>().dot(part.vertices[static_cast<std::size_t>(t[0])]);
    const bool known = std::any_of(part.planes.begin(), part.planes.end(), [&](const auto& other) {
      return (other - plane).template lpNorm<Eigen::Infinity>() < 1e-7;
    });
    if (!known) part.planes.push_back(plane);
  }
}

/// A triangle of an exact shape or of a divided body.
struct Facet {
  std::array<Vector3d, 3> corners;
  int shape = -1, body = -1;
  double area_before = 0;  // of the facets before it

  Vector3d area() const { return 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]); }
};

std::vector<Facet> facetsOf(const ObjectSurface& surface) {
  std::vector<Facet> facets;
  double area = 0;
  const auto add = [&](const auto& mesh, int shape, int body) {
    for (const auto& t : mesh.triangles) {
      const auto corner = [&](std::size_t k) {
        return mesh.vertices[static_cast<std::size_t>(t[k])];
      };
      facets.push_back({{corner(0), corner(1), corner(2)}, shape, body, area});
      area += facets.back().area().norm();
    }
  };
  for (std::size_t p = 0; p < surface.parts().size(); ++p) {
    add(surface.parts()[p], static_cast<int>(p), -1);
  }
  for (std::size_t b = 0; b < surface.divided().size(); ++b) {
    add(surface.divided()[b].surface, -1, static_cast<int>(b));
  }
  return facets;
}

struct PoolPoint {
  SurfaceSample sample;
  int shape = -1, body = -1;
};

/// `count` points spread by area: stratified over the list of facets, a low-discrepancy sequence
/// within.
std::vector<PoolPoint> poolPoints(const ObjectSurface& surface, int count, std::uint64_t seed) {
  const std::vector<Facet> facets = facetsOf(surface);
  const double area = facets.empty() ? 0 : facets.back().area_before + facets.back().area().norm();
  // The plastic number's R2 sequence, shifted by the seed.
  const double shift = std::fmod(static_cast<double>(seed % 1000003) * 0.6180339887498949, 1.0);
  std::vector<PoolPoint> points;
  std::size_t f = 0;
  for (int i = 0; i < count && area > 0; ++i) {
    const double target = area * (i + 0.5) / count;
    while (f + 1 < facets.size() && facets[f + 1].area_before <= target) ++f;
    double u = std::fmod(shift + 0.7548776662466927 * (i + 1), 1.0);
    double v = std::fmod(shift + 0.5698402909980532 * (i + 1), 1.0);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const auto& [a, b, c] = facets[f].corners;
    SurfaceSample sample{a + u * (b - a) + v * (c - a), facets[f].area().normalized()};
    if (facets[f].shape >= 0) {
      sample =
          ontoShape(surface.tree().shapes()[static_cast<std::size_t>(facets[f].shape)], sample);
    }
    points.push_back({sample, facets[f].shape, facets[f].body});
  }
  return points;
}

bool exposed(const PoolPoint& point, const ObjectSurface& surface, double free_length) {
  const SurfaceSample& s = point.sample;
  const Vector3d near = s.p_O + kSkin * s.n_O, far = s.p_O + free_length * s.n_O;
  for (std::size_t j = 0; j < surface.parts().size(); ++j) {
    if (static_cast<int>(j) == point.shape) continue;
    if (surface.parts()[j].meetsSegment(near, far)) return false;
  }
  bool again = false;
  surface.tree().forEachCrossing(near, far,
                                 [&](const SurfaceTree::Piece&, double) { again = true; });
  return !again && !surface.inside(near, point.shape, point.body);
}

}  // namespace

bool ConvexPart::contains(const Vector3d& p, double depth) const {
  return std::all_of(planes.begin(), planes.end(),
                     [&](const auto& f) { return f.template head<3>().dot(p) <= f[3] - depth; });
}

bool ConvexPart::meetsSegment(const Vector3d& a, const Vector3d& b) const {
  double enter = 0, leave = 1;
  for (const auto& plane : planes) {
    const double at_a = plane.head<3>().dot(a) - plane[3];
    const double at_b = plane.head<3>().dot(b) - plane[3];
    if (at_a > 0 && at_b > 0) return false;
    if (at_a <= 0 && at_b <= 0) continue;
    const double cut = at_a / (at_a - at_b);
    if (at_a > 0) {
      enter = std::max(enter, cut);
    } else {
      leave = std::min(leave, cut);
    }
    if (enter > leave) return false;
  }
  return true;
}

ConvexPart toConvexPart(const Shape& shape) {
  ConvexPart part;
  if (const auto* box = std::get_if<BoxShape>(&shape.geometry)) part = boxPart(box->size);
  if (const auto* sphere = std::get_if<SphereShape>(&shape.geometry))
    part = spherePart(sphere->radius);
  if (const auto* cylinder = std::get_if<CylinderShape>(&shape.geometry)) {
    part = cylinderPart(cylinder->radius, cylinder->length);
  }
  if (const auto* convex = std::get_if<ConvexShape>(&shape.geometry)) {
    part.vertices = convex->vertices;
    part.triangles = convex->triangles;
  }
  for (Vector3d& vertex : part.vertices) vertex = shape.X_BS * vertex;
  addPlanes(part);
  return part;
}

SurfaceSample ontoShape(const Shape& shape, const SurfaceSample& facet) {
  const Vector3d p_S = shape.X_BS.inverse() * facet.p_O;
  const Vector3d n_S = shape.X_BS.linear().transpose() * facet.n_O;
  if (const auto* sphere = std::get_if<SphereShape>(&shape.geometry)) {
    const Vector3d out = p_S.normalized();
    return {shape.X_BS * (sphere->radius * out), shape.X_BS.linear() * out};
  }
  if (const auto* cylinder = std::get_if<CylinderShape>(&shape.geometry)) {
    if (std::abs(n_S.z()) > 0.5) return facet;
    const Vector3d out = Vector3d(p_S.x(), p_S.y(), 0).normalized();
    return {shape.X_BS * (cylinder->radius * out + p_S.z() * Vector3d::UnitZ()),
            shape.X_BS.linear() * out};
  }
  return facet;
}

std::vector<SurfaceSample> sampleSurface(const ObjectSurface& surface,
                                         const SamplingParams& params) {
  std::vector<SurfaceSample> pool;
  for (const PoolPoint& point : poolPoints(surface, params.pool, params.seed)) {
    if (exposed(point, surface, params.free_length)) pool.push_back(point.sample);
  }
  // Greedy farthest points: the next sample is the one farthest from all chosen so far.
  std::vector<SurfaceSample> samples;
  std::vector<double> nearest(pool.size(), std::numeric_limits<double>::infinity());
  std::size_t next = 0;
  while (!pool.empty() && static_cast<int>(samples.size()) < params.wanted && nearest[next] > 0) {
    samples.push_back(pool[next]);
    const Vector3d& p = pool[next].p_O;
    nearest[next] = 0;
    for (std::size_t i = 0; i < pool.size(); ++i) {
      nearest[i] = std::min(nearest[i], (pool[i].p_O - p).squaredNorm());
    }
    next = static_cast<std::size_t>(std::max_element(nearest.begin(), nearest.end()) -
                                    nearest.begin());
  }
  return samples;
}

}  // namespace handover
