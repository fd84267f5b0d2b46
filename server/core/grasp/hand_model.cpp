// SPDX-License-Identifier: Apache-2.0
#include "core/grasp/hand_model.hpp"

#include "core/grasp/surface_samples.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace handover {
namespace {

DofId dofIn(const RobotModel& from, DofId dof, const RobotModel& to) {
  const JointId joint = from.dof_joints[dof];
  const JointId found = to.findJoint(from.joints[joint].name);
  if (!found.valid()) throw std::invalid_argument("a hand's joint is not beyond the wrist");
  return to.joints[found].dof;
}

std::vector<DofId> dofsIn(const RobotModel& from, const std::vector<DofId>& dofs,
                          const RobotModel& to) {
  std::vector<DofId> mapped;
  for (const DofId dof : dofs) mapped.push_back(dofIn(from, dof, to));
  return mapped;
}

std::vector<LinkId> linksIn(const RobotModel& from, const std::vector<LinkId>& links,
                            const RobotModel& to) {
  std::vector<LinkId> mapped;
  for (const LinkId link : links) {
    const LinkId found = to.findLink(from.links[link].name);
    if (found.valid()) mapped.push_back(found);
  }
  return mapped;
}

/// The part of the robot at and beyond `root`, as a robot of its own.
RobotModel subtree(const RobotModel& model, LinkId root) {
  RobotModel sub;
  sub.name = model.name;
  std::vector<LinkId> link_at(model.links.size());
  link_at[root] = LinkId(0);
  sub.links.push_back(model.links[root]);
  sub.links[0].parent_joint = {};
  std::vector<DofId> masters;  // dofs of `model` in the order of sub's
  for (const Joint& joint : model.joints) {
    const LinkId parent = link_at[joint.parent_link];
    if (!parent.valid() || joint.child_link == root) continue;
    const LinkId child(sub.links.size());
    link_at[joint.child_link] = child;
    sub.links.push_back(model.links[joint.child_link]);
    sub.links.back().parent_joint = JointId(sub.joints.size());
    sub.joints.push_back(joint);
    sub.joints.back().parent_link = parent;
    sub.joints.back().child_link = child;
    if (joint.type != JointType::kFixed && !joint.mimic) masters.push_back(joint.dof);
  }
  sub.dof_joints.resize(masters.size());
  for (const JointId j : IdRange<JointId>(sub.joints.size())) {
    Joint& joint = sub.joints[j];
    if (joint.type == JointType::kFixed) continue;
    const auto found = std::find(masters.begin(), masters.end(), joint.dof);
    if (found == masters.end())
      throw std::invalid_argument("joint " + joint.name + " of a hand mimics one outside it");
    joint.dof = DofId(found - masters.begin());
    if (!joint.mimic) sub.dof_joints[joint.dof] = j;
  }
  for (const auto& [pair, reason] : model.disabled_pairs) {
    const LinkId a = link_at[pair.first], b = link_at[pair.second];
    if (a.valid() && b.valid()) sub.disabled_pairs[std::minmax(a, b)] = reason;
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
  for (const DofId dof : IdRange<DofId>(model.dofs())) {
    const Joint& joint = model.joints[model.dof_joints[dof]];
    q[dof.value()] = std::clamp(0.0, joint.lower, joint.upper);
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

HandModel extractEndEffector(const RobotModel& model, ArmId arm) {
  if (!arm.valid() || std::size_t{arm} >= model.arms.size())
    throw std::invalid_argument("no such arm");
  const Arm& a = model.arms[arm];
  if (!a.hand.valid()) throw std::invalid_argument("arm " + a.name + " has no hand");
  const Hand& full = model.hands[a.hand];
  const LinkId root = a.joints.empty() ? LinkId(0) : model.joints[a.joints.back()].child_link;

  HandModel cut;
  cut.model = std::make_shared<const RobotModel>(subtree(model, root));
  const RobotModel& sub = *cut.model;
  cut.approach_T = a.approach_axis;
  cut.hand = full;
  cut.hand.palm_link = sub.findLink(model.links[full.palm_link].name);
  if (cut.hand.suction) cut.hand.suction->cup_link = cut.hand.palm_link;
  cut.hand.finger_links = linksIn(model, full.finger_links, sub);
  cut.hand.links = linksIn(model, full.links, sub);
  cut.hand.dofs = dofsIn(model, full.dofs, sub);
  for (auto& finger : cut.hand.fingers) finger = dofsIn(model, finger, sub);
  const LinkId tool = sub.findLink(model.links[a.tool_link].name);
  if (!tool.valid() || !cut.hand.palm_link.valid()) {
    throw std::invalid_argument("tool or palm of arm " + a.name + " is not beyond its last joint");
  }
  std::vector<Pose> X_RL;
  linkPoses(sub, Pose::Identity(), restingPosture(sub), X_RL);
  cut.X_RT = X_RL[tool];
  // A palm may be a bare frame on the link that carries its shape: then that link counts.
  LinkId palm = cut.hand.palm_link;
  cut.palm_extent = -std::numeric_limits<double>::infinity();
  while (sub.links[palm].collision.empty()) {
    if (cut.hand.suction) return cut;
    if (palm == LinkId(0))
      throw std::invalid_argument("the palm of arm " + a.name + " has no shapes");
    palm = sub.joints[sub.links[palm].parent_joint].parent_link;
  }
  const Pose X_TP = cut.X_RT.inverse() * X_RL[palm];
  for (const auto& p : outline(sub.links[palm])) {
    cut.palm_extent = std::max(cut.palm_extent, cut.approach_T.dot(X_TP * p));
  }
  return cut;
}

}  // namespace handover
