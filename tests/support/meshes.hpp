// SPDX-License-Identifier: Apache-2.0
// Meshes that are not convex, made from formulas. Metres.
#pragma once

#include "core/decomposition/triangle_mesh.hpp"

#include <handover/common/pose.hpp>

#include <Eigen/Geometry>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

namespace handover::test {

inline void append(TriangleMesh& mesh, const TriangleMesh& other) {
  const int base = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const auto& t : other.triangles) {
    mesh.triangles.push_back({base + t[0], base + t[1], base + t[2]});
  }
}

inline TriangleMesh boxMesh(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.emplace_back(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(),
                               i & 4 ? high.z() : low.z());
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

/// A profile of (radius, z) turned about z. Closed when it begins and ends on the axis, or when
/// `ring` joins its ends.
inline TriangleMesh lathe(const std::vector<Eigen::Vector2d>& profile, int around,
                          bool ring = false) {
  TriangleMesh mesh;
  std::vector<std::vector<int>> rows;
  for (const auto& point : profile) {
    std::vector<int>& row = rows.emplace_back();
    for (int i = 0; i < around; ++i) {
      if (point.x() > 0 || i == 0) {
        const double angle = 2 * std::numbers::pi * i / around;
        mesh.vertices.emplace_back(point.x() * std::cos(angle), point.x() * std::sin(angle),
                                   point.y());
      }
      row.push_back(static_cast<int>(mesh.vertices.size()) - 1);
    }
  }
  const std::size_t bands = profile.size() - (ring ? 0 : 1);
  for (std::size_t r = 0; r < bands; ++r) {
    const auto &low = rows[r], &high = rows[(r + 1) % rows.size()];
    for (std::size_t i = 0; i < low.size(); ++i) {
      const std::size_t j = (i + 1) % low.size();
      if (low[i] != low[j]) mesh.triangles.push_back({low[i], low[j], high[j]});
      if (high[i] != high[j]) mesh.triangles.push_back({low[i], high[j], high[i]});
    }
  }
  return mesh;
}

/// Points between those of a profile, so that no step is longer than `step`.
inline std::vector<Eigen::Vector2d> refined(const std::vector<Eigen::Vector2d>& profile,
                                            double step) {
  std::vector<Eigen::Vector2d> fine{profile.front()};
  for (std::size_t i = 1; i < profile.size(); ++i) {
    const Eigen::Vector2d way = profile[i] - profile[i - 1];
    const int count = std::max(1, static_cast<int>(std::ceil(way.norm() / step)));
    for (int k = 1; k <= count; ++k) fine.push_back(profile[i - 1] + way * k / count);
  }
  return fine;
}

/// A cup of 72 mm by 95 mm, its walls and bottom 4 mm, open at the top: the bottom at z 0.
inline TriangleMesh cupMesh(int around = 48, double step = 1) {
  return lathe(
      refined({{0, 0}, {0.036, 0}, {0.036, 0.095}, {0.032, 0.095}, {0.032, 0.004}, {0, 0.004}},
              step),
      around);
}

inline TriangleMesh bowlMesh() {
  std::vector<Eigen::Vector2d> profile;
  for (int i = 0; i <= 12; ++i) {
    const double tilt = std::numbers::pi / 2 * i / 12;
    profile.emplace_back(i == 0 ? 0 : 0.08 * std::sin(tilt), 0.08 - 0.08 * std::cos(tilt));
  }
  for (int i = 12; i >= 0; --i) {
    const double tilt = std::numbers::pi / 2 * i / 12;
    profile.emplace_back(i == 0 ? 0 : 0.075 * std::sin(tilt), 0.08 - 0.075 * std::cos(tilt));
  }
  return lathe(profile, 48);
}

inline TriangleMesh torusMesh(double ring = 0.06, double tube = 0.015) {
  std::vector<Eigen::Vector2d> profile;
  for (int i = 0; i < 24; ++i) {
    const double angle = 2 * std::numbers::pi * i / 24;
    profile.emplace_back(ring + tube * std::cos(angle), tube * std::sin(angle));
  }
  return lathe(profile, 48, true);
}

inline TriangleMesh sphereMesh(double radius, int around = 48) {
  std::vector<Eigen::Vector2d> profile;
  for (int i = 0; i <= around / 2; ++i) {
    const double tilt = 2 * std::numbers::pi * i / around;
    const bool pole = i == 0 || i == around / 2;
    profile.emplace_back(pole ? 0 : radius * std::sin(tilt), -radius * std::cos(tilt));
  }
  return lathe(profile, around);
}

/// A closed prism over a polygon in (x, y), star-shaped seen from its first corner.
inline TriangleMesh prism(const std::vector<Eigen::Vector2d>& polygon, double height) {
  TriangleMesh mesh;
  const int n = static_cast<int>(polygon.size());
  for (const double z : {0.0, height}) {
    for (const auto& p : polygon) mesh.vertices.emplace_back(p.x(), p.y(), z);
  }
  for (int i = 1; i + 1 < n; ++i) {
    mesh.triangles.push_back({0, i + 1, i});
    mesh.triangles.push_back({n, n + i, n + i + 1});
  }
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    mesh.triangles.push_back({i, j, n + j});
    mesh.triangles.push_back({i, n + j, n + i});
  }
  return mesh;
}

/// Legs of 0.1 m, 20 mm thick; the inner corner is the polygon's first.
inline TriangleMesh angleMesh() {
  return prism({{0.02, 0.02}, {0.02, 0.1}, {0, 0.1}, {0, 0}, {0.1, 0}, {0.1, 0.02}}, 0.03);
}

/// A round handle of 0.3 m through a head of 0.1 m: two closed surfaces through each other.
inline TriangleMesh hammerMesh() {
  TriangleMesh mesh = lathe({{0, 0}, {0.014, 0}, {0.014, 0.30}, {0, 0.30}}, 32);
  append(mesh, boxMesh({-0.05, -0.015, 0.27}, {0.05, 0.015, 0.305}));
  return mesh;
}

/// A quarter of a pipe of no thickness.
inline TriangleMesh sheetMesh() {
  TriangleMesh mesh;
  constexpr int kSteps = 24;
  for (int i = 0; i <= kSteps; ++i) {
    const double angle = std::numbers::pi / 2 * i / kSteps;
    for (const double z : {0.0, 0.1}) {
      mesh.vertices.emplace_back(0.1 * std::cos(angle), 0.1 * std::sin(angle), z);
    }
  }
  for (int i = 0; i < kSteps; ++i) {
    mesh.triangles.push_back({2 * i, 2 * i + 2, 2 * i + 3});
    mesh.triangles.push_back({2 * i, 2 * i + 3, 2 * i + 1});
  }
  return mesh;
}

inline TriangleMesh moved(TriangleMesh mesh, const Pose& X, double scale = 1) {
  for (Eigen::Vector3d& v : mesh.vertices) v = X * (scale * v);
  return mesh;
}

/// ASCII STL: single triangles, in the unit of the mesh.
inline std::string stlText(const TriangleMesh& mesh) {
  std::string text = "solid mesh\n";
  char line[128];
  for (const auto& t : mesh.triangles) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const int corner : t) {
      const Eigen::Vector3d& v = mesh.vertices[static_cast<std::size_t>(corner)];
      std::snprintf(line, sizeof line, "vertex %.9g %.9g %.9g\n", v.x(), v.y(), v.z());
      text += line;
    }
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid mesh\n";
}

}  // namespace handover::test
