// SPDX-License-Identifier: Apache-2.0
// Where everything is at a time of the plan: all running stages of all robots together.
#pragma once

#include "verify/hermite.hpp"
#include "verify/scene.hpp"
#include "verify/task.hpp"

#include <cstddef>
#include <vector>

namespace handover::verify {

/// The curve of one joint (column) between two samples. @pre the stage's times rise.
HermiteQuintic curveOf(const PlanStage& stage, std::size_t segment, std::size_t column);

/// What does not depend on when a stage starts: which joints it really moves, and how fast each is
/// at most in short pieces of its time.
class Curves {
 public:
  explicit Curves(const Scene& scene);

  /// Whether the stage really moves the joint of its robot (followers with their master).
  bool moves(int stage, int joint) const {
    return moved_[static_cast<std::size_t>(stage)][static_cast<std::size_t>(joint)];
  }

  /// Ends of the pieces in the stage's own time, from 0 to its duration.
  const std::vector<double>& cuts(int stage) const {
    return cuts_[static_cast<std::size_t>(stage)];
  }

  /// Greatest |qd| per column in the pieces that meet [from, to] (own time), put into `speeds` by
  /// joint of the robot where they exceed what is there.
  void raiseSpeeds(int stage, double from, double to, std::vector<double>& speeds) const;

  /// Puts the stage's joints at its own time `s`, clamped to its duration, into q.
  void setJoints(int stage, double s, std::vector<double>& q) const;

  const Scene& scene() const { return scene_; }

 private:
  const Scene& scene_;
  std::vector<std::vector<bool>> moved_;
  std::vector<std::vector<double>> cuts_;
  std::vector<std::vector<float>> speeds_;  ///< [stage][piece * columns + column], rounded up
};

/// How fast a point of a link moves [m/s] and the link turns [rad/s], at most.
struct Rates {
  double point = 0, turn = 0;
};

/// Joint positions, link poses and O's pose by time, for given starts of the stages.
class Motion {
 public:
  static constexpr int kAtStart = -1, kAtGoal = -2;

  Motion(const Curves& curves, const Task& task, std::vector<double> starts);

  const Scene& scene() const { return curves_.scene(); }

  const Task& task() const { return task_; }

  const Curves& curves() const { return curves_; }

  double start(int stage) const { return starts_[static_cast<std::size_t>(stage)]; }

  double end(int stage) const { return start(stage) + scene().stage(stage).duration(); }

  /// Of the last stage to end.
  double end() const;

  /// Every joint of the robot at time T; followers by their law.
  void jointsAt(int robot, double T, std::vector<double>& q) const;
  void linksAt(int robot, double T, std::vector<Pose>& X_WL) const;
  Pose linkAt(int robot, int link, double T) const;
  Pose toolAt(int holder, double T) const;

  /// Greatest speed of every joint of the robot on [from, to].
  void topSpeeds(int robot, double from, double to, std::vector<double>& speeds) const;

  /// Of the point p_L of the link on [from, to].
  Rates ratesOf(int robot, int link, const Eigen::Vector3d& p_L, double from, double to) const;

  /// Times from `from` to `to` between which ratesOf() is worth asking for: pieces of the stages of
  /// the robot.
  std::vector<double> cutsOf(int robot, double from, double to) const;

  /// A holder has O from the end of its grasp to the end of its release; one that has it at the
  /// start or keeps it, without end.
  double holdBegins(int holder) const;
  double holdEnds(int holder) const;

  /// The holder that moves O, the later one while two have it; or kAtStart, kAtGoal.
  int carrierAt(double T) const;

  /// X_WO as that holder would have it.
  Pose objectBy(int holder, double T) const;
  Pose objectAt(double T) const;
  /// Of any body, O's too.
  Pose bodyAt(int body, double T) const;
  /// Of an object other than O: standing, or with the link that it is attached to.
  Pose otherObjectAt(int object, double T) const;

 private:
  const Curves& curves_;
  const Task& task_;
  std::vector<double> starts_;
  std::vector<std::vector<int>> stages_of_robot_;  ///< by start
};

/// The starts that the file gives.
std::vector<double> plannedStarts(const Scene& scene);

}  // namespace handover::verify
