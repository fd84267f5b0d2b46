// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace handover {

/// Tells systemd, where it started this process as Type=notify, how it is: "READY=1",
/// "WATCHDOG=1", "STOPPING=1", "STATUS=text". Nothing elsewhere. Safe from any thread.
void tellServiceManager(std::string_view state);

}  // namespace handover
