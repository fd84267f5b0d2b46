// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <handover/common/atomic_file.hpp>

#include <filesystem>
#include <fstream>
#include <span>
#include <string>

namespace handover::ctl {

/// A file that is there, in whole, or not at all. Pipes and devices are written as they are.
class OutputFile {
 public:
  explicit OutputFile(const std::filesystem::path& path) : path_(path) {
    std::error_code none;
    special_ = std::filesystem::exists(path, none) && !std::filesystem::is_regular_file(path, none);
    if (special_) device_.open(path, std::ios::binary);
  }

  /// Known before there is anything to write.
  bool writable() const { return special_ ? device_.is_open() : canWriteBeside(path_).has_value(); }

  bool commit(const std::string& text) {
    if (!special_) return writeFileAtomically(path_, std::as_bytes(std::span(text))).has_value();
    device_ << text;
    device_.close();
    return !device_.fail();
  }

 private:
  std::filesystem::path path_;
  std::ofstream device_;
  bool special_ = false;
};

}  // namespace handover::ctl
