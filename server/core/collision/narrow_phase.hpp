// SPDX-License-Identifier: Apache-2.0
// Two convex shapes against each other: the only place of the core that knows Bullet.
#pragma once

#include "core/collision/pair_motion.hpp"
#include "core/model/shape.hpp"

#include <memory>

namespace handover {

/// Every shape is grown outwards by this, rounded off at its edges [m].
inline constexpr double kCollisionMargin = 0.001;

/// One shape as Bullet sees it. Immutable; safe from any thread.
class NarrowShape {
 public:
  /// @throws std::invalid_argument for sizes that are not finite and positive, or no vertices.
  explicit NarrowShape(const Shape& shape);
  ~NarrowShape();
  NarrowShape(NarrowShape&&) noexcept;
  NarrowShape& operator=(NarrowShape&&) noexcept;

  struct Data;

  const Data& data() const { return *data_; }

 private:
  std::unique_ptr<const Data> data_;
};

struct ShapeDistance {
  double distance = 0;  ///< [m] of the shapes without margins; negative: the depth of the overlap
  Eigen::Vector3d p_Wa, p_Wb;
  Eigen::Vector3d n_W;  ///< unit, from b towards a: moving a by -distance * n_W makes them touch
};

/// True when the shapes are nearer than `gap` [m], margins taken off; by default when their margins
/// touch, and that is Bullet's to say where it is not certain. A function of the two poses alone,
/// so that verdicts never depend on what was asked before. @pre 0 < gap.
bool touching(const NarrowShape& a, const Pose& X_WA, const NarrowShape& b, const Pose& X_WB,
              double gap = 2 * kCollisionMargin);

/// How near two shapes come while they move, margins taken off: a plane between them leaves more
/// than `proven` [m] wherever they get; or there is none, though they are farther apart than
/// `looked` as they stand; or not even that.
enum class Nearness { kApart, kNear, kTouching };

/// @pre 0 <= proven <= looked.
Nearness nearness(const NarrowShape& a, const Pose& X_WA, const NarrowShape& b, const Pose& X_WB,
                  const PairMotion& motion, double looked, double proven);

/// Whether it is proven, by a plane between them or by their distance, that two shapes keep more
/// than `apart` [m] while they move, margins taken off.
/// @param at_most  where it is not: they are no farther apart than this as they stand [m], negative
///                 where they overlap; as near to the truth as the answer needs.
bool proveApart(const NarrowShape& a, const Pose& X_WA, const NarrowShape& b, const Pose& X_WB,
                const PairMotion& motion, double apart, double& at_most);

/// Distance or depth of the shapes themselves, margins taken off.
ShapeDistance shapeDistance(const NarrowShape& a, const Pose& X_WA, const NarrowShape& b,
                            const Pose& X_WB);

}  // namespace handover
