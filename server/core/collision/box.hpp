// SPDX-License-Identifier: Apache-2.0
// Boxes round shapes, for the tests that come first; shared by the sources of this module only.
#pragma once

#include "core/collision/scene_data.hpp"

#include <limits>

namespace handover {

/// An axis-aligned box in world. Its faces are touched as well.
struct Aabb {
  Eigen::Vector3d lower = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d upper = Eigen::Vector3d::Constant(-std::numeric_limits<double>::infinity());

  void add(const Aabb& other) {
    lower = lower.cwiseMin(other.lower);
    upper = upper.cwiseMax(other.upper);
  }

  void grow(double by) {
    lower.array() -= by;
    upper.array() += by;
  }
};

inline bool overlap(const Aabb& a, const Aabb& b) {
  return a.lower.x() <= b.upper.x() && b.lower.x() <= a.upper.x() && a.lower.y() <= b.upper.y() &&
         b.lower.y() <= a.upper.y() && a.lower.z() <= b.upper.z() && b.lower.z() <= a.upper.z();
}

/// Squared distance of two boxes: 0 when they overlap.
inline double squaredGap(const Aabb& a, const Aabb& b) {
  const Eigen::Vector3d gap = (a.lower - b.upper).cwiseMax(b.lower - a.upper).cwiseMax(0.0);
  return gap.squaredNorm();
}

/// Round a shape of a body, margins included.
inline Aabb worldBox(const Pose& X_WBody, const SceneShape& shape) {
  const Eigen::Matrix3d R = X_WBody.linear() * shape.X_BBox.linear();
  const Eigen::Vector3d half = R.cwiseAbs() * shape.box_half;
  const Eigen::Vector3d middle = X_WBody * shape.X_BBox.translation();
  Aabb box;
  box.lower = middle - half;
  box.upper = middle + half;
  return box;
}

}  // namespace handover
