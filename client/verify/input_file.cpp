// SPDX-License-Identifier: Apache-2.0
#include "verify/input_file.hpp"

#include "verify/unreadable.hpp"

#include <fstream>
#include <iterator>
#include <vector>

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

fs::path resolveUrdfMesh(const std::string& name, const fs::path& urdf, const fs::path& root) {
  std::vector<fs::path> candidates;
  const std::string package = "package://";
  const std::string file = "file://";
  if (name.rfind(package, 0) == 0) {
    const fs::path rest = name.substr(package.size());
    fs::path inside;
    for (auto part = std::next(rest.begin()); part != rest.end(); ++part) inside /= *part;
    candidates = {root / rest, root / inside, root / "robots" / rest};
    for (fs::path folder = urdf.parent_path(); !folder.empty() && folder != folder.root_path();
         folder = folder.parent_path()) {
      if (folder.filename() == *rest.begin()) candidates.push_back(folder / inside);
    }
  } else if (name.rfind(file, 0) == 0) {
    candidates = {name.substr(file.size())};
  } else {
    candidates = {urdf.parent_path() / name};
  }
  std::error_code error;
  for (const fs::path& candidate : candidates) {
    if (fs::is_regular_file(candidate, error)) return candidate;
  }
  throw Unreadable(urdf.string(), "mesh \"" + name + "\" not found");
}

}  // namespace handover::verify
