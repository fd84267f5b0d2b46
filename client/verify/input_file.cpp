// SPDX-License-Identifier: Apache-2.0
#include "verify/input_file.hpp"

#include "verify/unreadable.hpp"

#include <fstream>
#include <iterator>

namespace handover::verify {

namespace fs = std::filesystem;

void requireFile(const fs::path& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (fs::is_regular_file(status)) return;
  if (status.type() == fs::file_type::not_found) throw Unreadable(file.string(), "no such file");
  if (fs::is_directory(status)) throw Unreadable(file.string(), "is a folder");
  if (error) throw Unreadable(file.string(), error.message());
  throw Unreadable(file.string(), "is not a regular file");
}

std::string readFile(const fs::path& file, std::uint64_t max_bytes) {
  requireFile(file);
  std::error_code error;
  if (fs::file_size(file, error) > max_bytes || error) throw Unreadable(file.string(), "too large");
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw Unreadable(file.string(), "cannot be opened");
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

}  // namespace handover::verify
