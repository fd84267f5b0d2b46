// SPDX-License-Identifier: Apache-2.0
#include "view/root_files.hpp"

#include <handover/client/plan_file.hpp>

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <vector>

namespace handover::view {
namespace {

namespace fs = std::filesystem;
using client::PlanFileError;

constexpr std::uintmax_t kMaxFileBytes = 64u << 20;

void requireFile(const fs::path& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (status.type() == fs::file_type::not_found) throw PlanFileError(file.string(), "no such file");
  if (!fs::is_regular_file(status)) throw PlanFileError(file.string(), "is not a regular file");
  if (fs::file_size(file, error) > kMaxFileBytes || error) {
    throw PlanFileError(file.string(), "too large");
  }
}

std::vector<fs::path> packageFiles(const fs::path& rest, const fs::path& urdf,
                                   const fs::path& root) {
  fs::path inside;
  for (auto part = std::next(rest.begin()); part != rest.end(); ++part) inside /= *part;
  std::vector<fs::path> files{root / rest, root / inside, root / "robots" / rest};
  for (fs::path folder = urdf.parent_path(); !folder.empty() && folder != folder.root_path();
       folder = folder.parent_path()) {
    if (folder.filename() == *rest.begin()) files.push_back(folder / inside);
  }
  return files;
}

std::vector<fs::path> candidates(const std::string& name, const fs::path& urdf,
                                 const fs::path& root) {
  const std::string package = "package://", file = "file://";
  if (name.starts_with(package) && name.size() > package.size()) {
    return packageFiles(name.substr(package.size()), urdf, root);
  }
  if (name.starts_with(file)) return {name.substr(file.size())};
  return {urdf.parent_path() / name};
}

}  // namespace

fs::path defaultRoot() {
  if (const char* given = std::getenv("HANDOVER_ROOT"); given != nullptr && *given != '\0') {
    return given;
  }
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (error) return {};
  fs::path share = program.parent_path().parent_path() / "share" / "handover";
  if (fs::is_directory(share / "robots", error)) return share;
  for (fs::path folder = program.parent_path(); folder != folder.root_path();
       folder = folder.parent_path()) {
    if (fs::is_directory(folder / "robots", error) &&
        fs::is_directory(folder / "config" / "cells", error)) {
      return folder;
    }
  }
  return {};
}

std::string RootFiles::read(const std::string& path) const {
  const fs::path file = pathOf(path);
  requireFile(file);
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw PlanFileError(file.string(), "cannot be opened");
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

std::optional<std::string> RootFiles::findMesh(const std::string& name,
                                               const std::string& urdf) const {
  std::error_code error;
  for (const fs::path& file : candidates(name, pathOf(urdf), root_)) {
    if (!fs::is_regular_file(file, error)) continue;
    const fs::path path = file.lexically_normal().lexically_relative(root_.lexically_normal());
    const bool below = !path.empty() && *path.begin() != "..";
    return below ? path.string() : fs::absolute(file).string();
  }
  return std::nullopt;
}

}  // namespace handover::view
