// SPDX-License-Identifier: Apache-2.0
#include "fcl_shapes.hpp"

#include <fcl/fcl.h>

#include <algorithm>

namespace handover::test {
namespace {

using Geometry = std::shared_ptr<fcl::CollisionGeometryd>;

struct ToFcl {
  Geometry operator()(const BoxShape& box) const { return std::make_shared<fcl::Boxd>(box.size); }

  Geometry operator()(const SphereShape& s) const {
    return std::make_shared<fcl::Sphered>(s.radius);
  }

  Geometry operator()(const CylinderShape& c) const {
    return std::make_shared<fcl::Cylinderd>(c.radius, c.length);
  }

  Geometry operator()(const ConvexShape& convex) const {
    auto vertices = std::make_shared<std::vector<fcl::Vector3d>>(convex.vertices);
    auto faces = std::make_shared<std::vector<int>>();
    for (const std::array<int, 3>& triangle : convex.triangles) {
      faces->push_back(3);
      faces->insert(faces->end(), triangle.begin(), triangle.end());
    }
    return std::make_shared<fcl::Convexd>(vertices, static_cast<int>(convex.triangles.size()),
                                          faces);
  }
};

double distanceBy(fcl::GJKSolverType solver, const Geometry& a, const Pose& X_WA, const Geometry& b,
                  const Pose& X_WB) {
  fcl::DistanceRequestd request;
  request.gjk_solver_type = solver;
  request.distance_tolerance = 1e-9;
  fcl::DistanceResultd result;
  fcl::distance(a.get(), X_WA, b.get(), X_WB, request, result);
  return result.min_distance;
}

bool overlapBy(fcl::GJKSolverType solver, const Geometry& a, const Pose& X_WA, const Geometry& b,
               const Pose& X_WB) {
  fcl::CollisionRequestd request;
  request.gjk_solver_type = solver;
  fcl::CollisionResultd result;
  return fcl::collide(a.get(), X_WA, b.get(), X_WB, request, result) > 0;
}

}  // namespace

Geometry fclGeometry(const Shape& shape) {
  Geometry geometry = std::visit(ToFcl{}, shape.geometry);
  geometry->computeLocalAABB();
  return geometry;
}

struct FclShape::Data {
  Geometry geometry;
  Pose X_BS;
};

FclShape::FclShape(const Shape& shape) : data(std::make_unique<Data>()) {
  data->geometry = fclGeometry(shape);
  data->X_BS = shape.X_BS;
  ball_middle = shape.X_BS * data->geometry->aabb_center;
  ball_radius = data->geometry->aabb_radius;
}

FclShape::~FclShape() = default;
FclShape::FclShape(FclShape&&) noexcept = default;

FclDistance fclDistance(const FclShape& a, const Pose& X_WA, const FclShape& b, const Pose& X_WB) {
  const Pose X_WSa = X_WA * a.data->X_BS, X_WSb = X_WB * b.data->X_BS;
  const double one = distanceBy(fcl::GST_LIBCCD, a.data->geometry, X_WSa, b.data->geometry, X_WSb);
  const double other = distanceBy(fcl::GST_INDEP, a.data->geometry, X_WSa, b.data->geometry, X_WSb);
  return {std::min(one, other), std::max(one, other)};
}

bool fclOverlap(const FclShape& a, const Pose& X_WA, const FclShape& b, const Pose& X_WB) {
  const Pose X_WSa = X_WA * a.data->X_BS, X_WSb = X_WB * b.data->X_BS;
  return overlapBy(fcl::GST_LIBCCD, a.data->geometry, X_WSa, b.data->geometry, X_WSb) &&
         overlapBy(fcl::GST_INDEP, a.data->geometry, X_WSa, b.data->geometry, X_WSb);
}

}  // namespace handover::test
