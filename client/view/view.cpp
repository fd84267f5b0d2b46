// SPDX-License-Identifier: Apache-2.0
#include "view/view.hpp"

#include "verify/checks.hpp"
#include "verify/root.hpp"
#include "verify/unreadable.hpp"
#include "view/mcap.hpp"
#include "view/page.hpp"

namespace handover::view {
namespace {

namespace fs = std::filesystem;

std::string recordingOf(const std::string& plan_text, const fs::path& root) {
  verify::Report report;
  const verify::Scene scene = verify::loadScene(verify::parsePlan(plan_text), root, report);
  if (!verify::checkStructure(scene, report)) {
    throw verify::Unreadable("/plan/stages", report.violations.back().what);
  }
  return planMcap(verify::Motion(scene));
}

}  // namespace

bool isPage(const fs::path& output) { return output.extension() == ".html"; }

bool knowsFormat(const fs::path& output) { return isPage(output) || output.extension() == ".mcap"; }

std::string planView(const std::string& plan_text, const fs::path& output, const fs::path& root) {
  const fs::path folder = root.empty() ? verify::defaultRoot() : root;
  if (folder.empty()) {
    throw verify::Unreadable("--root", "neither an installed share nor the repository found");
  }
  return isPage(output) ? planPage(plan_text, folder) : recordingOf(plan_text, folder);
}

}  // namespace handover::view
