// SPDX-License-Identifier: Apache-2.0
#include "core/planning/manipulator.hpp"

#include <algorithm>

namespace handover {
namespace {

constexpr PruneEffort kPruneEffort;

}  // namespace

const std::string& Manipulator::toolLink() const { return model->links[arm_model->tool_link].name; }

ArmVector Manipulator::armOf(const RobotVector& q) const {
  ArmVector q_arm(static_cast<Eigen::Index>(arm_model->dofs.size()));
  for (std::size_t i = 0; i < arm_model->dofs.size(); ++i) {
    q_arm[static_cast<Eigen::Index>(i)] = q[arm_model->dofs[i].value()];
  }
  return q_arm;
}

RobotVector Manipulator::withArm(RobotVector q, const ArmVector& q_arm) const {
  for (std::size_t i = 0; i < arm_model->dofs.size(); ++i) {
    q[arm_model->dofs[i].value()] = q_arm[static_cast<Eigen::Index>(i)];
  }
  return q;
}

RobotVector Manipulator::withFingers(RobotVector q, const Eigen::VectorXd& q_fingers) const {
  for (std::size_t i = 0; i < hand->dofs.size(); ++i) {
    q[hand->dofs[i].value()] = q_fingers[static_cast<Eigen::Index>(i)];
  }
  return q;
}

Eigen::VectorXd Manipulator::fingersOf(const RobotVector& q) const {
  Eigen::VectorXd q_fingers(static_cast<Eigen::Index>(hand->dofs.size()));
  for (std::size_t i = 0; i < hand->dofs.size(); ++i) {
    q_fingers[static_cast<Eigen::Index>(i)] = q[hand->dofs[i].value()];
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
  query.swivel_samples = kPruneEffort.swivels / (kinematics->closedForm() ? 1 : 2);
  const auto enough = [](const ArmVector&) { return false; };
  return kinematics->visit(worldToArm(X_WT), query, enough).solutions > 0;
}

Pose Manipulator::backedOff(const Pose& X_WT, double distance) const {
  Pose X = X_WT;
  X.translation() -= distance * (X_WT.linear() * arm_model->approach_axis);
  return X;
}

double travelTime(const Manipulator& manipulator, const ArmVector& from, const ArmVector& to) {
  return ((to - from).cwiseAbs().array() / manipulator.kinematics->velocity().array()).maxCoeff();
}

Pose handoverPose(const Manipulator& giver, const Manipulator& receiver, const Grasp& grasp,
                  const Pose& X_WO_give, const Eigen::Vector3d& p_W, const ApproachOffset& offset,
                  bool object_on_point, const std::optional<TiltLimit>& tilt) {
  const Pose X_WT_give = X_WO_give * grasp.X_OT;
  Pose X_WT = Pose::Identity();
  X_WT.linear() = handoverRotation(X_WT_give.linear(), receiver.arm_model->approach_axis,
                                   giver.map.p_WShoulder, receiver.map.p_WShoulder, offset);
  if (!object_on_point && tilt) {
    X_WT.linear() = tilt->turnWithin((X_WT * grasp.X_OT.inverse()).linear()) * X_WT.linear();
  }
  if (!object_on_point) X_WT.translation() = p_W;
  Pose X_WH = X_WT * grasp.X_OT.inverse();
  if (object_on_point) X_WH.translation() = p_W;
  return X_WH;
}

Manipulator makeManipulator(const TransportProblem& problem, RobotId robot, ArmId arm) {
  const RobotResources& resources = problem.resources[robot];
  Manipulator it;
  it.robot = robot;
  it.arm = arm;
  it.placed = &problem.scene->robots[robot];
  it.model = it.placed->model.get();
  it.arm_model = &it.model->arms[arm];
  it.hand = &it.model->hands[it.arm_model->hand];
  it.kinematics = resources.kinematics[arm].get();
  it.grasps = resources.grasps[arm].get();
  it.map.map = resources.maps[arm].get();
  std::vector<Pose> X_WL;
  linkPoses(*it.model, it.placed->X_WB, it.placed->q_start, X_WL);
  it.map.X_WA = X_WL[it.arm_model->base_link];
  it.map.p_WShoulder = it.map.X_WA * it.kinematics->shoulder();
  if (const auto& reach = it.kinematics->wristReach()) {
    for (const Grasp& grasp : it.grasps->grasps)
      it.p_OWrist.push_back(grasp.X_OT * reach->p_TWrist);
  }
  for (const LinkId link : it.hand->links) {
    const BodyId body = problem.collision->linkBody(robot, link);
    if (body.valid()) it.hand_bodies.push_back(body);
  }
  return it;
}

std::optional<Unfit> unfitReason(const TransportProblem& problem, RobotId robot, ArmId arm) {
  const SceneRobot& placed = problem.scene->robots[robot];
  const Arm& arm_model = placed.model->arms[arm];
  if (!arm_model.hand.valid()) return Unfit{Cause::kNoGripper, {}};
  std::vector<DofId> dofs = arm_model.dofs;
  const auto& fingers = placed.model->hands[arm_model.hand].dofs;
  dofs.insert(dofs.end(), fingers.begin(), fingers.end());
  const std::vector<LinkId> moved = placed.model->linksMovedBy(dofs);
  for (const auto& object : problem.scene->objects) {
    if (object.attached_to && object.attached_to->robot == robot &&
        std::binary_search(moved.begin(), moved.end(), object.attached_to->link)) {
      return Unfit{Cause::kHoldsObject, object.name};
    }
  }
  const auto& grasps = problem.resources[robot].grasps[arm];
  if (!grasps || grasps->grasps.empty()) return Unfit{Cause::kNoGrasps, {}};
  return std::nullopt;
}

}  // namespace handover
