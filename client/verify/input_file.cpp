// SPDX-License-Identifier: Apache-2.0
#include "verify/input_file.hpp"

#include "verify/unreadable.hpp"

#include <tinyxml2.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
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

namespace {

/// The <name> of the package.xml in the folder; empty when there is none.
std::string packageName(const fs::path& folder) {
  tinyxml2::XMLDocument document;
  std::error_code error;
  const fs::path file = folder / "package.xml";
  if (!fs::is_regular_file(file, error)) return {};
  if (document.LoadFile(file.c_str()) != tinyxml2::XML_SUCCESS) return {};
  const tinyxml2::XMLElement* package = document.FirstChildElement("package");
  const tinyxml2::XMLElement* name = package ? package->FirstChildElement("name") : nullptr;
  const char* text = name ? name->GetText() : nullptr;
  std::string result = text ? text : "";
  const auto blank = [](char c) { return c == ' ' || c == '\n' || c == '\t' || c == '\r'; };
  while (!result.empty() && blank(result.back())) result.pop_back();
  while (!result.empty() && blank(result.front())) result.erase(0, 1);
  return result;
}

/// Folders of package `name` at or below `folder`.
void packagesBelow(const fs::path& folder, const std::string& name, int depth,
                   std::vector<fs::path>& found) {
  if (packageName(folder) == name) found.push_back(folder);
  std::error_code error;
  if (depth == 0) return;
  std::vector<fs::path> below;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.is_directory(error) && !entry.is_symlink(error)) below.push_back(entry.path());
  }
  std::sort(below.begin(), below.end());
  for (const fs::path& sub : below) packagesBelow(sub, name, depth - 1, found);
}

std::vector<fs::path> foldersOf(const char* variable) {
  std::vector<fs::path> folders;
  const char* text = std::getenv(variable);
  std::istringstream list(text ? text : "");
  for (std::string folder; std::getline(list, folder, ':');) {
    if (!folder.empty()) folders.emplace_back(folder);
  }
  return folders;
}

/// Where a package may lie, the likeliest first.
std::vector<fs::path> packageFolders(const std::string& name, const fs::path& urdf,
                                     const fs::path& root, const Packages& packages) {
  constexpr int kDepth = 4;
  std::vector<fs::path> folders;
  if (const auto found = packages.find(name); found != packages.end()) {
    folders.push_back(found->second);
  }
  for (fs::path folder = urdf.parent_path(); !folder.empty() && folder != folder.root_path();
       folder = folder.parent_path()) {
    if (packageName(folder) == name) folders.push_back(folder);
    if (folder.filename() == name) folders.push_back(folder);
  }
  // Beside the URDF's folders, but never beyond the root.
  for (fs::path folder = urdf.parent_path();
       !folder.empty() && folder != root.parent_path() && folder != folder.root_path();
       folder = folder.parent_path()) {
    packagesBelow(folder, name, folder == root ? 2 : 1, folders);
  }
  for (const fs::path& folder : foldersOf("ROS_PACKAGE_PATH")) {
    packagesBelow(folder, name, kDepth, folders);
  }
  for (const fs::path& prefix : foldersOf("AMENT_PREFIX_PATH")) {
    folders.push_back(prefix / "share" / name);
  }
  for (const fs::path& folder : {root / name, root / "robots" / name, root}) {
    folders.push_back(folder);
  }
  return folders;
}

}  // namespace

fs::path resolveUrdfMesh(const std::string& name, const fs::path& urdf, const fs::path& root,
                         const Packages& packages) {
  std::vector<fs::path> candidates;
  const std::string package = "package://";
  const std::string file = "file://";
  if (name.rfind(package, 0) == 0) {
    const fs::path rest = name.substr(package.size());
    if (rest.empty()) throw Unreadable(urdf.string(), "mesh \"" + name + "\" names no package");
    fs::path inside;
    for (auto part = std::next(rest.begin()); part != rest.end(); ++part) inside /= *part;
    for (const fs::path& folder : packageFolders(rest.begin()->string(), urdf, root, packages)) {
      candidates.push_back(folder / inside);
    }
  } else if (name.rfind(file, 0) == 0) {
    candidates = {name.substr(file.size())};
  } else {
    candidates = {urdf.parent_path() / name};
  }
  std::error_code error;
  std::string places;
  for (const fs::path& candidate : candidates) {
    if (fs::is_regular_file(candidate, error)) return candidate;
    places += (places.empty() ? "" : ", ") + candidate.string();
  }
  throw Unreadable(urdf.string(), "mesh \"" + name + "\" not found; looked at " + places);
}

}  // namespace handover::verify
