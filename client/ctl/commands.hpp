// SPDX-License-Identifier: Apache-2.0
// The commands of handoverctl, each a function from options to an exit code.
#pragma once

#include <handover/common/exit_code.hpp>
#include <handover/common/plan_event.hpp>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace handover::ctl {

struct CommonOptions {
  int domain = 0;
  std::chrono::milliseconds wait{5000};
  bool json = false;  ///< JSON lines on standard output, everything else on standard error
};

/// What the cell looks like at one moment of the plan, as a Wavefront file.
struct StateDump {
  std::string kind;  ///< start, end, or a stage: its index, or ACTION.HOLDER
  std::string file;
};

struct PlanOptions {
  PlanRequest request;
  std::string output;  ///< plan file, or empty
  std::string html;    ///< page that shows the plan, or empty
  std::vector<StateDump> dumps;
  std::filesystem::path root;  ///< of the paths in a plan; needed for dumps and pages only
};

struct ExperimentOptions {
  /// What the requests share: cell, task and how it is searched; `seed` is the experiment's.
  PlanRequest request;
  std::uint64_t runs = 100;
  int jobs = 1;          ///< requests in flight at once
  double stretch = 1.0;  ///< of the ranges, about their middles
  std::string output;    ///< experiment file, or empty
  std::string html;      ///< page that shows the experiment, or empty
  std::string plans;     ///< folder for plan files, or empty
  bool verify = false;   ///< every plan, by handover-verify
  std::string root;      ///< of the paths in plans, for handover-verify and pages; empty: found
};

struct ViewOptions {
  std::string plan;            ///< plan file
  std::string output;          ///< .html or .mcap
  std::filesystem::path root;  ///< of the paths in the plan; empty: found
};

int runStatus(const CommonOptions& common);
int runCells(const CommonOptions& common);
int runPlan(const CommonOptions& common, const PlanOptions& options);
/// Makes a page or a recording of a plan file; asks no daemon.
int runView(const CommonOptions& common, const ViewOptions& options);
/// Watches one request until its outcome, or all until a signal.
int runWatch(const CommonOptions& common, const std::optional<RequestId>& id);
int runCancel(const CommonOptions& common, const RequestId& id);

/// Plans what is drawn from a cell's variations, run by run. Done when every run was answered,
/// solved or not; else kExitInternal: a plan has violations; kExitUsage: handover-verify cannot
/// read one; kExitConfiguration: more than a tenth of the runs were drawn again since their start
/// scene touches (the file is written, with the runs until then), or the output cannot be written;
/// kExitRejected: nobody serves the cell or its task, or every run was rejected.
int runExperiment(const CommonOptions& common, const ExperimentOptions& options);

int exitCodeOf(const Outcome& outcome);

}  // namespace handover::ctl
