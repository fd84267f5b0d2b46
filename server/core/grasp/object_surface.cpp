// SPDX-License-Identifier: Apache-2.0
#include "core/grasp/object_surface.hpp"

namespace handover {
namespace {

using Eigen::Vector3d;

constexpr double kSeam = 1e-6;  // parts that meet reach so far into each other [m]

/// A point of a way, and the plane through which it enters a part there.
struct Entry {
  double along = 0;  ///< in [0, 1]
  Vector3d normal = Vector3d::Zero();
};

/// Where a way enters a part; `inside` where it begins in there.
std::optional<Entry> entryOf(const ConvexPart& part, const Vector3d& a, const Vector3d& b,
                             bool& inside) {
  Entry enter;
  double leave = 1;
  bool outside = false;
  for (const auto& plane : part.planes) {
    const Vector3d normal = plane.head<3>();
    const double at_a = normal.dot(a) - plane[3] - kSeam;
    const double at_b = normal.dot(b) - plane[3] - kSeam;
    outside = outside || at_a > 0;
    if (at_a > 0 && at_b > 0) return std::nullopt;
    if (at_a <= 0 && at_b <= 0) continue;
    const double cut = at_a / (at_a - at_b);
    if (at_a <= 0) {
      leave = std::min(leave, cut);
    } else if (cut >= enter.along) {
      enter = {cut, normal};
    }
    if (enter.along > leave) return std::nullopt;
  }
  inside = inside || !outside;
  return outside ? std::optional(enter) : std::nullopt;
}

}  // namespace

ObjectSurface::ObjectSurface(std::vector<Shape> shapes_O) : shapes_(std::move(shapes_O)) {
  double volume = 0;
  for (const Shape& shape : shapes_) {
    parts_.push_back(toConvexPart(shape));
    const ConvexPart& part = parts_.back();
    for (const auto& t : part.triangles) {
      const auto corner = [&](std::size_t k) {
        return part.vertices[static_cast<std::size_t>(t[k])];
      };
      const double wedge = corner(0).dot(corner(1).cross(corner(2))) / 6;  // with O's origin
      centre_ += 0.25 * wedge * (corner(0) + corner(1) + corner(2));
      volume += wedge;
    }
  }
  if (volume > 0) centre_ /= volume;
}

std::optional<SurfaceSample> ObjectSurface::firstHit(const Vector3d& a, const Vector3d& b) const {
  std::optional<Entry> first;
  std::size_t hit = 0;
  bool inside = false;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const auto entry = entryOf(parts_[i], a, b, inside);
    if (inside) return std::nullopt;
    if (!entry || (first && first->along <= entry->along)) continue;
    first = entry;
    hit = i;
  }
  if (!first) return std::nullopt;
  return ontoShape(shapes_[hit], {a + first->along * (b - a), first->normal});
}

}  // namespace handover
