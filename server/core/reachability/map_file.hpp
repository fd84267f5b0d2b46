// SPDX-License-Identifier: Apache-2.0
// The map's file: a header, the dense grid of indices (int32, -1 = not reached, x slowest), the
// voxels in grid order. Everything little-endian and aligned, so that it is used as it is read.
#pragma once

#include "core/reachability/reachability_map.hpp"

#include <handover/common/result.hpp>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

namespace handover::reachability {

static_assert(std::endian::native == std::endian::little, "map files are little-endian");
static_assert(sizeof(ReachabilityVoxel) == 48 && offsetof(ReachabilityVoxel, q_seed) == 16);

/// Raised whenever the file's layout or the meaning of its contents changes.
inline constexpr std::uint32_t kFileVersion = 2;
inline constexpr std::array<char, 8> kMagic{'H', 'O', 'R', 'E', 'A', 'C', 'H', '\n'};
/// More cells than this are refused: 0.5 GB of indices.
inline constexpr std::uint64_t kMostCells = std::uint64_t{1} << 27;

struct FileHeader {
  std::array<char, 8> magic = kMagic;
  std::uint32_t version = kFileVersion;
  std::uint32_t header_size = 0;
  std::uint64_t checksum = 0;  ///< XXH3 of all bytes after this field
  std::uint64_t hash = 0;      ///< ReachabilityMap::hash
  std::uint64_t file_size = 0;
  double voxel = 0;            ///< edge [m]
  std::uint64_t samples = 0;   ///< drawn over the whole range
  std::uint64_t accepted = 0;  ///< in voxels: not in self-collision, those added at near ties too
  std::uint64_t seed = 0;
  std::array<std::int32_t, 3>
      first{};  ///< voxel (i, j, k) covers [i, i+1) x [j, j+1) x [k, k+1) edges
  std::array<std::int32_t, 3> size{};  ///< voxels along x, y, z
  std::uint64_t filled = 0;
  std::uint32_t dofs = 0;
  std::uint32_t voxel_bytes = sizeof(ReachabilityVoxel);
};

static_assert(sizeof(FileHeader) == 112 && offsetof(FileHeader, hash) == 24);

/// Where the parts of a file lie [bytes].
struct FileLayout {
  std::uint64_t index_begin = 0, voxels_begin = 0, end = 0;
};

FileLayout layoutOf(std::uint64_t cells, std::uint64_t filled);

/// The bytes of a file, with the header's sizes and checksum filled in.
std::vector<std::byte> mapFileBytes(FileHeader header, std::span<const std::int32_t> index,
                                    std::span<const ReachabilityVoxel> voxels);

/// The bytes of a whole plain file. kNotFound: there is none; kInvalidInput: not a plain file,
/// shorter than a header or longer than any map; kIo: it cannot be read.
Result<std::vector<std::byte>> readMapFile(const std::filesystem::path& file);

/// Checks every field against the file's size and every index and voxel; kInvalidInput with the
/// reason.
Result<FileHeader> checkMapFile(std::span<const std::byte> bytes, std::uint64_t expected_hash);

}  // namespace handover::reachability
