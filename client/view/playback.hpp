// SPDX-License-Identifier: Apache-2.0
// Where everything in the cell is while a plan runs.
#pragma once

#include "view/robot.hpp"

#include <handover/client/plan_motion.hpp>

#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace handover::view {

class RootFiles;

/// The cell at one moment, in the order of the scene's robots and objects.
struct Moment {
  std::vector<Positions> q;
  std::vector<std::vector<Pose>> X_WL;
  std::vector<Pose> X_WO;
};

class Playback {
 public:
  /// @throws PlanFileError without scene or plan, for a URDF that cannot be read, and for links
  /// that are not there.
  Playback(client::PlanFile file, const RootFiles& files);

  const SceneSnapshot& scene() const { return motion_.scene(); }

  const client::Plan& plan() const { return motion_.plan(); }

  /// The scene's robots' models.
  const std::vector<Robot>& models() const { return models_; }

  /// The plan's end [s].
  double duration() const { return motion_.duration(); }

  /// "robot/arm action".
  std::string labelOf(const StageTrajectory& stage) const;

  Moment at(double time) const;

 private:
  /// A link of a robot of the scene.
  struct LinkPlace {
    std::size_t robot = 0, link = 0;
  };

  /// From the end of a grasp, or the plan's start, to the end of a release, or for good [s].
  struct HoldTime {
    double from = 0, to = std::numeric_limits<double>::infinity();
  };

  LinkPlace linkOf(const std::string& robot, const std::string& link) const;
  void findHolds();
  /// Without objects.
  Moment robotsAt(double time) const;
  Pose heldBy(std::size_t holder, const Moment& moment) const;
  Pose plannedObjectAt(double time, const Moment& moment) const;
  Pose objectAt(std::size_t index, double time, const Moment& moment) const;

  client::PlanMotion motion_;
  std::vector<Robot> models_;
  std::vector<LinkPlace> tools_;                       ///< of the plan's holders
  std::vector<HoldTime> holds_;                        ///< likewise
  std::vector<std::optional<LinkPlace>> attached_to_;  ///< of the scene's objects
  Pose X_WO_end_ = Pose::Identity();                   ///< where the last holder leaves the object
};

}  // namespace handover::view
