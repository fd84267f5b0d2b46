// SPDX-License-Identifier: Apache-2.0
// Two convex shapes against each other: the only place of the core that knows Bullet.
#pragma once

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

/// True when the shapes with their margins touch: nearer than 2 * kCollisionMargin. A function of
/// the two poses alone, so that verdicts never depend on what was asked before.
bool touching(const NarrowShape& a, const Pose& X_WA, const NarrowShape& b, const Pose& X_WB);

/// How near two shapes are, by a proof: a plane between them that leaves more than `enough` [m]; or
/// none, though their margins are apart; or their margins touch.
enum class Nearness { kApart, kNear, kTouching };

/// @pre enough >= 2 * kCollisionMargin, of the shapes without margins.
Nearness nearness(const NarrowShape& a, const Pose& X_WA, const NarrowShape& b, const Pose& X_WB,
                  double enough);

/// Distance or depth of the shapes themselves, margins taken off.
ShapeDistance shapeDistance(const NarrowShape& a, const Pose& X_WA, const NarrowShape& b,
                            const Pose& X_WB);

}  // namespace handover
