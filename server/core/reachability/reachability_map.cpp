// SPDX-License-Identifier: Apache-2.0
#include "core/reachability/reachability_map.hpp"

#include "core/reachability/map_file.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace handover {

int directionBin(const Eigen::Vector3d& direction_A) {
  // Slices of equal height have equal area on the sphere.
  const double height = (direction_A.z() + 1) * 4;
  const double azimuth = std::atan2(direction_A.y(), direction_A.x());
  const double turn = (azimuth + std::numbers::pi) / (2 * std::numbers::pi) * 8;
  const int slice = std::clamp(static_cast<int>(height), 0, 7);
  return 8 * slice + std::clamp(static_cast<int>(turn), 0, 7);
}

struct ReachabilityMap::Data {
  std::vector<std::byte> bytes;  ///< of the file when it was opened
  reachability::FileHeader header;
  const std::int32_t* index = nullptr;
  const ReachabilityVoxel* voxels = nullptr;
};

ReachabilityMap::ReachabilityMap() : data_(std::make_unique<Data>()) {}

ReachabilityMap::~ReachabilityMap() = default;

Result<std::shared_ptr<const ReachabilityMap>> ReachabilityMap::open(
    const std::filesystem::path& file, std::uint64_t expected_hash) {
  auto read = reachability::readMapFile(file);
  if (!read) return read.error();
  auto map = of(std::move(*read), expected_hash);
  if (!map) return Error{map.error().code, file.string() + ": " + map.error().detail};
  return map;
}

Result<std::shared_ptr<const ReachabilityMap>> ReachabilityMap::of(std::vector<std::byte> bytes,
                                                                   std::uint64_t expected_hash) {
  const auto header = reachability::checkMapFile(bytes, expected_hash);
  if (!header) return header.error();
  const std::shared_ptr<ReachabilityMap> map(new ReachabilityMap);
  Data& data = *map->data_;
  data.bytes = std::move(bytes);
  data.header = *header;
  const auto& size = data.header.size;
  const auto layout = reachability::layoutOf(
      std::uint64_t(size[0]) * std::uint64_t(size[1]) * std::uint64_t(size[2]), data.header.filled);
  data.index = reinterpret_cast<const std::int32_t*>(data.bytes.data() + layout.index_begin);
  data.voxels = reinterpret_cast<const ReachabilityVoxel*>(data.bytes.data() + layout.voxels_begin);
  return std::shared_ptr<const ReachabilityMap>(map);
}

const ReachabilityVoxel* ReachabilityMap::find(const Eigen::Vector3d& p_A) const {
  const reachability::FileHeader& header = data_->header;
  std::size_t cell = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double at = std::floor(p_A[axis] / header.voxel) - header.first[axis];
    if (!(at >= 0 && at < header.size[axis])) return nullptr;  // NaN too
    cell = cell * static_cast<std::size_t>(header.size[axis]) + static_cast<std::size_t>(at);
  }
  const std::int32_t index = data_->index[cell];
  return index < 0 ? nullptr : data_->voxels + index;
}

double ReachabilityMap::operator()(const Eigen::Vector3d& p_A) const {
  const ReachabilityVoxel* voxel = find(p_A);
  return voxel != nullptr ? double{voxel->manipulability} : 0;
}

double ReachabilityMap::reach(const Eigen::Vector3d& p_A) const {
  const reachability::FileHeader& header = data_->header;
  const Eigen::Vector3d half = Eigen::Vector3d::Constant(0.5);
  double farthest = 0;
  const std::int32_t* index = data_->index;
  for (int i = 0; i < header.size[0]; ++i) {
    for (int j = 0; j < header.size[1]; ++j) {
      for (int k = 0; k < header.size[2]; ++k) {
        if (*index++ < 0) continue;
        const Eigen::Vector3d first(header.first[0] + i, header.first[1] + j, header.first[2] + k);
        const Eigen::Vector3d to_centre = header.voxel * (first + half) - p_A;
        const Eigen::Vector3d to_corner =
            to_centre.cwiseAbs() + Eigen::Vector3d::Constant(0.5 * header.voxel);
        farthest = std::max(farthest, to_corner.norm());
      }
    }
  }
  return farthest;
}

double ReachabilityMap::voxelSize() const { return data_->header.voxel; }

std::size_t ReachabilityMap::filledVoxels() const { return data_->header.filled; }

}  // namespace handover
