// SPDX-License-Identifier: Apache-2.0
#include "test_hands.hpp"

#include <cmath>

namespace handover {
namespace {

using Eigen::Vector3d;

Shape boxAt(const Vector3d& p, const Vector3d& size) {
  Shape shape;
  shape.X_BS.translation() = p;
  shape.geometry = BoxShape{size};
  return shape;
}

/// Adds a link at the end of a joint.
LinkId addLink(RobotModel& model, LinkId parent, Joint joint, const std::string& name,
               std::vector<Shape> shapes) {
  Link link;
  link.name = name;
  link.collision = std::move(shapes);
  link.parent_joint = JointId(model.joints.size());
  joint.name = name + "_joint";
  joint.parent_link = parent;
  joint.child_link = LinkId(model.links.size());
  joint.velocity = 1;
  joint.acceleration = 1;
  if (joint.type != JointType::kFixed && !joint.mimic) {
    joint.dof = DofId(model.dofs());
    model.dof_joints.push_back(JointId(model.joints.size()));
  }
  model.links.push_back(link);
  model.joints.push_back(joint);
  return joint.child_link;
}

Joint fixedAt(const Vector3d& p) {
  Joint joint;
  joint.X_PJ.translation() = p;
  return joint;
}

Joint movingAt(JointType type, const Vector3d& p, const Vector3d& axis, double lower,
               double upper) {
  Joint joint = fixedAt(p);
  joint.type = type;
  joint.axis = axis;
  joint.lower = lower;
  joint.upper = upper;
  return joint;
}

/// Base, wrist joint about z, palm of 120 x 60 x 30 mm whose top is at z = 80 mm of the wrist,
/// tool.
RobotModel palmOnly(const std::string& name, LinkId& palm) {
  RobotModel model;
  model.name = name;
  model.links.push_back({"base", {}, {boxAt({0, 0, -0.05}, {0.1, 0.1, 0.1})}});
  const Joint wrist_joint = movingAt(JointType::kRevolute, {0, 0, 0.01}, Vector3d::UnitZ(), -3, 3);
  const LinkId wrist =
      addLink(model, LinkId(0), wrist_joint, "wrist", {boxAt({0, 0, 0.02}, {0.04, 0.04, 0.05})});
  palm = addLink(model, wrist, fixedAt({0, 0, 0.05}), "palm",
                 {boxAt({0, 0, 0.015}, {0.12, 0.06, 0.03})});
  const LinkId tool = addLink(model, palm, fixedAt({0, 0, 0.08}), "tool", {});
  Arm arm;
  arm.name = "arm";
  arm.base_link = LinkId(0);
  arm.tool_link = tool;
  arm.dofs = {DofId(0)};
  arm.joints = {JointId(0)};
  arm.hand = HandId(0);
  model.arms.push_back(arm);
  Hand hand;
  hand.name = "hand";
  hand.palm_link = palm;
  hand.links = {palm, tool};
  model.hands.push_back(hand);
  return model;
}

}  // namespace

RobotModel parallelGripper() {
  LinkId palm;
  RobotModel model = palmOnly("gripper", palm);
  Hand& hand = model.hands[0];
  for (const double side : {1.0, -1.0}) {
    // At 0 the finger's inner face is at x = 0; it opens outwards.
    const Joint slide =
        movingAt(JointType::kPrismatic, {0, 0, 0.031}, Vector3d(side, 0, 0), 0, 0.055);
    const LinkId finger = addLink(model, palm, slide, side > 0 ? "left" : "right",
                                  {boxAt({side * 0.005, 0, 0.03}, {0.01, 0.02, 0.06})});
    hand.finger_links.push_back(finger);
    hand.links.push_back(finger);
    hand.dofs.push_back(DofId(model.dofs() - 1));
    hand.fingers.push_back({DofId(model.dofs() - 1)});
  }
  hand.open = Eigen::Vector2d(0.055, 0.055);
  hand.closed = Eigen::Vector2d(0, 0);
  return model;
}

RobotModel curlingHand() {
  LinkId palm;
  RobotModel model = palmOnly("curler", palm);
  Hand& hand = model.hands[0];
  DofId first_tip;
  for (const double side : {1.0, -1.0}) {
    const std::string name = side > 0 ? "left" : "right";
    // Positive angles bend towards the palm's axis.
    const Vector3d axis(0, -side, 0);
    const Joint root = movingAt(JointType::kRevolute, {side * 0.05, 0, 0.04}, axis, -1, 1.5);
    const LinkId finger =
        addLink(model, palm, root, name + "_1", {boxAt({0, 0, 0.04}, {0.015, 0.02, 0.07})});
    hand.dofs.push_back(DofId(model.dofs() - 1));
    hand.fingers.push_back({DofId(model.dofs() - 1)});
    Joint tip = movingAt(JointType::kRevolute, {0, 0, 0.08}, axis, 0, 1.5);
    if (side < 0) {
      tip.mimic = true;
      tip.dof = first_tip;
    }
    const LinkId end =
        addLink(model, finger, tip, name + "_2", {boxAt({0, 0, 0.03}, {0.012, 0.018, 0.055})});
    if (side > 0) {
      first_tip = DofId(model.dofs() - 1);
      hand.dofs.push_back(first_tip);
      hand.fingers[0].push_back(first_tip);
    }
    for (const LinkId link : {finger, end}) {
      hand.finger_links.push_back(link);
      hand.links.push_back(link);
    }
  }
  hand.open = Eigen::Vector3d(-0.8, 0.1, -0.8);
  hand.closed = Eigen::Vector3d(1.2, 1.4, 1.2);
  return model;
}

RobotModel suctionGripper(double radius) {
  RobotModel model;
  model.name = "sucker";
  model.links.push_back({"base", {}, {boxAt({0, 0, -0.05}, {0.1, 0.1, 0.1})}});
  const Joint wrist_joint = movingAt(JointType::kRevolute, {0, 0, 0.01}, Vector3d::UnitZ(), -3, 3);
  const LinkId wrist =
      addLink(model, LinkId(0), wrist_joint, "wrist", {boxAt({0, 0, 0.025}, {0.06, 0.06, 0.05})});
  Shape lip;
  lip.geometry = CylinderShape{radius, 0.03};
  lip.X_BS.translation().z() = 0.015;
  const LinkId cup = addLink(model, wrist, fixedAt({0, 0, 0.05}), "cup", {lip});
  const LinkId tool = addLink(model, cup, fixedAt({0, 0, 0.03}), "tool", {});
  Arm arm;
  arm.name = "arm";
  arm.base_link = LinkId(0);
  arm.tool_link = tool;
  arm.dofs = {DofId(0)};
  arm.joints = {JointId(0)};
  arm.hand = HandId(0);
  model.arms.push_back(arm);
  Hand hand;
  hand.name = "cup";
  hand.palm_link = cup;
  hand.links = {cup};
  hand.suction = Suction{cup, Vector3d::UnitZ(), radius, 0.3};
  model.hands.push_back(hand);
  return model;
}

SceneObject objectOf(const std::string& name, std::vector<Shape> shapes) {
  SceneObject object;
  object.name = name;
  object.shapes = std::move(shapes);
  return object;
}

SceneObject boxObject(const Vector3d& size) {
  return objectOf("box", {boxAt(Vector3d::Zero(), size)});
}

SceneObject sphereObject(double radius) {
  Shape shape;
  shape.geometry = SphereShape{radius};
  return objectOf("sphere", {shape});
}

SceneObject cylinderObject(double radius, double length) {
  Shape shape;
  shape.geometry = CylinderShape{radius, length};
  return objectOf("cylinder", {shape});
}

}  // namespace handover
