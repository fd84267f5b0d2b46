// SPDX-License-Identifier: Apache-2.0
#include "view/page_templates.hpp"

namespace handover::view {

std::optional<PageTemplates> pageTemplates() { return std::nullopt; }

}  // namespace handover::view
