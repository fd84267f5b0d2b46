// SPDX-License-Identifier: Apache-2.0
// The pages without their data, as the bundler made them.
#pragma once

#include <optional>
#include <string_view>

namespace handover::view {

/// Both hold "@DATA@" once, where JSON is to stand.
struct PageTemplates {
  std::string_view plan, experiment;
};

/// nullopt: this build has no pages.
std::optional<PageTemplates> pageTemplates();

}  // namespace handover::view
