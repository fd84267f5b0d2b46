// SPDX-License-Identifier: Apache-2.0
// What a plan is shown as, chosen by the name of the file that it goes to.
#pragma once

#include <filesystem>
#include <string>

namespace handover::view {

/// Whether the name ends in what planView() can write: .html or .mcap.
bool knowsFormat(const std::filesystem::path& output);

/// Whether the name is a page's.
bool isPage(const std::filesystem::path& output);

/// The content of `output`: a page (.html) or a recording (.mcap) of a plan file's text.
/// @param root folder that the plan's paths are relative to; empty: defaultRoot().
/// @throws client::PlanFileError when the plan or a file that it names cannot be read.
/// @pre knowsFormat(output), and hasPages() for a page.
std::string planView(const std::string& plan_text, const std::filesystem::path& output,
                     const std::filesystem::path& root);

}  // namespace handover::view
