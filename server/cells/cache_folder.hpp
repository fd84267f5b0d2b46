// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

namespace handover {

/// A folder of products that can be made again: when it holds more than its bound, what was used
/// last the longest ago goes. Other processes may use it too. Copies are the same folder. Safe from
/// any thread.
class CacheFolder {
 public:
  static constexpr std::uint64_t kMostBytes = std::uint64_t{2} << 30;

  /// An empty path: nothing is kept.
  CacheFolder(std::filesystem::path path, std::uint64_t most_bytes = kMostBytes);

  const std::filesystem::path& path() const;

  bool keeps() const { return !path().empty(); }

  /// Its time of use is now.
  void used(const std::filesystem::path& file) const;
  /// A file of the folder is new: it counts, and others go if it is one too many.
  void written(const std::filesystem::path& file) const;
  /// Of all files that this process wrote.
  std::uint64_t writtenBytes() const;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace handover
