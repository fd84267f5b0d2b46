// SPDX-License-Identifier: Apache-2.0
// An object's surface as it is met from outside: the union of its convex parts.
#pragma once

#include "core/grasp/surface_samples.hpp"

#include <optional>
#include <vector>

namespace handover {

class ObjectSurface {
 public:
  explicit ObjectSurface(std::vector<Shape> shapes_O);

  /// Where the way from `a` to `b` first comes to the surface; nullopt: nowhere, or `a` is inside.
  /// Parts that meet leave no gap between them.
  std::optional<SurfaceSample> firstHit(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const;

  /// Of the parts' volume; where parts overlap it counts twice.
  const Eigen::Vector3d& centre() const { return centre_; }

 private:
  std::vector<Shape> shapes_;
  std::vector<ConvexPart> parts_;  ///< of the shapes, in their order
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
};

}  // namespace handover
