// SPDX-License-Identifier: Apache-2.0
// One self-contained page that shows a plan in a browser.
#pragma once

#include <filesystem>
#include <string>

namespace handover::view {

/// The page of a plan file's text: viewer, plan, robots and meshes in one, no outside reference.
/// @param root folder that the plan's paths are relative to.
/// @throws verify::Unreadable when the text is no plan file or a file that it names cannot be read.
std::string planPage(const std::string& plan_text, const std::filesystem::path& root);

}  // namespace handover::view
