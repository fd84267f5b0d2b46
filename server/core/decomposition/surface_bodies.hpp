// SPDX-License-Identifier: Apache-2.0
// The bodies that a surface made of triangles bounds: what hangs together is one.
#pragma once

#include "core/decomposition/triangle_mesh.hpp"

#include <vector>

namespace handover {

/// A connected piece of a surface.
struct SurfaceBody {
  /// Wound the same way all over where every edge has two triangles; outward where it is closed.
  TriangleMesh mesh;
  int open_edges = 0;  ///< edges that have not exactly two triangles; 0: closed
};

/// The bodies of some pieces of one surface, whose vertices are merged: the pieces that a file's
/// materials cut it into. Every connected piece that is closed is a body of its own, also where
/// others touch it. What is open is joined across the pieces and divided anew; of what is open even
/// then, all whose boxes meet are one body. More than 512 bodies count as one. Triangles with a
/// corner twice are left out. Deterministic: in the order of the pieces and their first triangles,
/// what is closed within a piece before the rest.
/// @param pieces  vertices of the same place have equal coordinates.
std::vector<SurfaceBody> bodiesOf(const std::vector<TriangleMesh>& pieces);

/// What the triangles enclose [m^3]; negative where they are wound inward.
double signedVolume(const TriangleMesh& mesh);

}  // namespace handover
