// SPDX-License-Identifier: Apache-2.0
// Convex hulls of points: the only place of the core that knows Qhull.
#pragma once

#include "core/decomposition/triangle_mesh.hpp"

#include <vector>

namespace handover::decomposition {

/// A convex body. `planes` are (unit outward normal, offset): inside where n.p <= offset.
struct Hull {
  TriangleMesh mesh;  ///< closed, outward
  std::vector<Eigen::Vector4d> planes;
  double volume = 0;  ///< [m^3]
};

/// Points that span less than this in some direction are thickened, so that every hull has a
/// volume that collision checking can work with.
inline constexpr double kThinnest = 1.5e-4;  // [m]
/// By this to both sides.
inline constexpr double kThickening = 1e-4;  // [m]

/// The hull of at least one point. Deterministic.
/// @throws std::runtime_error if Qhull fails.
Hull hullOf(std::vector<Eigen::Vector3d> points);

/// A hull round `hull` with fewer planes, none of whose vertices stands more than `slack` [m] out
/// of any plane of `hull`; `hull` itself where that has no fewer vertices.
Hull simplifiedOutward(const Hull& hull, double slack);

}  // namespace handover::decomposition
