// SPDX-License-Identifier: Apache-2.0
// A plan as motion: where every joint of its cell is at any moment.
#pragma once

#include <handover/client/plan_file.hpp>

#include <cstddef>
#include <string>
#include <vector>

namespace handover::client {

struct JointState {
  double q = 0, qd = 0, qdd = 0;  ///< [rad] or [m], and per s and s^2
  bool operator==(const JointState&) const = default;
};

/// The quintic Hermite curve of a stage's column at `s` seconds of the stage's own time, held at
/// its ends beyond them. @pre column < stage.joints.size().
JointState sampleStage(const StageTrajectory& stage, std::size_t column, double s);

/// The joints of a plan's robots over time. Keeps what it is made of; safe from any thread.
class PlanMotion {
 public:
  /// @throws PlanFileError without scene or plan, and where a stage moves a joint that its robot's
  /// q_start does not have.
  explicit PlanMotion(PlanFile file);

  const SceneSnapshot& scene() const { return *file_.scene; }

  const Plan& plan() const { return *file_.plan; }

  /// The plan's end [s].
  double duration() const { return duration_; }

  /// Every joint of a robot, in the order of its `q_start`, `t` seconds after the plan's start: on
  /// a running stage's curve, else where the last stage left it, else as at the start. A mimic
  /// joint stays as at the start: its law is in the URDF. @pre robot < scene().robots.size().
  std::vector<JointState> sample(std::size_t robot, double t) const;

  /// The stages that run at `t`, by index; an ended one does not.
  std::vector<std::size_t> running(double t) const;

 private:
  struct Use {
    std::size_t stage, column;
  };

  PlanFile file_;
  double duration_ = 0;
  /// By robot and joint: the stages that move it, by start.
  std::vector<std::vector<std::vector<Use>>> uses_;
};

}  // namespace handover::client
