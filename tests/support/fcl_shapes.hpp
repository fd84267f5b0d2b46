// SPDX-License-Identifier: Apache-2.0
// Our shapes as FCL's, and FCL's answers by both of its solvers: each is wrong now and then (libccd
// stops early in some pairs of hulls, the other one drifts by up to 2 cm), never both in the same
// way.
#pragma once

#include "core/model/shape.hpp"

#include <memory>

namespace fcl {
template <typename S>
class CollisionGeometry;
}

namespace handover::test {

/// The shape in its own frame, as FCL's (fcl::CollisionGeometryd, whose headers are slow to
/// compile), with its box computed.
std::shared_ptr<fcl::CollisionGeometry<double>> fclGeometry(const Shape& shape);

/// A shape in its body.
class FclShape {
 public:
  explicit FclShape(const Shape& shape);
  ~FclShape();
  FclShape(FclShape&&) noexcept;

  /// A ball round the shape, in the body's frame.
  Eigen::Vector3d ball_middle;
  double ball_radius = 0;

  struct Data;
  std::unique_ptr<Data> data;
};

/// The smaller and the larger answer of the two solvers [m]; -1 stands for an overlap.
struct FclDistance {
  double low = 0, high = 0;
};

FclDistance fclDistance(const FclShape& a, const Pose& X_WA, const FclShape& b, const Pose& X_WB);

/// True when both solvers say that the shapes overlap.
bool fclOverlap(const FclShape& a, const Pose& X_WA, const FclShape& b, const Pose& X_WB);

}  // namespace handover::test
