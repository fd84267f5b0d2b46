// SPDX-License-Identifier: Apache-2.0
// Distance of two convex cores with a proof: a pair of points (no farther apart than this) and a
// separating plane (no nearer than that). Bullet's own solvers give neither, and are wrong by up to
// centimetres in a few of a thousand random pairs of hulls.
#pragma once

#include "core/collision/pair_motion.hpp"
#include "core/model/shape.hpp"

#include <Eigen/Geometry>

#include <array>
#include <variant>
#include <vector>

namespace handover {

struct BoxCore {
  Eigen::Vector3d half;
};

struct CylinderCore {
  double radius, half_length;
};

struct PointCore {};

struct HullCore {
  std::vector<double> x, y, z;  ///< vertices, an even number (the last one twice if need be)
  Eigen::Vector3d middle;       ///< some point inside
};

struct TriangleCore {
  std::array<Eigen::Vector3d, 3> corners;
};

using ConvexCore = std::variant<BoxCore, CylinderCore, PointCore, HullCore, TriangleCore>;

/// What GJK works on of a shape, in the shape's frame: the shape itself; of a sphere, its centre.
struct RoundedCore {
  ConvexCore core;
  double radius = 0;  ///< how far the shape reaches beyond the core [m]
};

RoundedCore coreOf(const Shape& shape);

/// The core's point that is farthest along `direction`, which need not be a unit vector.
Eigen::Vector3d supportPoint(const ConvexCore& core, const Eigen::Vector3d& direction);

struct GjkResult {
  /// No pair of points is nearer than this [m]: by a plane between the cores. 0 when there is none.
  double at_least = 0;
  /// p_Wa and p_Wb are this far apart [m]; 0 when the cores overlap.
  double at_most = 0;
  bool overlap = false;
  bool swept_free = false;  ///< proven of the sweep that was asked for
  Eigen::Vector3d p_Wa = Eigen::Vector3d::Zero(), p_Wb = Eigen::Vector3d::Zero();
  /// From b towards a, not a unit vector: the last line looked along.
  Eigen::Vector3d towards_a_W = Eigen::Vector3d::Zero();
};

/// What a plane between two moving cores is to leave.
struct GjkSweep {
  const PairMotion& motion;
  double radius_a, radius_b;  ///< balls of these about every point of the cores [m]
  double clearance;           ///< to be left between them all along the motion [m]
  /// Of the distance: what a plane has to tell for the search to end, since a better one tells
  /// hardly more. 1: never, the distance is found exactly.
  double agreeing = 0.9;
};

/// Stops as soon as at_least > enough, at_most <= near, or the two agree to 1e-8 m. With a sweep
/// also where at_least > near and: a plane stays between the cores all along the motion, as both
/// are displaced to first order and by `beyond` (then `swept_free`); or no plane can; or the two
/// agree as the sweep has it.
GjkResult gjk(const ConvexCore& a, const Eigen::Isometry3d& X_WA, const ConvexCore& b,
              const Eigen::Isometry3d& X_WB, double enough, double near,
              const GjkSweep* sweep = nullptr);

}  // namespace handover
