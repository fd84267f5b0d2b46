// SPDX-License-Identifier: Apache-2.0
#include "cells/decomposition_cache.hpp"

#include "core/decomposition/decomposition_file.hpp"

#include <handover/common/log.hpp>
#include <handover/common/mutex.hpp>

#include <Eigen/Geometry>

#include <algorithm>
#include <atomic>
#include <map>
#include <optional>
#include <set>
#include <utility>

namespace handover {
namespace {

using Parts = std::vector<TriangleMesh>;

constexpr std::size_t kMostInMemory = 64;  // meshes

/// The box of a mesh, by its corners.
TriangleMesh boxOf(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& v : mesh.vertices) box.extend(v);
  TriangleMesh corners;
  for (int i = 0; i < 8; ++i) {
    corners.vertices.push_back(box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i)));
  }
  corners.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                       {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return corners;
}

}  // namespace

struct DecompositionCache::Data {
  std::filesystem::path folder;
  bool force;
  Progress progress;
  Deadline until;
  std::atomic<bool> looking = false;
  Mutex mutex;
  std::set<std::uint64_t> missing HANDOVER_GUARDED_BY(mutex);  ///< found while looking
  std::set<std::uint64_t> made HANDOVER_GUARDED_BY(mutex);
  /// What no file has: refusals, and parts that could not be written.
  std::map<std::uint64_t, Result<Parts>> in_memory HANDOVER_GUARDED_BY(mutex);

  std::filesystem::path fileOf(std::uint64_t hash) const {
    return folder / fmt::format("{:016x}.parts", hash);
  }

  bool keeps() const { return !folder.empty(); }

  /// nullopt where there are none that count.
  std::optional<Result<Parts>> kept(std::uint64_t hash) {
    {
      const MutexLock lock(mutex);
      if (const auto found = in_memory.find(hash); found != in_memory.end()) return found->second;
      if (!keeps()) return std::nullopt;
      if (force && !made.contains(hash)) return std::nullopt;
    }
    auto known = readPartsFile(fileOf(hash), hash);
    if (known) return Result<Parts>(std::move(*known));
    if (known.error().code != ErrorCode::kNotFound) {
      logger("parts")->warn("{}; it is made again", known.error().detail);
    }
    return std::nullopt;
  }

  /// A box for the parts of a mesh that is yet to be divided.
  Result<Parts> standIn(const TriangleMesh& mesh, std::uint64_t hash) {
    if (const auto can = divisible(mesh); !can) return can.error();
    const MutexLock lock(mutex);
    missing.insert(hash);
    return Parts{boxOf(mesh)};
  }

  std::pair<std::size_t, std::size_t> madeAndMissing() {
    const MutexLock lock(mutex);
    return {made.size(), missing.size()};
  }

  void tell() {
    if (!progress) return;
    const auto [done, counted] = madeAndMissing();
    const std::size_t all = std::max(counted, done + 1);
    progress(fmt::format("dividing meshes: {} of {}", done + 1, all),
             static_cast<double>(done) / static_cast<double>(all));
  }

  void keep(const Result<Parts>& parts, std::uint64_t hash) {
    bool written = false;
    if (parts && keeps()) {
      const auto file = writePartsFile(*parts, hash, fileOf(hash));
      if (!file) logger("parts")->warn("{}; the parts are not kept", file.error().detail);
      written = file.has_value();
    }
    const MutexLock lock(mutex);
    if (parts) made.insert(hash);
    if (written) return;
    if (in_memory.size() >= kMostInMemory) in_memory.clear();
    in_memory.insert_or_assign(hash, parts);
  }
};

DecompositionCache::DecompositionCache(const std::filesystem::path& folder, bool force,
                                       Progress progress, const Deadline& until)
    : data_(std::make_shared<Data>()) {
  if (!folder.empty()) data_->folder = folder / "parts";
  data_->force = force;
  data_->progress = std::move(progress);
  data_->until = until;
}

DecompositionCache::~DecompositionCache() = default;

Result<Parts> DecompositionCache::operator()(const TriangleMesh& mesh) const {
  return parts(mesh, data_->until);
}

Result<Parts> DecompositionCache::parts(const TriangleMesh& mesh, const Deadline& deadline) const {
  const std::uint64_t hash = partsHash(mesh);
  if (auto known = data_->kept(hash)) return std::move(*known);
  if (data_->looking) return data_->standIn(mesh, hash);
  data_->tell();
  auto parts = convexPartsWithin(mesh, deadline);
  if (parts || parts.error().code != ErrorCode::kDeadline) data_->keep(parts, hash);
  return parts;
}

std::optional<Result<Parts>> DecompositionCache::known(const TriangleMesh& mesh) const {
  if (auto kept = data_->kept(partsHash(mesh))) return kept;
  if (const auto can = divisible(mesh); !can) return Result<Parts>(can.error());
  return std::nullopt;
}

void DecompositionCache::loadInRounds(const std::function<bool()>& load) const {
  struct Looking {
    explicit Looking(std::atomic<bool>& flag) : flag_(flag) { flag_ = true; }

    ~Looking() { flag_ = false; }

    std::atomic<bool>& flag_;
  };

  {
    const Looking looking(data_->looking);
    if (!load()) return;
  }
  const auto [made, missing] = data_->madeAndMissing();
  if (missing == 0) return;
  load();
  if (data_->progress) {
    data_->progress(fmt::format("dividing meshes: {} of {}", missing, missing), 1.0);
  }
}

}  // namespace handover
