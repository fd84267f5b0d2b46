// SPDX-License-Identifier: Apache-2.0
// Even samples on the surface of an object ([paper] §V).
#pragma once

#include "core/model/shape.hpp"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <vector>

namespace handover {

/// A convex part as a closed triangle mesh with its face planes, in the object's frame.
struct ConvexPart {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<int, 3>> triangles;  ///< outward
  std::vector<Eigen::Vector4d> planes;        ///< (unit normal, offset): inside where n.p <= offset

  /// True where `p` is deeper than `depth` inside (negative: also that far outside).
  bool contains(const Eigen::Vector3d& p, double depth) const;
  /// True if the segment from a to b passes through the part.
  bool meetsSegment(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const;
};

/// The shape's surface as triangles; round shapes as inscribed facets (64 around).
ConvexPart toConvexPart(const Shape& shape);

struct SurfaceSample {
  Eigen::Vector3d p_O;
  Eigen::Vector3d n_O;  ///< outward
};

/// Puts a point of an inscribed facet back onto the round shape that it stands for, with its
/// normal.
SurfaceSample ontoShape(const Shape& shape, const SurfaceSample& facet);

struct SamplingParams {
  int pool = 8000;            ///< points spread by area over all parts, before the hidden ones go
  int wanted = 1500;          ///< at most so many samples
  double free_length = 0.10;  ///< a palm must be able to come along the normal from so far [m]
  std::uint64_t seed = 1;
};

class ObjectSurface;

/// Samples in farthest-point order, so that every prefix is even over the surface. Dropped are
/// points inside or on another body, and points whose normal meets the object again within
/// `free_length` (the inside of a cup). Deterministic.
std::vector<SurfaceSample> sampleSurface(const ObjectSurface& surface,
                                         const SamplingParams& params);

}  // namespace handover
