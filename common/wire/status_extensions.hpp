// SPDX-License-Identifier: Apache-2.0
// What became part of a daemon's status after its type was fixed; idl/handover.idl lists the keys.
#pragma once

#include <handover/common/status.hpp>

#include <handover.h>

#include <vector>

namespace handover::wire {

std::vector<msg::KeyValue> extensionsOf(const DaemonStatus& status);

/// Fills in what they say; the cells are there. What is absent or unreadable keeps its default.
void takeExtensions(const std::vector<msg::KeyValue>& extensions, DaemonStatus& status);

}  // namespace handover::wire
