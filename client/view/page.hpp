// SPDX-License-Identifier: Apache-2.0
// Self-contained pages that show a plan or an experiment in a browser.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace handover::view {

/// False where the programs were built without node and npm: then no page can be made.
bool hasPages();

/// What to tell people then.
inline constexpr const char* kNoPages =
    "the pages are not in this build: it was made without node and npm";

/// The page of a plan file's text: viewer, plan, robots and meshes in one, no outside reference. A
/// file without a plan is shown as its scene and why there is none.
/// @param root folder that the plan's paths are relative to.
/// @throws client::PlanFileError when the text is no plan file or a file that it names cannot be
/// read.
/// @pre hasPages().
std::string planPage(const std::string& plan_text, const std::filesystem::path& root);

/// A plan file's text under a name, [a-z0-9-]+.
struct NamedPlan {
  std::string name, text;
};

/// One page for several plan files, which it shows one at a time: the one that the address names
/// (PAGE.html#NAME), else the first. What their robots and objects need is in it once.
/// @throws client::PlanFileError as planPage(). @pre hasPages(); files without a plan.
std::string failuresPage(const std::vector<NamedPlan>& failures, const std::filesystem::path& root);

/// The page of an experiment, no outside reference.
/// @param data what src/report.js reads, as JSON text.
/// @pre hasPages().
std::string experimentPage(const std::string& data);

}  // namespace handover::view
