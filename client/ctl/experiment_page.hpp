// SPDX-License-Identifier: Apache-2.0
// An experiment as a page for a browser.
#pragma once

#include "experiment_file.hpp"

#include <string>

namespace handover::ctl {

/// The shell command that asks for a run's plan again.
std::string repeatCommand(const ExperimentRecord& experiment, const RunRecord& run);

/// One self-contained page: the table, how planning times spread, what failed, every run, and where
/// the object changed hands.
std::string experimentPage(const ExperimentRecord& experiment);

}  // namespace handover::ctl
