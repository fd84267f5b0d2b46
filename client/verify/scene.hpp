// SPDX-License-Identifier: Apache-2.0
// The plan together with everything it names: robots, hands, geometry. Loaded once, then only read.
#pragma once

#include "verify/body.hpp"
#include "verify/kinematics.hpp"
#include "verify/plan_file.hpp"
#include "verify/report.hpp"
#include "verify/robot.hpp"
#include "verify/robot_settings.hpp"

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace handover::verify {

/// A robot's link with geometry, or an object.
struct SceneBody {
  std::string name;  ///< `robot/link` or object
  int robot = -1, link = -1;
  int object = -1;
  Body body;
};

/// A holder with its names looked up.
struct Holder {
  int robot = -1;
  int tool_link = -1;
  std::vector<int> arm_joints;      ///< independent joints of the SRDF group above the tool link
  std::vector<int> gripper_joints;  ///< independent joints beyond the arm's last one
  std::vector<int> hand_links;      ///< palm and fingers, or the cup link
  std::vector<int> finger_links;
  std::vector<int> hand_bodies;  ///< of hand_links that have geometry, in Scene::bodies
  bool group_known = false;      ///< the SRDF has the arm's group
};

struct Scene {
  Plan plan;
  std::vector<Robot> robots;                 ///< as in plan.robots
  std::vector<RobotSettings> settings;       ///< likewise
  std::vector<Kinematics> kinematics;        ///< likewise
  std::vector<std::vector<double>> q_start;  ///< per robot, per joint, from the file
  std::vector<Holder> holders;               ///< as in plan.holders
  int object = -1;                           ///< O in plan.objects
  std::vector<SceneBody> bodies;
  int object_body = -1;                        ///< O in bodies
  std::vector<std::vector<int>> stage_joints;  ///< per stage and column: joint of its robot
  std::vector<int> stage_robot;                ///< per stage

  const PlanStage& stage(int s) const { return plan.stages[static_cast<std::size_t>(s)]; }

  const Robot& robot(int r) const { return robots[static_cast<std::size_t>(r)]; }

  const Holder& holder(int k) const { return holders[static_cast<std::size_t>(k)]; }

  const PlanHolder& planHolder(int k) const { return plan.holders[static_cast<std::size_t>(k)]; }

  const SceneBody& body(int b) const { return bodies[static_cast<std::size_t>(b)]; }

  const PlanObject& planObject(int o) const { return plan.objects[static_cast<std::size_t>(o)]; }

  int stageCount() const { return static_cast<int>(plan.stages.size()); }

  int holderCount() const { return static_cast<int>(plan.holders.size()); }

  /// "hubo right_arm grasp".
  std::string stageName(int stage) const;
};

/// @throws Unreadable for missing or malformed files and unknown names of links and joints.
/// A URDF or yaml that is not the one the plan was made with is a violation, not unreadable.
Scene loadScene(Plan plan, const std::filesystem::path& root, Report& report);

}  // namespace handover::verify
