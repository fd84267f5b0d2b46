// SPDX-License-Identifier: Apache-2.0
// Robots of a joint or two, each link one simple shape: where they touch can be written down.
#pragma once

#include "core/collision/joint_motion.hpp"
#include "core/model/scene.hpp"

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace handover::test {

/// A straight segment that keeps its ends.
class Straight : public JointMotion {
 public:
  Straight(Eigen::VectorXd from, Eigen::VectorXd to) : from_(std::move(from)), to_(std::move(to)) {}

  /// Of one joint.
  Straight(double from, double to)
      : Straight(Eigen::VectorXd::Constant(1, from), Eigen::VectorXd::Constant(1, to)) {}

  Eigen::Index joints() const override { return from_.size(); }

  void fill(double from, double to, MotionIntervalRef out) const override {
    SegmentMotion(from_, to_).fill(from, to, out);
  }

 private:
  Eigen::VectorXd from_, to_;
};

/// A joint and the shapes of the link behind it.
struct JointedBody {
  JointType type = JointType::kRevolute;
  Eigen::Vector3d p_PJ = Eigen::Vector3d::Zero();  ///< of the joint in the link before it
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  std::vector<Shape> shapes;  ///< in the joint's frame
};

/// A chain of links: "base", without shapes, then "link1", "link2", ...; q = 0 at the start.
inline SceneRobot chainOf(const std::string& name, const std::vector<JointedBody>& bodies,
                          const Eigen::Vector3d& p_WB = Eigen::Vector3d::Zero()) {
  auto model = std::make_shared<RobotModel>();
  model->name = name;
  model->links.push_back({"base", {}, {}});
  for (const JointedBody& body : bodies) {
    Joint joint;
    joint.type = body.type;
    joint.parent_link = LinkId(model->links.size() - 1);
    joint.child_link = LinkId(model->links.size());
    joint.X_PJ.translation() = body.p_PJ;
    joint.axis = body.axis;
    joint.lower = -4;
    joint.upper = 4;
    joint.velocity = joint.acceleration = 1;
    joint.dof = DofId(model->dofs());
    joint.name = "joint" + std::to_string(joint.child_link.value());
    model->dof_joints.push_back(JointId(model->joints.size()));
    model->links.push_back({"link" + std::to_string(joint.child_link.value()),
                            JointId(model->joints.size()), body.shapes});
    model->joints.push_back(joint);
  }
  SceneRobot robot;
  robot.name = name;
  robot.q_start = RobotVector::Zero(model->dofs());
  robot.model = std::move(model);
  robot.X_WB.translation() = p_WB;
  return robot;
}

inline Shape sphereAt(double radius, const Eigen::Vector3d& p_LS) {
  Shape shape;
  shape.X_BS.translation() = p_LS;
  shape.geometry = SphereShape{radius};
  return shape;
}

inline Shape boxAt(const Eigen::Vector3d& size, const Eigen::Vector3d& p_LS) {
  Shape shape;
  shape.X_BS.translation() = p_LS;
  shape.geometry = BoxShape{size};
  return shape;
}

/// An object of one shape, at p_WO turned about z [rad].
inline SceneObject objectOf(const std::string& name, const Shape& shape,
                            const Eigen::Vector3d& p_WO, double turn = 0) {
  SceneObject object;
  object.name = name;
  object.shapes = {shape};
  object.X_WO.translation() = p_WO;
  object.X_WO.linear() = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return object;
}

}  // namespace handover::test
