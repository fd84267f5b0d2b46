// SPDX-License-Identifier: Apache-2.0
// The plan together with everything it names: robots, hands, geometry. Loaded once, then only read.
#pragma once

#include "verify/body.hpp"
#include "verify/kinematics.hpp"
#include "verify/plan_file.hpp"
#include "verify/report.hpp"
#include "verify/robot.hpp"

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

/// One of the two robots at the handover.
struct Party {
  int robot = -1;
  Arm arm;
};

struct Scene {
  Plan plan;
  std::vector<Robot> robots;                 ///< as in plan.robots
  std::vector<Kinematics> kinematics;        ///< likewise
  std::vector<std::vector<double>> q_start;  ///< per robot, per joint, from the file
  Party giver, receiver;
  int object = -1;  ///< index of O in plan.objects
  std::vector<SceneBody> bodies;
  int object_body = -1;  ///< O in bodies

  const Party& partyOf(const PlanEvent& stage) const {
    return plan.findRobot(stage.robot) == giver.robot ? giver : receiver;
  }
};

/// @throws Unreadable for missing or malformed files and unknown names of links and joints.
/// A URDF that is not the one the plan was made with is a violation, not unreadable.
Scene loadScene(Plan plan, const std::filesystem::path& root, Report& report);

}  // namespace handover::verify
