// SPDX-License-Identifier: Apache-2.0
// How a pair of bodies stands to what is lawful for it.
#pragma once

#include "verify/body.hpp"
#include "verify/rules.hpp"

#include <algorithm>
#include <optional>

namespace handover::verify {

/// [m] by which bodies that must not touch may be in one another: the contract forgives it to a
/// checker that samples.
constexpr double kForgiven = 5e-4;
/// [m] of motion below which a pair is not looked at again.
constexpr double kFinest = 5e-4;
/// [m] beyond which boxes around bodies are good enough.
constexpr double kNear = 5e-2;

/// How far the two may move before what they do could become unlawful; negative: it is.
/// @param depth that is allowed; nullopt: they must not touch.
inline double contactRoom(const Body& a, const Pose& X_WA, const Body& b, const Pose& X_WB,
                          std::optional<double> depth, double near = kNear) {
  const Clearance gap = clearance(a, X_WA, b, X_WB, near);
  if (!gap.touching) return gap.distance + depth.value_or(0);
  if (!depth) return partedBy(a, X_WA, b, X_WB, kForgiven) ? 0 : -1;
  const double deep = depthAtLeast(a, X_WA, b, X_WB, *depth);
  return deep > *depth ? -1 : *depth - deep;
}

}  // namespace handover::verify
