// SPDX-License-Identifier: Apache-2.0
#include "core/grasp/hand_model.hpp"

#include "core/grasp/surface_samples.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace handover {
namespace {

std::size_t at(int index) { return static_cast<std::size_t>(index); }

int dofIn(const RobotModel& from, int dof, const RobotModel& to) {
  const int joint = from.dof_joints[at(dof)];
  const int found = to.findJoint(from.joints[at(joint)].name);
  if (found < 0) throw std::invalid_argument("a hand's joint is not beyond the wrist");
  return to.joints[at(found)].dof;
}

std::vector<int> dofsIn(const RobotModel& from, const std::vector<int>& dofs,
                        const RobotModel& to) {
  std::vector<int> mapped;
  for (const int dof : dofs) mapped.push_back(dofIn(from, dof, to));
  return mapped;
}

std::vector<int> linksIn(const RobotModel& from, const std::vector<int>& links,
                         const RobotModel& to) {
  std::vector<int> mapped;
  for (const int link : links) {
    const int found = to.findLink(from.links[at(link)].name);
    if (found >= 0) mapped.push_back(found);
  }
  return mapped;
}

/// The part of the robot at and beyond `root`, as a robot of its own.
RobotModel subtree(const RobotModel& model, int root) {
  RobotModel sub;
  sub.name = model.name;
  std::vector<int> link_at(model.links.size(), -1);
  link_at[at(root)] = 0;
  sub.links.push_back(model.links[at(root)]);
  sub.links[0].parent_joint = -1;
  std::vector<int> masters;  // dofs of `model` in the order of sub's
  for (const Joint& joint : model.joints) {
    const int parent = link_at[at(joint.parent_link)];
    if (parent < 0 || joint.child_link == root) continue;
    const int child = static_cast<int>(sub.links.size());
    link_at[at(joint.child_link)] = child;
    sub.links.push_back(model.links[at(joint.child_link)]);
    sub.links.back().parent_joint = static_cast<int>(sub.joints.size());
    sub.joints.push_back(joint);
    sub.joints.back().parent_link = parent;
    sub.joints.back().child_link = child;
    if (joint.type != JointType::kFixed && !joint.mimic) masters.push_back(joint.dof);
  }
  sub.dof_joints.assign(masters.size(), -1);
  for (std::size_t j = 0; j < sub.joints.size(); ++j) {
    Joint& joint = sub.joints[j];
    if (joint.type == JointType::kFixed) continue;
    const auto found = std::find(masters.begin(), masters.end(), joint.dof);
    if (found == masters.end())
      throw std::invalid_argument("joint " + joint.name + " of a hand mimics one outside it");
    joint.dof = static_cast<int>(found - masters.begin());
    if (!joint.mimic) sub.dof_joints[at(joint.dof)] = static_cast<int>(j);
  }
  for (const auto& [pair, reason] : model.disabled_pairs) {
    const int a = link_at[at(pair.first)];
    const int b = link_at[at(pair.second)];
    if (a >= 0 && b >= 0) sub.disabled_pairs[std::minmax(a, b)] = reason;
  }
  return sub;
}

}  // namespace

std::vector<Eigen::Vector3d> outline(const Link& link) {
  std::vector<Eigen::Vector3d> points;
  for (const Shape& shape : link.collision) {
    const ConvexPart part = toConvexPart(shape);
    points.insert(points.end(), part.vertices.begin(), part.vertices.end());
  }
  return points;
}

RobotVector restingPosture(const RobotModel& model) {
  RobotVector q = RobotVector::Zero(model.dofs());
  for (int dof = 0; dof < model.dofs(); ++dof) {
    const Joint& joint = model.joints[at(model.dof_joints[at(dof)])];
    q[dof] = std::clamp(0.0, joint.lower, joint.upper);
  }
  return q;
}

std::shared_ptr<const CollisionScene> handAndObject(const SceneObject& object,
                                                    const HandModel& hand) {
  Scene scene;
  scene.cell = "grasp";
  SceneRobot robot;
  robot.name = "hand";
  robot.model = hand.model;
  robot.q_start = restingPosture(*hand.model);
  scene.robots.push_back(robot);
  SceneObject alone;
  alone.name = object.name;
  alone.geometry = object.geometry;
  alone.shapes = object.shapes;
  scene.objects.push_back(alone);
  return std::make_shared<const CollisionScene>(scene);
}

HandModel extractEndEffector(const RobotModel& model, int arm) {
  if (arm < 0 || arm >= static_cast<int>(model.arms.size()))
    throw std::invalid_argument("no such arm");
  const Arm& a = model.arms[at(arm)];
  if (a.hand < 0) throw std::invalid_argument("arm " + a.name + " has no hand");
  const Hand& full = model.hands[at(a.hand)];
  const int root = a.joints.empty() ? 0 : model.joints[at(a.joints.back())].child_link;

  HandModel cut;
  cut.model = std::make_shared<const RobotModel>(subtree(model, root));
  const RobotModel& sub = *cut.model;
  cut.approach_T = a.approach_axis;
  cut.hand = full;
  cut.hand.palm_link = sub.findLink(model.links[at(full.palm_link)].name);
  if (cut.hand.suction) cut.hand.suction->cup_link = cut.hand.palm_link;
  cut.hand.finger_links = linksIn(model, full.finger_links, sub);
  cut.hand.links = linksIn(model, full.links, sub);
  cut.hand.dofs = dofsIn(model, full.dofs, sub);
  for (auto& finger : cut.hand.fingers) finger = dofsIn(model, finger, sub);
  const int tool = sub.findLink(model.links[at(a.tool_link)].name);
  if (tool < 0 || cut.hand.palm_link < 0) {
    throw std::invalid_argument("tool or palm of arm " + a.name + " is not beyond its last joint");
  }
  std::vector<Pose> X_RL;
  linkPoses(sub, Pose::Identity(), restingPosture(sub), X_RL);
  cut.X_RT = X_RL[at(tool)];
  // A palm may be a bare frame on the link that carries its shape: then that link counts.
  int palm = cut.hand.palm_link;
  cut.palm_extent = -std::numeric_limits<double>::infinity();
  while (sub.links[at(palm)].collision.empty()) {
    if (cut.hand.suction) return cut;
    if (palm == 0) throw std::invalid_argument("the palm of arm " + a.name + " has no shapes");
    palm = sub.joints[at(sub.links[at(palm)].parent_joint)].parent_link;
  }
  const Pose X_TP = cut.X_RT.inverse() * X_RL[at(palm)];
  for (const auto& p : outline(sub.links[at(palm)])) {
    cut.palm_extent = std::max(cut.palm_extent, cut.approach_T.dot(X_TP * p));
  }
  return cut;
}

}  // namespace handover
