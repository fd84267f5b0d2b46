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

struct SceneRobot {
  std::string name;
  std::shared_ptr<const RobotModel> model;
  Pose X_WB = Pose::Identity();
  RobotVector q_start;
  std::vector<std::pair<int, std::string>> resting;  ///< link index, object name
};

struct Attachment {
  int robot = -1;  ///< index in Scene::robots
  int link = -1;
  Pose X_LO = Pose::Identity();
  std::vector<int> touch_links;
};

struct SceneObject {
  std::string name;
  Geometry geometry;             ///< as described, for the plan file
  std::vector<Shape> shapes;     ///< convex parts of it, in O
  Pose X_WO = Pose::Identity();  ///< from the attachment when attached
  std::optional<Attachment> attached_to;
  std::vector<std::string> resting;  ///< objects that it may touch at rest
  /// Wanted numbers of grasps by robot and hand; no part of sceneHash().
  std::map<std::string, std::map<std::string, int>> grasp_counts;
};

struct SceneTask {
  std::string name, object, giver, receiver;
  Pose X_WO_start = Pose::Identity();
  Pose X_WO_goal = Pose::Identity();
  /// What the object rests on at its start, where the task says so; else what the scene says.
  std::optional<std::vector<std::string>> start_rest;
  /// What the object rests on at its goal (may be touched while placing): objects' names.
  std::vector<std::string> goal_rest;
};

struct Scene {
  std::string cell;
  std::uint64_t revision = 0;
  std::vector<SceneRobot> robots;
  std::vector<SceneObject> objects;

  /// Index of a name, or -1.
  int findRobot(std::string_view robot) const;
  int findObject(std::string_view object) const;
};

/// The scene as a task starts: its object at X_WO_start, on start_rest. The same scene when it
/// stands there already.
std::shared_ptr<const Scene> startOf(const std::shared_ptr<const Scene>& scene,
                                     const SceneTask& task);

/// The scene as the wire and the plan file show it; the task's object is at X_WO_start.
SceneSnapshot snapshot(const Scene& scene, const SceneTask& task, std::uint64_t seed);

/// Hash (hex) over everything in the scene and the task that can change a plan: geometry, poses,
/// postures, limits, model files. Left out: the revision, the names of cell and task, grasp counts.
std::string sceneHash(const Scene& scene, const SceneTask& task);

}  // namespace handover
