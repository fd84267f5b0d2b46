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

/// Adds a link at the end of a joint and returns its index.
int addLink(RobotModel& model, int parent, Joint joint, const std::string& name,
            std::vector<Shape> shapes) {
  Link link;
  link.name = name;
  link.collision = std::move(shapes);
  link.parent_joint = static_cast<int>(model.joints.size());
  joint.name = name + "_joint";
  joint.parent_link = parent;
  joint.child_link = static_cast<int>(model.links.size());
  joint.velocity = 1;
  joint.acceleration = 1;
  if (joint.type != JointType::kFixed && !joint.mimic) {
    joint.dof = model.dofs();
    model.dof_joints.push_back(static_cast<int>(model.joints.size()));
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
RobotModel palmOnly(const std::string& name, int& palm) {
  RobotModel model;
  model.name = name;
  model.links.push_back({"base", -1, {boxAt({0, 0, -0.05}, {0.1, 0.1, 0.1})}});
  const Joint wrist_joint = movingAt(JointType::kRevolute, {0, 0, 0.01}, Vector3d::UnitZ(), -3, 3);
  const int wrist =
      addLink(model, 0, wrist_joint, "wrist", {boxAt({0, 0, 0.02}, {0.04, 0.04, 0.05})});
  palm = addLink(model, wrist, fixedAt({0, 0, 0.05}), "palm",
                 {boxAt({0, 0, 0.015}, {0.12, 0.06, 0.03})});
  const int tool = addLink(model, palm, fixedAt({0, 0, 0.08}), "tool", {});
  Arm arm;
  arm.name = "arm";
  arm.base_link = 0;
  arm.tool_link = tool;
  arm.dofs = {0};
  arm.joints = {0};
  arm.hand = 0;
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
  int palm = -1;
  RobotModel model = palmOnly("gripper", palm);
  Hand& hand = model.hands[0];
  for (const double side : {1.0, -1.0}) {
    // At 0 the finger's inner face is at x = 0; it opens outwards.
    const Joint slide =
        movingAt(JointType::kPrismatic, {0, 0, 0.031}, Vector3d(side, 0, 0), 0, 0.055);
    const int finger = addLink(model, palm, slide, side > 0 ? "left" : "right",
                               {boxAt({side * 0.005, 0, 0.03}, {0.01, 0.02, 0.06})});
    hand.finger_links.push_back(finger);
    hand.links.push_back(finger);
    hand.dofs.push_back(model.dofs() - 1);
    hand.fingers.push_back({model.dofs() - 1});
  }
  hand.open = Eigen::Vector2d(0.055, 0.055);
  hand.closed = Eigen::Vector2d(0, 0);
  return model;
}

RobotModel curlingHand() {
  int palm = -1;
  RobotModel model = palmOnly("curler", palm);
  Hand& hand = model.hands[0];
  int first_tip = -1;
  for (const double side : {1.0, -1.0}) {
    const std::string name = side > 0 ? "left" : "right";
    // Positive angles bend towards the palm's axis.
    const Vector3d axis(0, -side, 0);
    const Joint root = movingAt(JointType::kRevolute, {side * 0.05, 0, 0.04}, axis, -1, 1.5);
    const int finger =
        addLink(model, palm, root, name + "_1", {boxAt({0, 0, 0.04}, {0.015, 0.02, 0.07})});
    hand.dofs.push_back(model.dofs() - 1);
    hand.fingers.push_back({model.dofs() - 1});
    Joint tip = movingAt(JointType::kRevolute, {0, 0, 0.08}, axis, 0, 1.5);
    if (side < 0) {
      tip.mimic = true;
      tip.dof = first_tip;
    }
    const int end =
        addLink(model, finger, tip, name + "_2", {boxAt({0, 0, 0.03}, {0.012, 0.018, 0.055})});
    if (side > 0) {
      first_tip = model.dofs() - 1;
      hand.dofs.push_back(first_tip);
      hand.fingers[0].push_back(first_tip);
    }
    for (const int link : {finger, end}) {
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
  model.links.push_back({"base", -1, {boxAt({0, 0, -0.05}, {0.1, 0.1, 0.1})}});
  const Joint wrist_joint = movingAt(JointType::kRevolute, {0, 0, 0.01}, Vector3d::UnitZ(), -3, 3);
  const int wrist =
      addLink(model, 0, wrist_joint, "wrist", {boxAt({0, 0, 0.025}, {0.06, 0.06, 0.05})});
  Shape lip;
  lip.geometry = CylinderShape{radius, 0.03};
  lip.X_BS.translation().z() = 0.015;
  const int cup = addLink(model, wrist, fixedAt({0, 0, 0.05}), "cup", {lip});
  const int tool = addLink(model, cup, fixedAt({0, 0, 0.03}), "tool", {});
  Arm arm;
  arm.name = "arm";
  arm.base_link = 0;
  arm.tool_link = tool;
  arm.dofs = {0};
  arm.joints = {0};
  arm.hand = 0;
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
