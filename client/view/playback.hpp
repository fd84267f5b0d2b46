// SPDX-License-Identifier: Apache-2.0
// Where everything in the cell is while a plan runs.
#pragma once

#include "view/motion.hpp"
#include "view/robot.hpp"

#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <string>
#include <vector>

namespace handover::view {

class RootFiles;

struct SceneRobot {
  std::string name, urdf;
  Robot model;
  Pose X_WB = Pose::Identity();
  Positions q_start;
};

/// A link of a robot of the scene.
struct LinkPlace {
  std::size_t robot = 0, link = 0;
};

struct SceneObject {
  std::string name;
  Geometry geometry;
  Pose X_WO = Pose::Identity();          ///< at the start
  std::optional<LinkPlace> attached_to;  ///< for good
  Pose X_LO = Pose::Identity();
};

struct Holder {
  std::string robot, arm;
  LinkPlace tool;
  Pose X_TO = Pose::Identity();
};

/// The cell at one moment, in the order of robots, links and objects.
struct Moment {
  std::vector<Positions> q;
  std::vector<std::vector<Pose>> X_WL;
  std::vector<Pose> X_WO;
};

class Playback {
 public:
  /// @param file a plan file with a plan. @throws Unreadable, nlohmann::json::exception, or
  /// std::out_of_range for a name of a robot or link that is not there.
  Playback(const nlohmann::json& file, const RootFiles& files);

  const std::vector<SceneRobot>& robots() const { return robots_; }

  const std::vector<SceneObject>& objects() const { return objects_; }

  /// Index of the object that is brought.
  std::size_t object() const { return object_; }

  const std::vector<Holder>& holders() const { return holders_; }

  const Motion& motion() const { return motion_; }

  Moment at(double time) const;

 private:
  LinkPlace linkOf(const std::string& robot, const std::string& link) const;
  void addObject(const nlohmann::json& json);
  /// Without objects.
  Moment robotsAt(double time) const;
  Pose heldBy(const Holder& holder, const Moment& moment) const;
  Pose plannedObjectAt(double time, const Moment& moment) const;
  Pose objectAt(std::size_t index, double time, const Moment& moment) const;

  std::vector<SceneRobot> robots_;
  std::vector<SceneObject> objects_;
  std::size_t object_ = 0;
  std::vector<Holder> holders_;
  Motion motion_;
  Pose X_WO_end_ = Pose::Identity();  ///< where the last holder leaves the object
};

}  // namespace handover::view
