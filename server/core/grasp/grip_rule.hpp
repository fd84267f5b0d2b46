// SPDX-License-Identifier: Apache-2.0
// Whether a closed hand grips an object by the contract (design §5, Grip): two points of the
// object's own surface, each within 2 mm of another link of the hand, whose outward normals differ
// by more than 120 degrees.
#pragma once

#include "core/grasp/hand_model.hpp"
#include "core/grasp/object_surface.hpp"

#include <memory>
#include <vector>

namespace handover {

/// Not thread-safe. The object at the origin, with reserve for whoever samples the surface or looks
/// a moment later: points within 1.5 mm, normals more than 125 degrees apart.
class GripRule {
 public:
  /// @param surface  outlives the rule.
  GripRule(const ObjectSurface& surface, const HandModel& hand);

  /// The true surface of a link of the hand.
  const SurfaceTree& link(LinkId link) const { return links_[link]; }

  /// @param X_OL  by link of the hand model.
  bool holds(const std::vector<Pose>& X_OL) const;

 private:
  std::vector<Eigen::Vector3d> normalsFelt(const SurfaceTree& link, const Pose& X_OL) const;

  const ObjectSurface& surface_;
  std::vector<LinkId> finger_links_;
  std::vector<SurfaceTree> links_;  ///< by link
};

}  // namespace handover
