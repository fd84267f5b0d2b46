// SPDX-License-Identifier: Apache-2.0
#include "view/view.hpp"

#include "view/mcap.hpp"
#include "view/page.hpp"
#include "view/root_files.hpp"

#include <handover/client/plan_file.hpp>

namespace handover::view {

namespace fs = std::filesystem;

bool isPage(const fs::path& output) { return output.extension() == ".html"; }

bool knowsFormat(const fs::path& output) { return isPage(output) || output.extension() == ".mcap"; }

std::string planView(const std::string& plan_text, const fs::path& output, const fs::path& root) {
  const fs::path folder = root.empty() ? defaultRoot() : root;
  if (folder.empty()) {
    throw client::PlanFileError("--root", "neither an installed share nor the repository found");
  }
  return isPage(output) ? planPage(plan_text, folder) : planMcap(plan_text, folder);
}

}  // namespace handover::view
