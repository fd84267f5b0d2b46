// SPDX-License-Identifier: Apache-2.0
#include "small_robots.hpp"

#include <cmath>

namespace handover::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

Shape boxAt(const Eigen::Vector3d& size, const Eigen::Vector3d& p_BS) {
  Shape shape;
  shape.X_BS.translation() = p_BS;
  shape.geometry = BoxShape{size};
  return shape;
}

class Builder {
 public:
  explicit Builder(RobotModel& model) : model_(model) {}

  LinkId addLink(const std::string& name, LinkId parent, Joint joint, std::vector<Shape> shapes) {
    const LinkId link(model_.links.size());
    Link it;
    it.name = name;
    it.collision = std::move(shapes);
    if (parent.valid()) {
      joint.name = name + "_joint";
      joint.parent_link = parent;
      joint.child_link = link;
      it.parent_joint = JointId(model_.joints.size());
      if (joint.type != JointType::kFixed && !joint.mimic) {
        joint.dof = DofId(model_.dofs());
        model_.dof_joints.push_back(it.parent_joint);
      }
      model_.joints.push_back(joint);
    }
    model_.links.push_back(std::move(it));
    return link;
  }

 private:
  RobotModel& model_;
};

Joint joint(JointType type, const Eigen::Vector3d& p_PJ, const Eigen::Vector3d& axis,
            double limit) {
  Joint it;
  it.type = type;
  it.X_PJ.translation() = p_PJ;
  it.axis = axis;
  it.lower = type == JointType::kPrismatic ? 0 : -limit;
  it.upper = limit;
  it.velocity = it.acceleration = 1;
  it.jerk = 10;
  return it;
}

void addArm(RobotModel& model, const std::string& side, double turn) {
  Builder builder(model);
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ(), y = Eigen::Vector3d::UnitY();
  const Eigen::AngleAxisd R(turn, z);
  Joint shoulder = joint(JointType::kRevolute, R * Eigen::Vector3d(0.15, 0, 0), z, 2.9);
  shoulder.X_PJ.linear() = R.toRotationMatrix();
  const Shape bar = boxAt({0.3, 0.04, 0.04}, {0.15, 0, 0});
  const LinkId upper = builder.addLink(side + "_upper", LinkId(0), shoulder, {bar});
  const LinkId lower = builder.addLink(side + "_lower", upper,
                                       joint(JointType::kRevolute, {0.35, 0, 0}, z, 3.1), {bar});
  const LinkId palm =
      builder.addLink(side + "_palm", lower, joint(JointType::kFixed, {0.35, 0, 0}, z, 0),
                      {boxAt({0.06, 0.16, 0.04}, {0, 0, 0})});
  const Shape finger = boxAt({0.1, 0.02, 0.04}, {0.1, 0, 0});
  const LinkId finger_a = builder.addLink(
      side + "_finger_a", palm, joint(JointType::kPrismatic, {0, 0.02, 0}, y, 0.05), {finger});
  Joint mimic = joint(JointType::kPrismatic, {0, -0.02, 0}, -y, 0.05);
  mimic.mimic = true;
  mimic.dof = DofId(model.dofs() - 1);
  const LinkId finger_b = builder.addLink(side + "_finger_b", palm, mimic, {finger});

  Hand hand;
  hand.name = side + "_hand";
  hand.palm_link = palm;
  hand.finger_links = {finger_a, finger_b};
  hand.dofs = {mimic.dof};
  hand.fingers = {hand.dofs};
  hand.open = Eigen::VectorXd::Constant(1, 0.05);
  hand.closed = Eigen::VectorXd::Zero(1);
  hand.links = {palm, finger_a, finger_b};
  Arm arm;
  arm.name = side;
  arm.base_link = LinkId(0);
  arm.tool_link = palm;
  arm.dofs = {DofId(model.dofs() - 3), DofId(model.dofs() - 2)};
  arm.joints = {model.links[upper].parent_joint, model.links[lower].parent_joint};
  arm.hand = HandId(model.hands.size());
  model.hands.push_back(std::move(hand));
  model.arms.push_back(std::move(arm));
}

}  // namespace

std::shared_ptr<RobotModel> twoArmRobot() {
  auto model = std::make_shared<RobotModel>();
  model->name = "two_arms";
  Builder builder(*model);
  builder.addLink("base", {}, {}, {boxAt({0.2, 0.2, 0.2}, {0, 0, 0})});
  builder.addLink("head", LinkId(0),
                  joint(JointType::kFixed, {0, 0, 0.3}, Eigen::Vector3d::UnitZ(), 0),
                  {boxAt({0.1, 0.1, 0.1}, {0, 0, 0})});
  addArm(*model, "left", 0);
  addArm(*model, "right", kPi);
  return model;
}

Scene twoArmScene() {
  SceneRobot robot;
  robot.name = "two_arms";
  robot.model = twoArmRobot();
  robot.q_start = RobotVector::Zero(robot.model->dofs());
  robot.q_start[2] = robot.q_start[5] = 0.02;
  Scene scene;
  scene.cell = "test";
  scene.robots.push_back(std::move(robot));
  return scene;
}

SceneObject boxObject(const std::string& name, const Eigen::Vector3d& size,
                      const Eigen::Vector3d& p_WO) {
  SceneObject object;
  object.name = name;
  object.geometry = BoxGeometry{{size.x(), size.y(), size.z()}};
  object.shapes = {boxAt(size, Eigen::Vector3d::Zero())};
  object.X_WO.translation() = p_WO;
  return object;
}

}  // namespace handover::test
