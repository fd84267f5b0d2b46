// SPDX-License-Identifier: Apache-2.0
#include "settings/roots.hpp"

#include "core/model_io/file_fault.hpp"

#include <cstdlib>
#include <stdexcept>

namespace handover {
namespace {

namespace fs = std::filesystem;

bool isRoot(const fs::path& folder) {
  std::error_code ignored;
  return fs::is_directory(folder / "config" / "cells", ignored) &&
         fs::is_directory(folder / "robots", ignored);
}

fs::path givenRoot(const std::string& folder, const std::string& source) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    throw FileError({{folder, 0, source + " is not a folder"}});
  }
  return fs::absolute(folder).lexically_normal();
}

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

}  // namespace

fs::path findRoot(const std::string& given) {
  if (!given.empty()) return givenRoot(given, "the root");
  if (const std::string set = environment("HANDOVER_ROOT"); !set.empty()) {
    return givenRoot(set, "HANDOVER_ROOT");
  }
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  for (fs::path folder = program.parent_path(); !error; folder = folder.parent_path()) {
    if (isRoot(folder / "share" / "handover")) return folder / "share" / "handover";
    if (isRoot(folder)) return folder;
    if (folder == folder.parent_path()) break;
  }
  throw FileError({{program.string(), 0,
                    "no folder above the program has config/cells and robots: give --root"}});
}

fs::path cellFile(const std::string& name_or_file, const fs::path& root) {
  const bool is_file =
      name_or_file.find('/') != std::string::npos || name_or_file.ends_with(".yaml");
  return is_file ? fs::path(name_or_file) : root / "config" / "cells" / (name_or_file + ".yaml");
}

fs::path robotFile(const std::string& model, const fs::path& root) {
  return root / "robots" / model / (model + ".yaml");
}

fs::path cacheFolder(const std::string& given) {
  if (!given.empty()) return given;
  // The base directory specification has relative paths ignored.
  if (const fs::path cache = environment("XDG_CACHE_HOME"); cache.is_absolute()) {
    return fs::path(cache) / "handover";
  }
  if (const fs::path home = environment("HOME"); home.is_absolute()) {
    return home / ".cache" / "handover";
  }
  throw std::runtime_error(
      "no place for the cache: neither XDG_CACHE_HOME nor HOME is an absolute path; set one of "
      "them, or cache: in the daemon's settings file");
}

}  // namespace handover
