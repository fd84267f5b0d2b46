// SPDX-License-Identifier: Apache-2.0
// A cell at one moment: robots with posture, objects with poses. Immutable once handed to the
// planner.
#pragma once

#include "core/model/robot_model.hpp"

#include <handover/common/geometry.hpp>
#include <handover/common/plan_event.hpp>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace handover {

using RobotId = Id<struct RobotTag>;    ///< index in Scene::robots
using ObjectId = Id<struct ObjectTag>;  ///< index in Scene::objects

struct SceneRobot {
  std::string name;
  std::shared_ptr<const RobotModel> model;
  Pose X_WB = Pose::Identity();
  RobotVector q_start;
  std::vector<std::pair<LinkId, std::string>> resting;  ///< link, object name
};

struct Attachment {
  RobotId robot;
  LinkId link;
  Pose X_LO = Pose::Identity();
  std::vector<LinkId> touch_links;
};

struct SceneObject {
  std::string name;
  Geometry geometry;                                  ///< as described, for the plan file
  std::vector<Shape> shapes;                          ///< convex parts of it, in O
  std::shared_ptr<const DividedBodies> divided = {};  ///< of `shapes`, in O; null: none
  Pose X_WO = Pose::Identity();                       ///< from the attachment when attached
  std::optional<Attachment> attached_to;
  std::vector<std::string> resting;  ///< objects that it may touch at rest
  /// Wanted numbers of grasps by robot and hand; no part of sceneHash().
  std::map<std::string, std::map<std::string, int>> grasp_counts;
};

/// A place in a chain of holders: a robot, perhaps one of its arms.
struct ChainHolder {
  RobotId robot;
  ArmId arm;  ///< none: any
  bool operator==(const ChainHolder&) const = default;
};

/// What the object rests on at its start or goal (design §5, Rest).
struct TaskRest {
  bool none = false;  ///< nothing below it is asked for: a hook, a fixture
  /// Objects' names; nullopt: all that it rests on there.
  std::optional<std::vector<std::string>> objects;
  bool operator==(const TaskRest&) const = default;
};

struct SceneTask {
  std::string name, object;
  std::vector<ChainHolder> chain;  ///< empty: the planner's choice (`auto`)
  Pose X_WO_start = Pose::Identity();
  Pose X_WO_goal = Pose::Identity();
  /// An arm that has the object in hand at the start.
  std::optional<ChainHolder> held_by;
  TaskRest start_rest, goal_rest;
  TransportEnd end = TransportEnd::kRelease;
  std::optional<UprightSnapshot> upright;  ///< as the plan file says it
};

/// False where the task starts in a hand and its chain begins with another arm.
bool beginsWithHolder(const SceneTask& task);

struct Scene {
  std::string cell;
  std::uint64_t revision = 0;
  std::vector<SceneRobot> robots;
  std::vector<SceneObject> objects;

  /// By name; none if there is none.
  RobotId findRobot(std::string_view robot) const;
  ObjectId findObject(std::string_view object) const;
};

/// The scene as a task starts: its object at X_WO_start, on start_rest where the task names it. The
/// same scene when it stands there already.
std::shared_ptr<const Scene> startOf(const std::shared_ptr<const Scene>& scene,
                                     const SceneTask& task);

/// The scene as the wire and the plan file show it; the task's object is at X_WO_start, its rests
/// those of the task.
SceneSnapshot snapshot(const Scene& scene, const SceneTask& task, std::uint64_t seed);

/// Hash (hex) over everything in the scene and the task that can change a plan: geometry, poses,
/// postures, limits, model files. Left out: the revision, the names of cell and task, grasp counts.
std::string sceneHash(const Scene& scene, const SceneTask& task);

}  // namespace handover
