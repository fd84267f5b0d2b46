// SPDX-License-Identifier: Apache-2.0
// The voxels of a map while it is sampled.
#pragma once

#include "core/reachability/arm_mirror.hpp"
#include "core/reachability/map_file.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace handover::reachability {

/// What gathers in a voxel.
struct Gathered {
  double sum = 0, sum_of_squares = 0, best = -1;
  std::uint32_t samples = 0;
  std::uint64_t directions = 0;
  std::array<float, 8> q_best{};

  double mean() const { return sum / samples; }

  /// Mean square deviation of a sample from the voxel's mean.
  double variance() const;
};

/// One sample: the tool's position [m] and approach direction in A, its manipulability and q.
struct MapSample {
  Eigen::Vector3d p_A;
  Eigen::Vector3d approach_A;
  double manipulability = 0;
  ArmVector q;
};

/// A map's contents as they go into its file.
struct MapContents {
  std::array<std::int32_t, 3> first{}, size{};
  std::vector<std::int32_t> index;
  std::vector<ReachabilityVoxel> voxels;
};

/// A grid about A's origin that holds every tool position; voxels get their number when first
/// reached.
class VoxelGatherer {
 public:
  /// Half the grid's edge in voxels, for an arm that reaches that far [m].
  static double halfSize(double reach, double voxel);

  VoxelGatherer(double reach, double voxel);

  void add(const MapSample& sample);

  /// The number of the voxel at a point in A; -1: not reached, or outside the grid.
  std::int32_t find(const Eigen::Vector3d& p_A) const;

  const std::vector<Gathered>& voxels() const { return voxels_; }

  /// The centre of a voxel, in A [m].
  Eigen::Vector3d centre(std::size_t voxel) const;

  /// The filled part of the grid, in grid order.
  MapContents contents() const;
  /// The same for the arm that is the image: voxels, directions and configurations mirrored, the
  /// figures untouched.
  MapContents contents(const ArmMirror& mirror) const;

 private:
  int half_, size_;
  double voxel_;
  std::vector<std::int32_t> index_;
  std::vector<Gathered> voxels_;
  std::vector<std::array<std::int32_t, 3>> at_;  ///< of each voxel: (i, j, k)
};

}  // namespace handover::reachability
