// SPDX-License-Identifier: Apache-2.0
#include "core/grasp/object_surface.hpp"

#include <algorithm>
#include <array>

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

class CentreOfVolume {
 public:
  void add(const std::vector<Vector3d>& vertices,
           const std::vector<std::array<int, 3>>& triangles) {
    for (const auto& t : triangles) {
      const auto corner = [&](std::size_t k) { return vertices[static_cast<std::size_t>(t[k])]; };
      const double wedge = corner(0).dot(corner(1).cross(corner(2))) / 6;  // with O's origin
      sum_ += 0.25 * wedge * (corner(0) + corner(1) + corner(2));
      volume_ += wedge;
    }
  }

  Vector3d value() const { return volume_ > 0 ? Vector3d(sum_ / volume_) : sum_; }

 private:
  Vector3d sum_ = Vector3d::Zero();
  double volume_ = 0;
};

}  // namespace

ObjectSurface::ObjectSurface(const SceneObject& object)
    : ObjectSurface(object.shapes, object.divided) {}

ObjectSurface::ObjectSurface(const std::vector<Shape>& shapes_O,
                             std::shared_ptr<const DividedBodies> divided)
    : divided_(divided ? std::move(divided) : std::make_shared<const DividedBodies>()),
      tree_(shapes_O, divided_.get()) {
  for (const Shape& shape : tree_.shapes()) parts_.push_back(toConvexPart(shape));
  const bool closed = std::all_of(divided_->begin(), divided_->end(),
                                  [](const DividedBody& body) { return body.open_edges == 0; });
  CentreOfVolume centre;
  if (closed) {
    for (const ConvexPart& part : parts_) centre.add(part.vertices, part.triangles);
    for (const DividedBody& body : *divided_) {
      centre.add(body.surface.vertices, body.surface.triangles);
    }
  } else {
    for (const Shape& shape : shapes_O) {
      const ConvexPart part = toConvexPart(shape);
      centre.add(part.vertices, part.triangles);
    }
  }
  centre_ = centre.value();
  Eigen::AlignedBox3d box;
  for (const DividedBody& body : *divided_) {
    for (const Vector3d& v : body.surface.vertices) box.extend(v);
  }
  if (!divided_->empty()) reach_ = 1.01 * box.diagonal().norm() + 0.01;
}

std::optional<SurfaceSample> ObjectSurface::firstHit(const Vector3d& a, const Vector3d& b) const {
  std::optional<Entry> first;
  int hit = -1;  // of the exact shapes
  bool is_inside = false;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const auto entry = entryOf(parts_[i], a, b, is_inside);
    if (is_inside) return std::nullopt;
    if (!entry || (first && first->along <= entry->along)) continue;
    first = entry;
    hit = static_cast<int>(i);
  }
  tree_.forEachCrossing(a, b, [&](const SurfaceTree::Piece& piece, double along) {
    if (first && first->along <= along) return;
    const DividedBody& body = (*divided_)[static_cast<std::size_t>(piece.body)];
    first = Entry{along, normalOf(body.surface, piece.triangle)};
    hit = -1;
  });
  if (!first) return std::nullopt;
  const SurfaceSample sample{a + first->along * (b - a), first->normal};
  if (hit >= 0) return ontoShape(tree_.shapes()[static_cast<std::size_t>(hit)], sample);
  // Out of a body, or to the back of a sheet.
  return first->normal.dot(b - a) < 0 ? std::optional(sample) : std::nullopt;
}

bool ObjectSurface::inside(const Vector3d& p, int shape, int body) const {
  for (int i = 0; i < static_cast<int>(parts_.size()); ++i) {
    if (i != shape && parts_[static_cast<std::size_t>(i)].contains(p, 0.0)) return true;
  }
  if (divided_->empty()) return false;
  // A way that runs along no edge of usual meshes passes through a closed surface an odd number of
  // times if it starts inside.
  static const Vector3d kWay = Vector3d(0.5377, 0.7339, 0.4156).normalized();
  std::vector<int> crossings(divided_->size(), 0);
  tree_.forEachCrossing(p, p + reach_ * kWay, [&](const SurfaceTree::Piece& piece, double) {
    ++crossings[static_cast<std::size_t>(piece.body)];
  });
  for (std::size_t i = 0; i < crossings.size(); ++i) {
    if (static_cast<int>(i) == body || (*divided_)[i].open_edges != 0) continue;
    if (crossings[i] % 2 != 0) return true;
  }
  return false;
}

namespace {

/// A body of `inner` within `outer`: surfaces that do not meet are wholly in or wholly out, so one
/// point of each tells.
bool within(const ObjectSurface& inner, const Pose& X_OuterInner, const ObjectSurface& outer) {
  const auto isIn = [&](const Vector3d& p) { return outer.inside(X_OuterInner * p, -1, -1); };
  return std::any_of(inner.parts().begin(), inner.parts().end(),
                     [&](const ConvexPart& part) { return isIn(part.vertices.front()); }) ||
         std::any_of(inner.divided().begin(), inner.divided().end(),
                     [&](const DividedBody& body) { return isIn(body.surface.vertices.front()); });
}

}  // namespace

bool intersect(const ObjectSurface& a, const Pose& X_WA, const ObjectSurface& b, const Pose& X_WB) {
  if (SurfaceTree::distance(a.tree(), X_WA, b.tree(), X_WB, 0)) return true;
  const Pose X_AB = X_WA.inverse() * X_WB;
  return within(b, X_AB, a) || within(a, X_AB.inverse(), b);
}

}  // namespace handover
