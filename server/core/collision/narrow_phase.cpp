// SPDX-License-Identifier: Apache-2.0
#include "core/collision/narrow_phase.hpp"

#include "core/collision/gjk.hpp"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpa2.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>

#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace handover {

static_assert(sizeof(btScalar) == sizeof(double),
              "Bullet in single precision misses true overlaps");

struct NarrowShape::Data {
  std::unique_ptr<const btConvexShape> shape;
  /// What GJK works on: the shape itself; of a sphere, its centre.
  ConvexCore core;
  /// How far the real shape reaches beyond its core.
  double radius = 0;
};

namespace {

// Boxes and cylinders have their margin inside their size in Bullet: given one margin more, the
// core is exactly the real shape. Hulls have theirs outside. A sphere is all margin round its
// centre.
struct BulletShape {
  std::unique_ptr<const btConvexShape> operator()(const BoxShape& box) const {
    const Eigen::Vector3d half = 0.5 * box.size + Eigen::Vector3d::Constant(kCollisionMargin);
    auto shape = std::make_unique<btBoxShape>(btVector3(half.x(), half.y(), half.z()));
    shape->setMargin(kCollisionMargin);
    return shape;
  }

  std::unique_ptr<const btConvexShape> operator()(const CylinderShape& cylinder) const {
    const double radius = cylinder.radius + kCollisionMargin;
    const double half_length = 0.5 * cylinder.length + kCollisionMargin;
    auto shape = std::make_unique<btCylinderShapeZ>(btVector3(radius, radius, half_length));
    shape->setMargin(kCollisionMargin);
    return shape;
  }

  std::unique_ptr<const btConvexShape> operator()(const SphereShape& sphere) const {
    return std::make_unique<btSphereShape>(sphere.radius + kCollisionMargin);
  }

  std::unique_ptr<const btConvexShape> operator()(const ConvexShape& convex) const {
    auto shape = std::make_unique<btConvexHullShape>();
    for (const Eigen::Vector3d& v : convex.vertices) {
      shape->addPoint(btVector3(v.x(), v.y(), v.z()), false);
    }
    // The margin first: the cached box keeps the 4 cm it is born with otherwise.
    shape->setMargin(kCollisionMargin);
    shape->recalcLocalAabb();
    return shape;
  }
};

struct SizesAreGood {
  bool operator()(const BoxShape& box) const {
    return box.size.allFinite() && (box.size.array() > 0).all();
  }

  bool operator()(const SphereShape& s) const { return std::isfinite(s.radius) && s.radius > 0; }

  bool operator()(const CylinderShape& c) const {
    return std::isfinite(c.radius) && std::isfinite(c.length) && c.radius > 0 && c.length > 0;
  }

  bool operator()(const ConvexShape& convex) const {
    for (const Eigen::Vector3d& v : convex.vertices) {
      if (!v.allFinite()) return false;
    }
    return !convex.vertices.empty();
  }
};

btTransform toBullet(const Pose& X) {
  const auto& m = X.matrix();
  return btTransform(
      btMatrix3x3(m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)),
      btVector3(m(0, 3), m(1, 3), m(2, 3)));
}

// Bullet's verdict, margins included: GJK, and EPA where the cores overlap.
bool bulletTouching(const btConvexShape& a, const Pose& X_WA, const btConvexShape& b,
                    const Pose& X_WB) {
  btVoronoiSimplexSolver simplex;
  btGjkEpaPenetrationDepthSolver penetration;
  btGjkPairDetector detector(&a, &b, &simplex, &penetration);
  detector.setCachedSeparatingAxis(btVector3(0, 1, 0));
  btGjkPairDetector::ClosestPointInput input;
  input.m_transformA = toBullet(X_WA);
  input.m_transformB = toBullet(X_WB);
  btPointCollector found;
  detector.getClosestPoints(input, found, nullptr);
  return found.m_hasResult && found.m_distance <= 0;
}

// How far A must go along `n_W` (unit) to be clear of B: no less than the depth of the overlap.
double clearance(const NarrowShape::Data& a, const Pose& X_WA, const NarrowShape::Data& b,
                 const Pose& X_WB, const Eigen::Vector3d& n_W, ShapeDistance& out) {
  out.n_W = n_W;
  out.p_Wa = X_WA * supportPoint(a.core, X_WA.linear().transpose() * -n_W);
  out.p_Wb = X_WB * supportPoint(b.core, X_WB.linear().transpose() * n_W);
  out.distance = n_W.dot(out.p_Wa - out.p_Wb);
  return -out.distance;
}

