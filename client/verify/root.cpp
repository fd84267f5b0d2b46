// SPDX-License-Identifier: Apache-2.0
#include "verify/root.hpp"

#include <cstdlib>

namespace handover::verify {

namespace fs = std::filesystem;

fs::path defaultRoot() {
  if (const char* named = std::getenv("HANDOVER_ROOT"); named && *named) return named;
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

}  // namespace handover::verify
