// SPDX-License-Identifier: Apache-2.0
#include "core/decomposition/decomposition_file.hpp"

#include <handover/common/atomic_file.hpp>

#include <xxhash.h>

#include <bit>
#include <cstddef>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <span>
#include <string>

namespace handover {
namespace {

static_assert(std::endian::native == std::endian::little, "parts files are little-endian");

/// Raised whenever the file's layout changes or the same mesh would give other parts.
constexpr std::uint32_t kVersion = 1;
constexpr std::array<char, 8> kMagic{'H', 'O', 'P', 'A', 'R', 'T', 'S', '\n'};
constexpr std::uintmax_t kMostBytes = 64u << 20;

struct FileHeader {
  std::array<char, 8> magic = kMagic;
  std::uint32_t version = kVersion;
  std::uint32_t parts = 0;
  std::uint64_t checksum = 0;  ///< XXH3 of all bytes after this field
  std::uint64_t hash = 0;
};

static_assert(sizeof(FileHeader) == 32 && offsetof(FileHeader, hash) == 24);

struct PartHeader {
  std::uint32_t vertices = 0, triangles = 0;
};

using Vertex = Eigen::Vector3d;
using Corners = std::array<int, 3>;
static_assert(sizeof(Vertex) == 24 && sizeof(Corners) == 12);

template <typename T>
void append(std::string& bytes, const T* values, std::size_t count) {
  bytes.append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

std::uint64_t checksum(const std::string& bytes) {
  constexpr std::size_t kBegin = offsetof(FileHeader, hash);
  return XXH3_64bits(bytes.data() + kBegin, bytes.size() - kBegin);
}

/// Takes values off the front of some bytes; false once there are too few.
class Cursor {
 public:
  explicit Cursor(std::string_view bytes) : bytes_(bytes) {}

  template <typename T>
  bool take(T* values, std::size_t count) {
    if (bytes_.size() / sizeof(T) < count) return false;
    std::memcpy(static_cast<void*>(values), bytes_.data(), count * sizeof(T));
    bytes_.remove_prefix(count * sizeof(T));
    return true;
  }

  std::size_t left() const { return bytes_.size(); }

 private:
  std::string_view bytes_;
};

bool inOrder(const TriangleMesh& part) {
  for (const Vertex& vertex : part.vertices) {
    if (!vertex.allFinite()) return false;
  }
  for (const Corners& triangle : part.triangles) {
    for (const int corner : triangle) {
      if (corner < 0 || static_cast<std::size_t>(corner) >= part.vertices.size()) return false;
    }
  }
  return !part.triangles.empty();
}

/// What is wrong with the file's bytes; empty if nothing.
std::string parse(const std::string& bytes, std::uint64_t expected_hash,
                  std::vector<TriangleMesh>& parts) {
  Cursor cursor(bytes);
  FileHeader header;
  if (!cursor.take(&header, 1)) return "shorter than its header";
  if (header.magic != kMagic) return "not a file of convex parts (wrong magic)";
  if (header.version != kVersion) {
    return "version " + std::to_string(header.version) + ", needed is " + std::to_string(kVersion);
  }
  if (header.checksum != checksum(bytes)) return "wrong checksum: the file is damaged";
  if (header.hash != expected_hash) return "made for another mesh (wrong hash)";
  // The checksum holds from here on; what follows guards against a file made wrong.
  for (std::uint32_t i = 0; i < header.parts; ++i) {
    PartHeader sizes;
    if (!cursor.take(&sizes, 1)) return "ends within a part";
    if (cursor.left() / sizeof(Vertex) < sizes.vertices ||
        cursor.left() / sizeof(Corners) < sizes.triangles) {
      return "ends within a part";
    }
    TriangleMesh& part = parts.emplace_back();
    part.vertices.resize(sizes.vertices);
    part.triangles.resize(sizes.triangles);
    if (!cursor.take(part.vertices.data(), sizes.vertices) ||
        !cursor.take(part.triangles.data(), sizes.triangles)) {
      return "ends within a part";
    }
    if (!inOrder(part)) return "part " + std::to_string(i) + " is not valid";
  }
  if (parts.empty() || cursor.left() != 0) return "its size does not fit its parts";
  return "";
}

}  // namespace

std::uint64_t partsHash(const TriangleMesh& mesh) {
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(),
                                                                       &XXH3_freeState);
  XXH3_64bits_reset(state.get());
  const std::uint64_t sizes[] = {kVersion, mesh.vertices.size(), mesh.triangles.size()};
  XXH3_64bits_update(state.get(), sizes, sizeof sizes);
  XXH3_64bits_update(state.get(), mesh.vertices.data(), mesh.vertices.size() * sizeof(Vertex));
  XXH3_64bits_update(state.get(), mesh.triangles.data(), mesh.triangles.size() * sizeof(Corners));
  return XXH3_64bits_digest(state.get());
}

Result<void> writePartsFile(const std::vector<TriangleMesh>& parts, std::uint64_t hash,
                            const std::filesystem::path& file) {
  FileHeader header;
  header.parts = static_cast<std::uint32_t>(parts.size());
  header.hash = hash;
  std::string bytes;
  append(bytes, &header, 1);
  for (const TriangleMesh& part : parts) {
    const PartHeader sizes{static_cast<std::uint32_t>(part.vertices.size()),
                           static_cast<std::uint32_t>(part.triangles.size())};
    append(bytes, &sizes, 1);
    append(bytes, part.vertices.data(), part.vertices.size());
    append(bytes, part.triangles.data(), part.triangles.size());
  }
  header.checksum = checksum(bytes);
  std::memcpy(bytes.data(), &header, sizeof header);
  return writeFileAtomically(file, std::as_bytes(std::span(bytes)));
}

Result<std::vector<TriangleMesh>> readPartsFile(const std::filesystem::path& file,
                                                std::uint64_t expected_hash) {
  std::error_code failed;
  if (!std::filesystem::exists(file, failed)) {
    return Error{ErrorCode::kNotFound, file.string() + ": no such file"};
  }
  const bool plain = std::filesystem::is_regular_file(file, failed);
  if (!plain || std::filesystem::file_size(file, failed) > kMostBytes || failed) {
    return Error{ErrorCode::kInvalidInput, file.string() + ": not a plain file of up to 64 MiB"};
  }
  std::ifstream stream(file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  if (stream.bad() || !stream.is_open()) {
    return Error{ErrorCode::kIo, file.string() + ": cannot be read"};
  }
  std::vector<TriangleMesh> parts;
  const std::string fault = parse(bytes, expected_hash, parts);
  if (!fault.empty()) return Error{ErrorCode::kInvalidInput, file.string() + ": " + fault};
  return parts;
}

}  // namespace handover
