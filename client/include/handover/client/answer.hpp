// SPDX-License-Identifier: Apache-2.0
// The stream of an answer, gathered: the plan file from it, and one JSON line per event.
#pragma once

#include <handover/client/plan_file.hpp>
#include <handover/common/plan_event.hpp>

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace handover::client {

/// How long a plan's motions take.
struct MotionTime {
  double motion_s = 0;         ///< from the start to the end of the last stage
  double overlap_saves_s = 0;  ///< how much less that is than one stage after the other
  bool operator==(const MotionTime&) const = default;
};

/// Gathers the events of one request and writes the plan file (format handover-plan/2) from them
/// alone. For equal events, elapsed times apart, the texts of the members "scene" and "plan" are
/// the same to the byte. An event of another answer_id drops what was gathered.
class Answer {
 public:
  void add(const PlanEvent& event);

  /// Nullptr before the outcome.
  const Outcome* outcome() const { return outcome_ ? &*outcome_ : nullptr; }

  /// True once the outcome is done and every stage of its solution is there.
  bool hasPlan() const;
  /// True when text() has something to say: hasPlan(), or the outcome is a failure.
  bool writable() const;

  /// True once the scene is known: before it there is nothing to look at.
  bool hasScene() const { return scene_.has_value(); }

  /// The file's text. @throws std::logic_error unless writable().
  std::string text() const;

  /// The final solution; nullptr unless the outcome is done.
  const Solution* solution() const;
  /// Stages of the final solution in the order of the plan; empty unless the outcome is done.
  std::vector<const StageTrajectory*> trajectories() const;

  /// Of trajectories().
  MotionTime motionTime() const;

  /// [s] until the last stage of the first whole plan had left the daemon.
  std::optional<double> firstPlanSeconds() const { return first_plan_s_; }

  /// Cost of the first whole plan.
  std::optional<double> firstCost() const { return first_cost_; }

 private:
  void take(const Accepted& accepted);
  void take(const SceneSnapshot& scene);
  void take(const ArmSelected& arms);
  void take(const GraspsPruned& pruned);
  void take(const HandoverCandidates& candidates);
  void take(const Solution& solution);
  void take(const StageTrajectory& stage);
  void take(const Note& note);
  void take(const Failure& failure);
  void take(const Fix& fix);
  void take(const Outcome& outcome);
  void take(const Workspaces& workspaces);
  std::optional<Failure> failure() const;

  std::optional<AnswerId> id_;
  std::vector<std::pair<std::string, double>> elapsed_;  ///< first of each kind of event [s]
  double last_elapsed_s_ = 0;
  std::optional<double> first_plan_s_, first_cost_;
  Accepted accepted_;
  std::optional<SceneSnapshot> scene_;
  std::vector<ArmSelected> arms_;
  std::vector<GraspsPruned> pruned_;
  std::vector<HandoverCandidates> candidates_;
  std::vector<Note> notes_;
  std::optional<Fix> fix_;
  std::optional<Workspaces> workspaces_;
  std::map<std::uint32_t, Solution> solutions_;
  std::map<std::uint32_t, std::map<std::uint32_t, StageTrajectory>> stages_;
  std::optional<Outcome> outcome_;
};

/// "accepted", "scene", "arm_selected", "grasps_pruned", "handover_candidates", "solution",
/// "trajectory", "note", "failure", "fix", "outcome" or "workspaces".
const char* payloadName(const PlanEventPayload& payload);

/// An event as one line of JSON, no line break: request_id, answer_id, sequence, elapsed_s, type
/// and the payload.
std::string jsonLine(const PlanEvent& event);

}  // namespace handover::client
