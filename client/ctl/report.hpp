// SPDX-License-Identifier: Apache-2.0
// Events and status as text for people.
#pragma once

#include <handover/client/answer.hpp>
#include <handover/common/status.hpp>

#include <iosfwd>
#include <optional>

namespace handover::ctl {

/// Prints the search of one request as its events arrive.
class Report {
 public:
  explicit Report(std::ostream& out) : out_(out) {}

  void add(const PlanEvent& event);

  const client::Answer& answer() const { return answer_; }

 private:
  void print(const Accepted& accepted);
  void print(const SceneSnapshot& scene);
  void print(const ArmSelected& arms);
  void print(const GraspsPruned& pruned);
  void print(const HandoverCandidates& candidates);
  void print(const Solution& solution);
  void print(const StageTrajectory& stage);
  void print(const Note& note);
  void print(const Failure& failure);
  void print(const Fix& fix);
  void print(const Outcome& outcome);
  void print(const Workspaces& workspaces);
  void print(const Failed& failed);
  void printPlan();

  std::ostream& out_;  // outlives the report
  double elapsed_s_ = 0;
  std::optional<AnswerId> answer_id_;
  bool explained_ = false, fix_told_ = false;
  client::Answer answer_;
};

void printStatus(std::ostream& out, const DaemonStatus& status);

}  // namespace handover::ctl
