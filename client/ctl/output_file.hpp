// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

namespace handover::ctl {

/// A file that is there, in whole, or not at all: written beside its place and renamed.
class OutputFile {
 public:
  explicit OutputFile(const std::filesystem::path& path) : path_(path) {
    std::error_code none;
    special_ = std::filesystem::exists(path, none) && !std::filesystem::is_regular_file(path, none);
    target_ = path;
    if (!special_) target_ += ".part";
    file_.open(target_, std::ios::binary);
  }

  ~OutputFile() {
    std::error_code ignored;
    if (!special_ && !committed_) std::filesystem::remove(target_, ignored);
  }

  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  bool writable() const { return file_.is_open(); }

  bool commit(const std::string& text) {
    file_ << text;
    file_.close();
    if (!file_) return false;
    std::error_code error;
    if (!special_) std::filesystem::rename(target_, path_, error);
    committed_ = !error;
    return committed_;
  }

 private:
  std::filesystem::path path_, target_;
  std::ofstream file_;
  bool special_ = false, committed_ = false;
};

}  // namespace handover::ctl