// Bullet's EPA asked from several sides: the least of the clearances that its normals really have.
ShapeDistance coreDepth(const NarrowShape::Data& a, const Pose& X_WA, const NarrowShape::Data& b,
                        const Pose& X_WB, const Eigen::Vector3d& towards_a_W) {
  const btTransform W_A = toBullet(X_WA), W_B = toBullet(X_WB);
  const btVector3 apart = W_A.getOrigin() - W_B.getOrigin();
  const std::array<btVector3, 4> guesses{apart, btVector3(1, 0, 0), btVector3(0, 1, 0),
                                         btVector3(0, 0, 1)};
  ShapeDistance best;
  double least = std::numeric_limits<double>::infinity();
  const auto consider = [&](const Eigen::Vector3d& direction) {
    const double length = direction.norm();
    if (!(length > 1e-12)) return;
    ShapeDistance it;
    const double depth = clearance(a, X_WA, b, X_WB, direction / length, it);
    if (depth >= least) return;
    least = depth;
    best = it;
  };
  for (const btVector3& guess : guesses) {
    btGjkEpaSolver2::sResults epa;
    if (!btGjkEpaSolver2::Penetration(a.shape.get(), W_A, b.shape.get(), W_B, guess, epa, false)) {
      continue;
    }
    // In the frame of A; not the line of the witnesses, which is none when they just touch.
    consider(X_WA.linear() * Eigen::Vector3d(epa.normal.x(), epa.normal.y(), epa.normal.z()));
  }
  consider(towards_a_W);
  // Of shapes that only just touch EPA may know none of the normals.
  const Eigen::Matrix3d upright = Eigen::Matrix3d::Identity();
  for (const Eigen::Matrix3d& axes : {upright, X_WA.linear().eval(), X_WB.linear().eval()}) {
    for (int axis = 0; axis < 3; ++axis) {
      consider(axes.col(axis));
      consider(-axes.col(axis));
    }
  }
  return best;
}

}  // namespace

NarrowShape::NarrowShape(const Shape& shape) {
  if (!std::visit(SizesAreGood{}, shape.geometry)) {
    throw std::invalid_argument("a collision shape's sizes must be finite and positive");
  }
  auto data = std::make_unique<Data>();
  data->shape = std::visit(BulletShape{}, shape.geometry);
  RoundedCore rounded = coreOf(shape);
  data->core = std::move(rounded.core);
  data->radius = rounded.radius;
  data_ = std::move(data);
}

NarrowShape::~NarrowShape() = default;
NarrowShape::NarrowShape(NarrowShape&&) noexcept = default;
NarrowShape& NarrowShape::operator=(NarrowShape&&) noexcept = default;

bool touching(const NarrowShape& a, const Pose& X_WA, const NarrowShape& b, const Pose& X_WB,
              double gap) {
  const double reach = a.data().radius + b.data().radius + gap;
  const GjkResult cores = gjk(a.data().core, X_WA, b.data().core, X_WB, reach, reach);
  if (cores.at_least > reach) return false;  // a plane lies between: certain
  if (cores.at_most <= reach)
    return true;  // two points are that near: certain, also where Bullet misses it
  return gap != 2 * kCollisionMargin ||
         bulletTouching(*a.data().shape, X_WA, *b.data().shape, X_WB);
}

Nearness nearness(const NarrowShape& a, const Pose& X_WA, const NarrowShape& b, const Pose& X_WB,
                  const PairMotion& motion, double looked, double proven) {
  const double radii = a.data().radius + b.data().radius;
  const double touch = radii + looked;
  const double apart = radii + std::max(looked, motion.most + proven);
  const GjkSweep sweep{motion, a.data().radius, b.data().radius, proven};
  const GjkResult cores = gjk(a.data().core, X_WA, b.data().core, X_WB, apart, touch, &sweep);
  if (cores.swept_free || cores.at_least > apart) return Nearness::kApart;
  if (cores.at_least > touch) return Nearness::kNear;
  if (cores.at_most <= touch || looked != 2 * kCollisionMargin) return Nearness::kTouching;
  return bulletTouching(*a.data().shape, X_WA, *b.data().shape, X_WB) ? Nearness::kTouching
                                                                      : Nearness::kNear;
}

bool proveApart(const NarrowShape& a, const Pose& X_WA, const NarrowShape& b, const Pose& X_WB,
                const PairMotion& motion, double apart, double& at_most) {
  const double radii = a.data().radius + b.data().radius;
  const double enough = radii + motion.most + apart;
  const GjkSweep sweep{motion, a.data().radius, b.data().radius, apart, 1.0};
  const GjkResult cores = gjk(a.data().core, X_WA, b.data().core, X_WB, enough, -1, &sweep);
  at_most = cores.at_most - radii;
  return cores.swept_free || cores.at_least > enough;
}

ShapeDistance shapeDistance(const NarrowShape& a, const Pose& X_WA, const NarrowShape& b,
                            const Pose& X_WB) {
  const double infinity = std::numeric_limits<double>::infinity();
  const GjkResult cores = gjk(a.data().core, X_WA, b.data().core, X_WB, infinity, -1);
  ShapeDistance out;
  if (cores.overlap) {
    out = coreDepth(a.data(), X_WA, b.data(), X_WB, cores.towards_a_W);
  } else {
    out.distance = cores.at_most;
    out.n_W = (cores.p_Wa - cores.p_Wb).normalized();
    out.p_Wa = cores.p_Wa;
    out.p_Wb = cores.p_Wb;
  }
  out.distance -= a.data().radius + b.data().radius;
  out.p_Wa -= a.data().radius * out.n_W;
  out.p_Wb += b.data().radius * out.n_W;
  return out;
}

}  // namespace handover
