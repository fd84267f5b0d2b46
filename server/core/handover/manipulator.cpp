// SPDX-License-Identifier: Apache-2.0
#include "core/handover/manipulator.hpp"

#include "core/handover/prune_grasps.hpp"

#include <algorithm>

namespace handover {
namespace {

std::size_t at(int index) { return static_cast<std::size_t>(index); }

}  // namespace

const std::string& Manipulator::toolLink() const {
  return model->links[at(arm_model->tool_link)].name;
}

ArmVector Manipulator::armOf(const RobotVector& q) const {
  ArmVector q_arm(static_cast<Eigen::Index>(arm_model->dofs.size()));
  for (std::size_t i = 0; i < arm_model->dofs.size(); ++i) {
    q_arm[static_cast<Eigen::Index>(i)] = q[arm_model->dofs[i]];
  }
  return q_arm;
}

RobotVector Manipulator::withArm(RobotVector q, const ArmVector& q_arm) const {
  for (std::size_t i = 0; i < arm_model->dofs.size(); ++i) {
    q[arm_model->dofs[i]] = q_arm[static_cast<Eigen::Index>(i)];
  }
  return q;
}

RobotVector Manipulator::withFingers(RobotVector q, const Eigen::VectorXd& q_fingers) const {
  for (std::size_t i = 0; i < hand->dofs.size(); ++i) {
    q[hand->dofs[i]] = q_fingers[static_cast<Eigen::Index>(i)];
  }
  return q;
}

Eigen::VectorXd Manipulator::fingersOf(const RobotVector& q) const {
  Eigen::VectorXd q_fingers(static_cast<Eigen::Index>(hand->dofs.size()));
  for (std::size_t i = 0; i < hand->dofs.size(); ++i) {
    q_fingers[static_cast<Eigen::Index>(i)] = q[hand->dofs[i]];
  }
  return q_fingers;
}

bool Manipulator::mapReaches(const Pose& X_WT) const {
  return map.near(X_WT.translation(), X_WT.linear() * arm_model->approach_axis);
}

bool Manipulator::reaches(const Pose& X_WT) const {
  IkQuery query;
  // Of the poses within reach of arms of six and seven joints least squares miss 0.5 % at most with
  // half their starts; where there is nothing to find all of these are in vain.
  query.swivel_samples = PruneEffort{}.swivels / (kinematics->closedForm() ? 1 : 2);
  const auto enough = [](const ArmVector&) { return false; };
  return kinematics->visit(worldToArm(X_WT), query, enough).solutions > 0;
}

Pose Manipulator::backedOff(const Pose& X_WT, double distance) const {
  Pose X = X_WT;
  X.translation() -= distance * (X_WT.linear() * arm_model->approach_axis);
  return X;
}

Manipulator makeManipulator(const HandoverProblem& problem, int robot, int arm) {
  const RobotResources& resources = problem.resources[at(robot)];
  Manipulator role;
  role.robot = robot;
  role.arm = arm;
  role.placed = &problem.scene->robots[at(robot)];
  role.model = role.placed->model.get();
  role.arm_model = &role.model->arms[at(arm)];
  role.hand = &role.model->hands[at(role.arm_model->hand)];
  role.kinematics = resources.kinematics[at(arm)].get();
  role.grasps = resources.grasps[at(arm)].get();
  role.map.map = resources.maps[at(arm)].get();
  std::vector<Pose> X_WL;
  linkPoses(*role.model, role.placed->X_WB, role.placed->q_start, X_WL);
  role.map.X_WA = X_WL[at(role.arm_model->base_link)];
  role.map.p_WShoulder = role.map.X_WA * role.kinematics->shoulder();
  for (const int link : role.hand->links) {
    const BodyId body = problem.collision->linkBody(robot, link);
    if (body >= 0) role.hand_bodies.push_back(body);
  }
  return role;
}

std::string unfitReason(const HandoverProblem& problem, int robot, int arm) {
  const SceneRobot& placed = problem.scene->robots[at(robot)];
  const Arm& arm_model = placed.model->arms[at(arm)];
  if (arm_model.hand < 0) return "has no hand";
  std::vector<int> dofs = arm_model.dofs;
  const auto& fingers = placed.model->hands[at(arm_model.hand)].dofs;
  dofs.insert(dofs.end(), fingers.begin(), fingers.end());
  const std::vector<int> moved = placed.model->linksMovedBy(dofs);
  for (const auto& object : problem.scene->objects) {
    if (object.attached_to && object.attached_to->robot == robot &&
        std::binary_search(moved.begin(), moved.end(), object.attached_to->link)) {
      return "holds " + object.name;
    }
  }
  const auto& grasps = problem.resources[at(robot)].grasps[at(arm)];
  if (!grasps || grasps->grasps.empty()) return "has no grasps for " + problem.task.object;
  return {};
}

}  // namespace handover
