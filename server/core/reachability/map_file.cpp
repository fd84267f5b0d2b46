// SPDX-License-Identifier: Apache-2.0
#include "core/reachability/map_file.hpp"

#include <handover/common/descriptor.hpp>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>
#include <system_error>

namespace handover::reachability {
namespace {

namespace fs = std::filesystem;

std::string reason(int error) { return std::generic_category().message(error); }

std::uint64_t checksum(std::span<const std::byte> file) {
  constexpr std::size_t kBegin = offsetof(FileHeader, hash);
  return XXH3_64bits(file.data() + kBegin, file.size() - kBegin);
}

Error invalid(const std::string& what) { return {ErrorCode::kInvalidInput, what}; }

bool plausible(const ReachabilityVoxel& voxel) {
  if (!std::isfinite(voxel.manipulability) || voxel.manipulability < 0 || voxel.samples == 0) {
    return false;
  }
  for (const float q : voxel.q_seed) {
    if (!std::isfinite(q)) return false;
  }
  return true;
}

}  // namespace

FileLayout layoutOf(std::uint64_t cells, std::uint64_t filled) {
  FileLayout layout;
  layout.index_begin = sizeof(FileHeader);
  layout.voxels_begin = (layout.index_begin + cells * sizeof(std::int32_t) + 7) / 8 * 8;
  layout.end = layout.voxels_begin + filled * sizeof(ReachabilityVoxel);
  return layout;
}

std::vector<std::byte> mapFileBytes(FileHeader header, std::span<const std::int32_t> index,
                                    std::span<const ReachabilityVoxel> voxels) {
  const FileLayout layout = layoutOf(index.size(), voxels.size());
  header.header_size = sizeof(FileHeader);
  header.filled = voxels.size();
  header.file_size = layout.end;
  std::vector<std::byte> bytes(layout.end);
  std::memcpy(bytes.data(), &header, sizeof(header));
  if (!index.empty()) {
    std::memcpy(bytes.data() + layout.index_begin, index.data(), index.size_bytes());
  }
  if (!voxels.empty()) {
    std::memcpy(bytes.data() + layout.voxels_begin, voxels.data(), voxels.size_bytes());
  }
  header.checksum = checksum(bytes);
  std::memcpy(bytes.data(), &header, sizeof(header));
  return bytes;
}

Result<std::vector<std::byte>> readMapFile(const fs::path& file) {
  // Not blocking, should the name be a pipe.
  const Descriptor fd(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (fd.get() < 0) {
    const ErrorCode code =
        errno == ENOENT || errno == ENOTDIR ? ErrorCode::kNotFound : ErrorCode::kIo;
    return Error{code, file.string() + ": " + reason(errno)};
  }

  struct stat status {};

  if (::fstat(fd.get(), &status) != 0) {
    return Error{ErrorCode::kIo, file.string() + ": " + reason(errno)};
  }
  if (!S_ISREG(status.st_mode)) return invalid(file.string() + ": not a plain file");
  if (status.st_size < static_cast<off_t>(sizeof(FileHeader))) {
    return invalid(file.string() + ": shorter than a map's header");
  }
  const auto size = static_cast<std::uint64_t>(status.st_size);
  if (size > layoutOf(kMostCells, kMostCells).end) {
    return invalid(file.string() + ": longer than any map");
  }
  std::vector<std::byte> bytes(size);
  std::size_t got = 0;
  while (got < bytes.size()) {
    const ssize_t n = ::read(fd.get(), bytes.data() + got, bytes.size() - got);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return Error{ErrorCode::kIo, file.string() + ": " + reason(errno)};
    if (n == 0) return invalid(file.string() + ": cut short while it was read");
    got += static_cast<std::size_t>(n);
  }
  return bytes;
}

Result<FileHeader> checkMapFile(std::span<const std::byte> bytes, std::uint64_t expected_hash) {
  FileHeader header;
  if (bytes.size() < sizeof(header)) return invalid("shorter than a map's header");
  std::memcpy(&header, bytes.data(), sizeof(header));
  if (header.magic != kMagic) return invalid("not a reachability map (wrong magic)");
  if (header.version != kFileVersion) {
    return invalid("version " + std::to_string(header.version) + ", needed is " +
                   std::to_string(kFileVersion));
  }
  if (header.header_size != sizeof(header) || header.voxel_bytes != sizeof(ReachabilityVoxel)) {
    return invalid("sizes of header or voxel do not fit the version");
  }
  if (header.file_size != bytes.size()) {
    return invalid("has " + std::to_string(bytes.size()) + " bytes, its header says " +
                   std::to_string(header.file_size));
  }
  if (header.checksum != checksum(bytes)) return invalid("wrong checksum: the file is damaged");
  if (header.hash != expected_hash) {
    return invalid("made for another arm, torso or other parameters (wrong hash)");
  }

  // The checksum holds from here on; what follows guards against a file made wrong.
  if (!std::isfinite(header.voxel) || header.voxel <= 0)
    return invalid("voxel size is not positive");
  if (header.dofs < 1 || header.dofs > 8) return invalid("number of joints is not 1 to 8");
  std::uint64_t cells = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t first = header.first[axis], size = header.size[axis];
    if (size < 0 || first + size > std::numeric_limits<std::int32_t>::max()) {
      return invalid("grid out of range");
    }
    // Each factor is below 2^31 and the product so far at most 2^27: no overflow.
    cells *= static_cast<std::uint64_t>(size);
    if (cells > kMostCells) return invalid("grid too large");
  }
  if (header.filled > cells || layoutOf(cells, header.filled).end != bytes.size()) {
    return invalid("number of voxels does not fit the file's size");
  }
  const FileLayout layout = layoutOf(cells, header.filled);
  const auto* index = reinterpret_cast<const std::int32_t*>(bytes.data() + layout.index_begin);
  std::int64_t next = 0;
  for (std::uint64_t cell = 0; cell < cells; ++cell) {
    if (index[cell] == -1) continue;
    if (index[cell] != next) return invalid("grid index out of order");
    ++next;
  }
  if (static_cast<std::uint64_t>(next) != header.filled) return invalid("voxels without a cell");
  const auto* voxels =
      reinterpret_cast<const ReachabilityVoxel*>(bytes.data() + layout.voxels_begin);
  for (std::uint64_t v = 0; v < header.filled; ++v) {
    if (!plausible(voxels[v])) return invalid("voxel " + std::to_string(v) + " is not valid");
  }
  return header;
}

}  // namespace handover::reachability
