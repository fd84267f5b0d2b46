// SPDX-License-Identifier: Apache-2.0
// An experiment as a page for a browser.
#pragma once

#include "experiment_file.hpp"

#include <string>
#include <vector>

namespace handover::ctl {

/// What the page shows of a run beyond its record.
struct PageRun {
  std::vector<LatticeCell> lattice;  ///< crossed maps of the first handover's arms, best cell first
  std::vector<HandoverPlace> handovers;
  std::string page;  ///< address of the page of a failure, relative to this one; empty: none
};

/// What the page shows of an experiment beyond its file.
struct PageExtras {
  std::string task;  ///< empty: the cell's first
  std::string daemon_version;
  std::vector<PageRun> runs;  ///< one for each record
};

/// The shell command that asks for a run's plan again.
/// @param file   an experiment file (format handover-experiment/2).
/// @param record of its `records`.
std::string repeatCommand(const client::Json& file, const client::Json& record,
                          const std::string& task);

/// One self-contained page: the table, how planning times spread, what the plans are like, what
/// failed, every run, and where the object changed hands.
/// @throws nlohmann::json::exception for a file of another form, std::out_of_range when
/// `extras.runs` are fewer than its records.
std::string experimentPage(const client::Json& file, const PageExtras& extras);

}  // namespace handover::ctl
