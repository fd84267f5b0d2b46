// SPDX-License-Identifier: Apache-2.0
// Stages and status as text for people.
#pragma once

#include <handover/client/plan_file.hpp>
#include <handover/common/status.hpp>

#include <iosfwd>

namespace handover::ctl {

/// Prints the search of one request as its stages arrive.
class Report {
 public:
  explicit Report(std::ostream& out) : out_(out) {}

  void add(const PlanEvent& stage);

  const client::PlanFile& plan() const { return plan_; }

 private:
  void print(const Accepted& accepted);
  void print(const SceneSnapshot& scene);
  void print(const ArmSelected& arms);
  void print(const GraspsPruned& pruned);
  void print(const HandoverCandidates& candidates);
  void print(const Solution& solution);
  void print(const StageTrajectory& stage);
  void print(const Outcome& outcome);
  void printPlan();

  std::ostream& out_;  // outlives the report
  double elapsed_s_ = 0;
  client::PlanFile plan_;
};

void printStatus(std::ostream& out, const DaemonStatus& status);

}  // namespace handover::ctl
