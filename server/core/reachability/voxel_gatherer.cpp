// SPDX-License-Identifier: Apache-2.0
#include "core/reachability/voxel_gatherer.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

namespace handover::reachability {
namespace {

/// A direction well inside a bin (see directionBin()).
Eigen::Vector3d directionOf(int bin) {
  const double z = (bin / 8 + 0.5) / 4 - 1;
  const double azimuth = (bin % 8 + 0.5) / 8 * 2 * std::numbers::pi - std::numbers::pi;
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(azimuth), r * std::sin(azimuth), z};
}

/// The bins that a mirror makes of these: z stays on z or -z, so each becomes one.
std::uint64_t mirrored(const Eigen::Matrix3d& S, std::uint64_t directions) {
  std::uint64_t image = 0;
  for (int bin = 0; bin < 64; ++bin) {
    if ((directions >> bin & 1) == 0) continue;
    image |= std::uint64_t{1} << directionBin(S * directionOf(bin));
  }
  return image;
}

/// Voxel i of an axis covers [i, i + 1) edges; its image is [-i - 1, -i).
std::array<std::int32_t, 3> mirrored(const Eigen::Matrix3d& S,
                                     const std::array<std::int32_t, 3>& at) {
  std::array<std::int32_t, 3> image{};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      const auto from = at[static_cast<std::size_t>(column)];
      if (S(row, column) > 0) image[static_cast<std::size_t>(row)] = from;
      if (S(row, column) < 0) image[static_cast<std::size_t>(row)] = -from - 1;
    }
  }
  return image;
}

using Place = std::pair<std::array<std::int32_t, 3>, ReachabilityVoxel>;

/// Sorts the voxels into grid order and draws the smallest grid about them.
MapContents arrange(std::vector<Place> places) {
  MapContents contents;
  if (places.empty()) return contents;
  std::sort(places.begin(), places.end(),
            [](const Place& a, const Place& b) { return a.first < b.first; });
  std::size_t cells = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto [low, high] = std::minmax_element(
        places.begin(), places.end(),
        [axis](const Place& a, const Place& b) { return a.first[axis] < b.first[axis]; });
    contents.first[axis] = low->first[axis];
    contents.size[axis] = high->first[axis] - low->first[axis] + 1;
    cells *= static_cast<std::size_t>(contents.size[axis]);
  }
  contents.index.assign(cells, -1);
  contents.voxels.reserve(places.size());
  for (const auto& [at, voxel] : places) {
    std::size_t cell = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      cell = cell * static_cast<std::size_t>(contents.size[axis]) +
             static_cast<std::size_t>(at[axis] - contents.first[axis]);
    }
    contents.index[cell] = static_cast<std::int32_t>(contents.voxels.size());
    contents.voxels.push_back(voxel);
  }
  return contents;
}

ReachabilityVoxel finished(const Gathered& gathered) {
  return {static_cast<float>(gathered.mean()), gathered.samples, gathered.directions,
          gathered.q_best};
}

}  // namespace

double Gathered::variance() const {
  return std::max(0.0, sum_of_squares / samples - mean() * mean());
}

double VoxelGatherer::halfSize(double reach, double voxel) { return std::floor(reach / voxel) + 2; }

VoxelGatherer::VoxelGatherer(double reach, double voxel)
    : half_(static_cast<int>(halfSize(reach, voxel))),
      size_(2 * half_),
      voxel_(voxel),
      index_(static_cast<std::size_t>(size_) * static_cast<std::size_t>(size_) *
                 static_cast<std::size_t>(size_),
             -1) {}

void VoxelGatherer::add(const MapSample& sample) {
  std::array<std::int32_t, 3> at{};
  std::size_t cell = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const int i = static_cast<int>(std::floor(sample.p_A[axis] / voxel_));
    at[static_cast<std::size_t>(axis)] = i;
    cell = cell * static_cast<std::size_t>(size_) + static_cast<std::size_t>(i + half_);
  }
  if (index_[cell] < 0) {
    index_[cell] = static_cast<std::int32_t>(voxels_.size());
    voxels_.emplace_back();
    at_.push_back(at);
  }
  Gathered& voxel = voxels_[static_cast<std::size_t>(index_[cell])];
  voxel.sum += sample.manipulability;
  voxel.sum_of_squares += sample.manipulability * sample.manipulability;
  ++voxel.samples;
  voxel.directions |= std::uint64_t{1} << directionBin(sample.approach_A);
  if (sample.manipulability <= voxel.best) return;
  voxel.best = sample.manipulability;
  for (Eigen::Index i = 0; i < sample.q.size(); ++i) {
    voxel.q_best[static_cast<std::size_t>(i)] = static_cast<float>(sample.q[i]);
  }
}

std::int32_t VoxelGatherer::find(const Eigen::Vector3d& p_A) const {
  std::size_t cell = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double at = std::floor(p_A[axis] / voxel_) + half_;
    if (!(at >= 0 && at < size_)) return -1;
    cell = cell * static_cast<std::size_t>(size_) + static_cast<std::size_t>(at);
  }
  return index_[cell];
}

Eigen::Vector3d VoxelGatherer::centre(std::size_t voxel) const {
  const auto& at = at_.at(voxel);
  return voxel_ * Eigen::Vector3d(at[0] + 0.5, at[1] + 0.5, at[2] + 0.5);
}

MapContents VoxelGatherer::contents() const {
  std::vector<Place> places;
  for (std::size_t v = 0; v < voxels_.size(); ++v) places.push_back({at_[v], finished(voxels_[v])});
  return arrange(std::move(places));
}

MapContents VoxelGatherer::contents(const ArmMirror& mirror) const {
  std::vector<Place> places;
  for (std::size_t v = 0; v < voxels_.size(); ++v) {
    ReachabilityVoxel voxel = finished(voxels_[v]);
    voxel.directions = mirrored(mirror.S_ToFrom, voxel.directions);
    for (Eigen::Index i = 0; i < mirror.sign.size(); ++i) {
      voxel.q_seed[static_cast<std::size_t>(i)] *= static_cast<float>(mirror.sign[i]);
    }
    places.push_back({mirrored(mirror.S_ToFrom, at_[v]), voxel});
  }
  return arrange(std::move(places));
}

}  // namespace handover::reachability
