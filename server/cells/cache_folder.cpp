// SPDX-License-Identifier: Apache-2.0
#include "cells/cache_folder.hpp"

#include <handover/common/log.hpp>
#include <handover/common/mutex.hpp>

#include <algorithm>
#include <atomic>
#include <vector>

namespace handover {
namespace {

namespace fs = std::filesystem;

struct KeptFile {
  fs::path path;
  std::uint64_t bytes;
  fs::file_time_type used;
};

/// Files that others take away meanwhile are left out.
std::vector<KeptFile> filesBelow(const fs::path& folder) {
  std::vector<KeptFile> files;
  std::error_code gone;
  fs::recursive_directory_iterator at(folder, gone);
  for (; !gone && at != fs::recursive_directory_iterator(); at.increment(gone)) {
    std::error_code left;
    if (!at->is_regular_file(left)) continue;
    const std::uint64_t bytes = at->file_size(left);
    const fs::file_time_type used = left ? fs::file_time_type() : at->last_write_time(left);
    if (!left) files.push_back({at->path(), bytes, used});
  }
  return files;
}

}  // namespace

struct CacheFolder::State {
  fs::path path;
  std::uint64_t most_bytes;
  std::atomic<std::uint64_t> written_bytes = 0;
  Mutex trimming;

  /// Takes away the oldest, `newest` never.
  void trim(const fs::path& newest) {
    const MutexLock lock(trimming);
    std::vector<KeptFile> files = filesBelow(path);
    std::uint64_t bytes = 0;
    for (const KeptFile& file : files) bytes += file.bytes;
    if (bytes <= most_bytes) return;
    std::sort(files.begin(), files.end(),
              [](const KeptFile& a, const KeptFile& b) { return a.used < b.used; });
    for (const KeptFile& file : files) {
      if (bytes <= most_bytes) return;
      std::error_code failed;
      if (file.path == newest || !fs::remove(file.path, failed)) continue;
      bytes -= file.bytes;
      logger("cache")->info("{}: taken away, the oldest of too much", file.path.string());
    }
  }
};

CacheFolder::CacheFolder(fs::path path, std::uint64_t most_bytes)
    : state_(std::make_shared<State>()) {
  state_->path = std::move(path);
  state_->most_bytes = most_bytes;
}

const fs::path& CacheFolder::path() const { return state_->path; }

void CacheFolder::used(const fs::path& file) const {
  std::error_code ignored;  // of a folder that cannot be written nothing is taken away either
  fs::last_write_time(file, fs::file_time_type::clock::now(), ignored);
}

void CacheFolder::written(const fs::path& file) const {
  std::error_code gone;
  const std::uint64_t bytes = fs::file_size(file, gone);
  if (gone) return;
  state_->written_bytes += bytes;
  state_->trim(file);
}

std::uint64_t CacheFolder::writtenBytes() const { return state_->written_bytes; }

}  // namespace handover
