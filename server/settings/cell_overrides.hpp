// SPDX-License-Identifier: Apache-2.0
// Overrides set into a cell's document, before the document's own reader checks the whole.
#pragma once

#include "settings/yaml_reader.hpp"

#include <handover/common/plan_event.hpp>

#include <vector>

namespace handover {

/// Sets every override, in order. Only entries of robots, objects and tasks that the document has
/// can be changed; keys below them may be new, the reader decides. Returns the faults, by the
/// override's path.
std::vector<Fault> applyOverrides(YamlNode& document, const std::vector<Override>& overrides);

/// Faults of the reader, told by the override that they come from where there is one: the last one
/// whose path leads to the fault, or through it.
std::vector<Fault> asOverrideFaults(const YamlReport& report,
                                    const std::vector<Override>& overrides);

}  // namespace handover
