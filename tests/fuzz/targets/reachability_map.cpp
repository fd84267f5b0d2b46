// SPDX-License-Identifier: Apache-2.0
// A map's file with its checksum put right, which no fuzzer would find.
#include "core/reachability/map_file.hpp"
#include "target.hpp"

#include <xxhash.h>

#include <cstring>

namespace handover::fuzz {
namespace {

using namespace reachability;

constexpr std::uint64_t kHash = 0x123456789abcdef0;
constexpr std::size_t kChecksumEnd = offsetof(FileHeader, hash);

}  // namespace

std::vector<std::string> seeds() {
  FileHeader header;
  header.hash = kHash;
  header.voxel = 0.05;
  header.size = {2, 1, 1};
  header.dofs = 7;
  const std::vector<std::int32_t> index{-1, 0};
  const std::vector<ReachabilityVoxel> voxels{{0.5F, 3, 1, {}}};
  const std::vector<std::byte> bytes = mapFileBytes(header, index, voxels);
  return {std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size())};
}

void run(std::string_view input) {
  std::vector<std::byte> bytes(input.size());
  std::memcpy(bytes.data(), input.data(), input.size());
  if (bytes.size() >= sizeof(FileHeader)) {
    const std::uint64_t sum = XXH3_64bits(bytes.data() + kChecksumEnd, bytes.size() - kChecksumEnd);
    std::memcpy(bytes.data() + offsetof(FileHeader, checksum), &sum, sizeof(sum));
  }
  (void)checkMapFile(bytes, kHash);
}

}  // namespace handover::fuzz
