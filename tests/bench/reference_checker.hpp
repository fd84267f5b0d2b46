// SPDX-License-Identifier: Apache-2.0
// The same question to other libraries: does a moving arm touch anything that it must not?
#pragma once

#include "core/collision/state_checker.hpp"

#include <memory>

namespace handover::bench {

/// A state checker's scene as plain parts: what its reference is built from.
struct CheckedScene {
  /// By body: its shapes, and where it stands at the start.
  std::vector<std::vector<Shape>> shapes;
  std::vector<Pose> X_WBody;
  /// Bodies that the arm moves. The others stand still.
  std::vector<BodyId> moving;
  /// What counts as a contact.
  BodyPairs pairs{0};
};

class ReferenceChecker {
 public:
  virtual ~ReferenceChecker() = default;
  /// True when no pair touches. `X_WBody` by body; those that stand still are not looked at.
  virtual bool valid(const std::vector<Pose>& X_WBody) = 0;
};

/// Convex shapes; a tree of what stands still, one of what moves; ends at the first contact.
std::unique_ptr<ReferenceChecker> makeFclChecker(const CheckedScene& scene);

/// One world, performDiscreteCollisionDetection; margins, float64 and pairs as ours; what stands
/// still is static, and its boxes are computed once.
std::unique_ptr<ReferenceChecker> makeBulletChecker(const CheckedScene& scene);

}  // namespace handover::bench
