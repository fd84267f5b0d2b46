// SPDX-License-Identifier: Apache-2.0
#include "core/decomposition/convex_hull.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <set>
#include <stdexcept>
#include <string>

namespace handover::decomposition {
namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;

Vector3d meanOf(const std::vector<Vector3d>& points) {
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

/// Doubles the points to both sides along every principal axis along which they span too little.
void thicken(std::vector<Vector3d>& points) {
  const Vector3d middle = meanOf(points);
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Vector3d& p : points) spread += (p - middle) * (p - middle).transpose();
  const Eigen::Matrix3d axes =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors();
  for (int k = 0; k < 3; ++k) {
    const Vector3d axis = axes.col(k);
    const auto [low, high] = std::minmax_element(
        points.begin(), points.end(),
        [&axis](const Vector3d& a, const Vector3d& b) { return axis.dot(a) < axis.dot(b); });
    if (axis.dot(*high - *low) >= kThinnest) continue;
    const std::size_t count = points.size();
    for (std::size_t i = 0; i < count; ++i) {
      points.push_back(points[i] + kThickening * axis);
      points[i] -= kThickening * axis;
    }
  }
}

/// One run of Qhull; frees its memory on the way out. Its C++ interface does not compile as C++20.
class Qhull {
 public:
  explicit Qhull(std::vector<Vector3d> points) : points_(std::move(points)) {
    qh_zero(&qh_, stderr);
    char options[] = "qhull Qt";  // facets are triangles
    char* message = nullptr;
    std::size_t length = 0;
    FILE* messages = open_memstream(&message, &length);
    const int failed = qh_new_qhull(&qh_, 3, static_cast<int>(points_.size()), points_[0].data(),
                                    False, options, nullptr, messages);
    std::fclose(messages);
    const std::string text(message, length);
    std::free(message);  // NOLINT
    if (failed == 0) return;
    free();
    throw std::runtime_error("convex hull: " + text);
  }

  Qhull(const Qhull&) = delete;
  Qhull& operator=(const Qhull&) = delete;

  ~Qhull() { free(); }

  Hull hull() {
    for (const facetT* facet = qh_.facet_list; facet != nullptr && facet->next != nullptr;
         facet = facet->next) {
      addFacet(*facet);
    }
    for (const auto& t : hull_.mesh.triangles) {
      hull_.volume += (at(t[0]) - at(0)).dot((at(t[1]) - at(0)).cross(at(t[2]) - at(0))) / 6;
    }
    return std::move(hull_);
  }

 private:
  void free() {
    int current = 0, total = 0;
    qh_freeqhull(&qh_, !qh_ALL);
    qh_memfreeshort(&qh_, &current, &total);
  }

  const Vector3d& at(int i) const { return hull_.mesh.vertices[static_cast<std::size_t>(i)]; }

  int indexOf(const vertexT& vertex) {
    const std::ptrdiff_t point = (vertex.point - points_[0].data()) / 3;
    const auto [known, added] = index_.emplace(point, static_cast<int>(hull_.mesh.vertices.size()));
    if (added) hull_.mesh.vertices.push_back(points_[static_cast<std::size_t>(point)]);
    return known->second;
  }

  void addFacet(const facetT& facet) {
    std::array<int, 3> t{};
    for (std::size_t i = 0; i < 3; ++i) {
      t[i] = indexOf(*static_cast<const vertexT*>(facet.vertices->e[i].p));
    }
    // Qhull lists the corners against the orientation that it names.
    if (!facet.toporient) std::swap(t[1], t[2]);
    hull_.mesh.triangles.push_back(t);
    // The triangles of one flat facet share their normal.
    if (!normals_.insert(facet.normal).second) return;
    hull_.planes.emplace_back(facet.normal[0], facet.normal[1], facet.normal[2], -facet.offset);
  }

  std::vector<Vector3d> points_;
  qhT qh_{};
  std::map<std::ptrdiff_t, int> index_;
  std::set<const coordT*> normals_;
  Hull hull_;
};

Hull qhullOf(std::vector<Vector3d> points) {
  Hull hull = Qhull(std::move(points)).hull();
  if (hull.volume < 0) {
    for (auto& t : hull.mesh.triangles) std::swap(t[1], t[2]);
    hull.volume = -hull.volume;
  }
  return hull;
}

double supportOf(const Hull& hull, const Vector3d& direction) {
  double most = direction.dot(hull.mesh.vertices.front());
  for (const Vector3d& v : hull.mesh.vertices) most = std::max(most, direction.dot(v));
  return most;
}

/// The polytope that planes round `inside` bound: the hull of the dual's faces.
std::vector<Vector3d> cornersOf(const std::vector<Vector4d>& planes, const Vector3d& inside) {
  std::vector<Vector3d> dual;
  for (const Vector4d& plane : planes) {
    dual.push_back(plane.head<3>() / (plane[3] - plane.head<3>().dot(inside)));
  }
  std::vector<Vector3d> corners;
  for (const Vector4d& face : qhullOf(std::move(dual)).planes) {
    if (face[3] <= 0) return {};  // `inside` is on the rim: no bounded polytope
    corners.push_back(inside + face.head<3>() / face[3]);
  }
  return corners;
}

}  // namespace

Hull hullOf(std::vector<Vector3d> points) {
  thicken(points);
  return qhullOf(std::move(points));
}

Hull simplifiedOutward(const Hull& hull, double slack) {
  // Starts from a box; every corner that stands out too far gets the plane that it violates most.
  std::vector<Vector4d> planes;
  for (int k = 0; k < 3; ++k) {
    for (const double sign : {1.0, -1.0}) {
      const Vector3d normal = sign * Vector3d::Unit(k);
      planes.emplace_back(normal.x(), normal.y(), normal.z(), supportOf(hull, normal));
    }
  }
  const Vector3d inside = meanOf(hull.mesh.vertices);
  std::vector<bool> used(hull.planes.size(), false);
  while (planes.size() < hull.planes.size()) {
    const std::vector<Vector3d> corners = cornersOf(planes, inside);
    if (corners.empty()) return hull;
    bool fits = true;
    for (const Vector3d& corner : corners) {
      std::size_t worst = 0;
      double most = slack;
      for (std::size_t i = 0; i < hull.planes.size(); ++i) {
        const double out = hull.planes[i].head<3>().dot(corner) - hull.planes[i][3];
        if (out > most) most = out, worst = i;
      }
      if (most <= slack) continue;
      fits = false;
      if (used[worst]) continue;
      used[worst] = true;
      planes.push_back(hull.planes[worst]);
    }
    if (!fits) continue;
    Hull simple = qhullOf(corners);
    return simple.mesh.vertices.size() < hull.mesh.vertices.size() ? simple : hull;
  }
  return hull;
}

}  // namespace handover::decomposition
