// SPDX-License-Identifier: Apache-2.0
// Self-contained pages that show a plan or an experiment in a browser.
#pragma once

#include <filesystem>
#include <string>

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

/// The page of an experiment, no outside reference.
/// @param data what src/report.js reads, as JSON text.
/// @pre hasPages().
std::string experimentPage(const std::string& data);

}  // namespace handover::view
