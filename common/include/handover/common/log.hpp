// SPDX-License-Identifier: Apache-2.0
// One logger per module tag, all writing to standard error: standard output belongs to answers.
#pragma once

#include <spdlog/spdlog.h>

#include <memory>
#include <string>

namespace handover {

/// The logger of a module ("runtime", "dds", "maps"); made on first use. Safe from any thread.
std::shared_ptr<spdlog::logger> logger(const std::string& tag);

/// Sets the level of all loggers, present and future: trace, debug, info, warn, error, off.
void setLogLevel(spdlog::level::level_enum level);

}  // namespace handover
