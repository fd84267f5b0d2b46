// SPDX-License-Identifier: Apache-2.0
// Convex parts for meshes that are not convex themselves.
#pragma once

#include "core/decomposition/triangle_mesh.hpp"

#include <handover/common/deadline.hpp>
#include <handover/common/result.hpp>

#include <functional>
#include <vector>

namespace handover {

/// No part reaches farther out of the mesh than this [m].
inline constexpr double kMostReach = 0.005;

/// Convex parts, each closed with outward triangles, that together cover the mesh's surface and
/// what it encloses, and reach at most kMostReach outside. Enclosed is what cannot be reached from
/// outside without passing through the surface, whichever way its triangles are wound: a cup's
/// cavity stays open, a hidden one is filled, an open sheet becomes parts 0.2 mm thick; openings
/// narrower than 1 mm (large meshes: up to 4 mm) count as closed. Between parts, next to the
/// surface, wedges of the inside thinner than a voxel may stay uncovered.
///
/// The solid is cut by planes until every piece's hull fits, then pieces are joined while their
/// common hull still does. Where it takes few parts they keep closer than kMostReach: 1.25 mm, or
/// 2.5 mm. What is convex of the surface is met exactly, but for hulls of many vertices (0.25 mm).
///
/// Deterministic. kInvalidInput, with the reason, for what is beyond the bounds: no triangle, more
/// than 200 000, a vertex that is not finite, a box larger than about 1 m^3, more than 512 parts.
Result<std::vector<TriangleMesh>> convexParts(const TriangleMesh& mesh);

/// The same, given up with kDeadline when the deadline passes or is cancelled.
Result<std::vector<TriangleMesh>> convexPartsWithin(const TriangleMesh& mesh,
                                                    const Deadline& deadline);

/// What convexParts() refuses at once, without dividing; true otherwise.
Result<bool> divisible(const TriangleMesh& mesh);

/// convexParts(), or something that remembers its answers.
using ConvexDecomposer = std::function<Result<std::vector<TriangleMesh>>(const TriangleMesh&)>;

}  // namespace handover
