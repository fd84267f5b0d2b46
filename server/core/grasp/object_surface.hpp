// SPDX-License-Identifier: Apache-2.0
// An object's own surface, as it is met from outside: convex shapes that meet it exactly, and the
// triangles of bodies that had to be divided.
#pragma once

#include "core/collision/surface_tree.hpp"
#include "core/grasp/surface_samples.hpp"
#include "core/model/scene.hpp"

#include <memory>
#include <optional>
#include <vector>

namespace handover {

class ObjectSurface {
 public:
  explicit ObjectSurface(const SceneObject& object);
  /// @param divided  of `shapes_O`; null: these are the object.
  explicit ObjectSurface(const std::vector<Shape>& shapes_O,
                         std::shared_ptr<const DividedBodies> divided = nullptr);

  /// Where the way from `a` to `b` first comes to the surface; nullopt: nowhere, or `a` is inside.
  /// Parts that meet leave no gap between them.
  std::optional<SurfaceSample> firstHit(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const;

  /// Of the volume: of what the surface encloses where all of it is closed, else of the parts;
  /// where bodies overlap it counts twice.
  const Eigen::Vector3d& centre() const { return centre_; }

  /// Whether the point is in a body that the surface encloses, other than the exact shape `shape`
  /// and the divided body `body` (-1: none is left out).
  bool inside(const Eigen::Vector3d& p, int shape, int body) const;

  const SurfaceTree& tree() const { return tree_; }

  /// tree().shapes() as triangles and planes, in their order.
  const std::vector<ConvexPart>& parts() const { return parts_; }

  const DividedBodies& divided() const { return *divided_; }

 private:
  std::shared_ptr<const DividedBodies> divided_;  ///< never null
  SurfaceTree tree_;
  std::vector<ConvexPart> parts_;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  double reach_ = 0;  ///< a way of this length leaves every box that it starts in [m]
};

/// Whether what two surfaces enclose has points in common, surfaces included.
bool intersect(const ObjectSurface& a, const Pose& X_WA, const ObjectSurface& b, const Pose& X_WB);

}  // namespace handover
