// SPDX-License-Identifier: Apache-2.0
// Single arms as RobotModels made by hand, so that kinematics is tested without any file.
//
// Sources of the figures: LWA4 from ana-GT/commonData @ 258f6e1 robots/lwa4d (limits as corrected
// later by its author) and ipa320/schunk_modular_robotics @ b2d73bd; Hubo from commonData @ 258f6e1
// robots/hubo.
#pragma once

#include "core/model/robot_model.hpp"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace handover::test {

/// Adds links and joints one below the other.
class ArmBuilder {
 public:
  explicit ArmBuilder(const std::string& name) {
    model_.name = name;
    model_.links.push_back({.name = "base", .parent_joint = {}, .collision = {}});
  }

  ArmBuilder& fixed(const Eigen::Vector3d& xyz, const Eigen::Vector3d& rpy) {
    return add(JointType::kFixed, xyz, rpy, Eigen::Vector3d::UnitZ(), 0, 0);
  }

  ArmBuilder& revolute(const Eigen::Vector3d& xyz, const Eigen::Vector3d& rpy,
                       const Eigen::Vector3d& axis, double lower, double upper) {
    return add(JointType::kRevolute, xyz, rpy, axis, lower, upper);
  }

  ArmBuilder& prismatic(const Eigen::Vector3d& xyz, const Eigen::Vector3d& rpy,
                        const Eigen::Vector3d& axis, double lower, double upper) {
    return add(JointType::kPrismatic, xyz, rpy, axis, lower, upper);
  }

  /// One arm from the first link to the last.
  RobotModel build(const Eigen::Vector3d& approach_axis = Eigen::Vector3d::UnitZ()) {
    Arm arm;
    arm.name = "arm";
    arm.base_link = LinkId(0);
    arm.tool_link = LinkId(model_.links.size() - 1);
    arm.approach_axis = approach_axis;
    for (const DofId dof : IdRange<DofId>(model_.dofs())) {
      arm.dofs.push_back(dof);
      arm.joints.push_back(model_.dof_joints[dof]);
    }
    model_.arms.push_back(arm);
    return model_;
  }

 private:
  ArmBuilder& add(JointType type, const Eigen::Vector3d& xyz, const Eigen::Vector3d& rpy,
                  const Eigen::Vector3d& axis, double lower, double upper) {
    const int index = static_cast<int>(model_.joints.size());
    Joint joint;
    joint.name = "J" + std::to_string(index + 1);
    joint.type = type;
    joint.parent_link = LinkId(index);
    joint.child_link = LinkId(index + 1);
    joint.X_PJ.translation() = xyz;
    joint.X_PJ.linear() = rotationFromRpy(rpy.x(), rpy.y(), rpy.z());
    joint.axis = axis.normalized();
    joint.lower = lower;
    joint.upper = upper;
    joint.velocity = 1;
    joint.acceleration = 0.8;
    joint.jerk = 8;
    if (type != JointType::kFixed) {
      joint.dof = DofId(model_.dof_joints.size());
      model_.dof_joints.push_back(JointId(index));
    }
    model_.joints.push_back(joint);
    model_.links.push_back(
        {.name = "L" + std::to_string(index + 1), .parent_joint = JointId(index), .collision = {}});
    return *this;
  }

  RobotModel model_;
};

/// Schunk LWA 4D with the SDH's grasp point. `half_pi`, `pi`: as the file writes them (the
/// author: 1.57, 3.1416). `turn`: limit of the joints 1, 3, 5, 7 (the paper's files: 2 pi).
inline RobotModel lwa4Arm(double half_pi = M_PI / 2, double pi = M_PI, double turn = 3.1416) {
  const Eigen::Vector3d z(0, 0, 1), back(0, 0, -1);
  return ArmBuilder("lwa4")
      .revolute({0, 0.12, 0}, {half_pi, pi, 0}, z, -turn, turn)
      .revolute({0, 0, -0.18}, {-half_pi, 0, 0}, back, -1.97, 1.97)
      .revolute({0, 0, 0}, {half_pi, 0, 0}, z, -turn, turn)
      .revolute({0, 0, -0.328}, {-half_pi, 0, 0}, back, -2.08, 2.08)
      .revolute({0, 0, 0}, {half_pi, 0, 0}, z, -turn, turn)
      .revolute({0, 0, -0.323}, {half_pi, 0, 0}, back, -1.80, 1.80)
      .revolute({0, -0.075, 0}, {-half_pi, 0, 0}, back, -turn, turn)
      .fixed({0, 0, 0}, {0, pi, 0})
      .fixed({0, 0, 0.15}, {0, 0, 0})
      .build();
}

/// The same arm by another maker of files: straight up at q = 0, axes all z.
inline RobotModel lwa4UprightArm() {
  const Eigen::Vector3d z(0, 0, 1), out(-M_PI / 2, -M_PI / 2, 0), back(M_PI / 2, 0, M_PI / 2);
  return ArmBuilder("lwa4_upright")
      .revolute({0, 0, 0}, {0, 0, 0}, z, -3.12159, 3.12159)
      .revolute({0, 0, 0.24}, out, z, -2.12, 2.12)
      .revolute({0, 0, 0}, back, z, -3.12159, 3.12159)
      .revolute({0, 0, 0.328}, out, z, -2.16, 2.16)
      .revolute({0, 0, 0}, back, z, -3.12159, 3.12159)
      .revolute({0, 0, 0.323}, out, z, -2.07, 2.07)
      .revolute({0, 0, 0}, back, z, -2.94, 2.94)
      .fixed({0, 0, 0.0824}, {0, 0, 0})
      .build();
}

/// DRC-Hubo's left arm (side = 1) or right arm (side = -1) with the point between its fingers as
/// tool.
inline RobotModel huboArm(int side = 1) {
  const double s = side;
  const auto limits = [&](double lower, double upper) {
    return side > 0 ? std::pair(lower, upper) : std::pair(-upper, -lower);
  };
  const auto [sr0, sr1] = limits(-0.262, 3.14);
  const auto [sy0, sy1] = limits(-2, 3.14);
  const auto [wr0, wr1] = limits(-3.14, 2.6);
  const Eigen::Vector3d x(1, 0, 0), y(0, 1, 0), z(0, 0, 1), none(0, 0, 0);
  return ArmBuilder(side > 0 ? "hubo_left" : "hubo_right")
      .revolute({0.001, s * 0.1305, 0.2061}, none, y, -3.14, 3.14)
      .revolute({0.033, s * 0.099, 0}, none, x, sr0, sr1)
      .revolute({-0.033, 0, -0.027}, none, z, sy0, sy1)
      .revolute({0.03, 0, -0.273}, none, y, -2.65, 0.2)
      .revolute({-0.03, 0, -0.052}, none, z, -3.14, 3.14)
      .revolute({0, 0, -0.2618}, none, y, -1.571, 1.571)
      .revolute({0, 0, -0.0275}, {0, 0, s * 1.5708}, z, wr0, wr1)
      .fixed({0, 0, -0.13}, none)
      .build({0, 0, -1});
}

/// Spherical shoulder and wrist with no two axes square to each other, elbow beside both lines.
inline RobotModel skewSrsArm() {
  const Eigen::Vector3d none(0, 0, 0);
  return ArmBuilder("skew")
      .revolute({0.1, -0.05, 0.3}, {0.2, -0.4, 1.1}, {0, 0, 1}, -3, 3)
      .revolute({0, 0, 0}, {0.3, 0.1, -0.2}, {0.2, 1, 0.15}, -2.9, 2.9)
      .revolute({0, 0, 0}, {0.1, 0, 0.5}, {1, -0.1, 0.3}, -3, 3)
      .revolute({0.33, 0.04, -0.02}, {0, 0.2, 0}, {0.1, 0.2, 1}, -2.5, 2.5)
      .revolute({0.28, -0.03, 0.05}, {0.4, 0, 0.3}, {1, 0.2, 0}, -3.1, 3.1)
      .revolute({0, 0, 0}, none, {0, 0.9, 0.3}, -2.2, 2.2)
      .revolute({0, 0, 0}, {0, 0.1, 0}, {1, 0, -0.2}, -3.1, 3.1)
      .fixed({0.12, 0.01, 0.02}, {0.5, -0.3, 0.2})
      .build();
}

/// Six revolute joints, parallel second to fourth axes, no spherical wrist: no closed form of ours.
inline RobotModel sixAxisArm() {
  const Eigen::Vector3d y(0, 1, 0), z(0, 0, 1), none(0, 0, 0);
  return ArmBuilder("six")
      .revolute({0, 0, 0.0892}, none, z, -3.1, 3.1)
      .revolute({0, 0.1358, 0}, {0, M_PI / 2, 0}, y, -3.1, 3.1)
      .revolute({0, -0.1197, 0.425}, none, y, -2.9, 2.9)
      .revolute({0, 0, 0.3923}, {0, M_PI / 2, 0}, y, -3.1, 3.1)
      .revolute({0, 0.093, 0}, none, z, -3.1, 3.1)
      .revolute({0, 0, 0.0946}, none, y, -3.1, 3.1)
      .fixed({0, 0.0823, 0}, {0, 0, M_PI / 2})
      .build();
}

/// UR5e with the point between the fingers of a gripper as tool, joints of two turns but the elbow
/// (tests/support/robots has the whole robot and its sources).
inline RobotModel ur5eArm() {
  constexpr double kTurn = 2 * M_PI;
  const Eigen::Vector3d z(0, 0, 1), none(0, 0, 0), up(M_PI / 2, 0, 0), down(-M_PI / 2, 0, 0);
  return ArmBuilder("ur5e")
      .revolute(none, none, z, -kTurn, kTurn)
      .revolute({0, 0, 0.1625}, up, z, -kTurn, kTurn)
      .revolute({-0.425, 0, 0}, none, z, -M_PI, M_PI)
      .revolute({-0.3922, 0, 0}, none, z, -kTurn, kTurn)
      .revolute({0, 0, 0.1333}, up, z, -kTurn, kTurn)
      .revolute({0, 0, 0.0997}, down, z, -kTurn, kTurn)
      .fixed({0, 0, 0.0996 + 0.095}, none)
      .build();
}

/// iiwa 14 R820 with the point between the fingers of a gripper as tool.
inline RobotModel iiwa14Arm() {
  const Eigen::Vector3d z(0, 0, 1), none(0, 0, 0), up(M_PI / 2, 0, 0), down(-M_PI / 2, 0, 0);
  const double wide = 170 * M_PI / 180, narrow = 120 * M_PI / 180, last = 175 * M_PI / 180;
  return ArmBuilder("iiwa14")
      .revolute(none, none, z, -wide, wide)
      .revolute({0, 0, 0.36}, down, z, -narrow, narrow)
      .revolute(none, up, z, -wide, wide)
      .revolute({0, 0, 0.42}, up, z, -narrow, narrow)
      .revolute(none, down, z, -wide, wide)
      .revolute({0, 0, 0.4}, down, z, -narrow, narrow)
      .revolute(none, up, z, -last, last)
      .fixed({0, 0, 0.126 + 0.11}, none)
      .build();
}

/// Panda: seven joints, but an elbow whose axis lies beside both links and a wrist whose axes do
/// not meet.
inline RobotModel pandaArm() {
  const Eigen::Vector3d z(0, 0, 1), none(0, 0, 0), up(M_PI / 2, 0, 0), down(-M_PI / 2, 0, 0);
  return ArmBuilder("panda")
      .revolute({0, 0, 0.333}, none, z, -2.8973, 2.8973)
      .revolute(none, down, z, -1.7628, 1.7628)
      .revolute({0, -0.316, 0}, up, z, -2.8973, 2.8973)
      .revolute({0.0825, 0, 0}, up, z, -3.0718, -0.0698)
      .revolute({-0.0825, 0.384, 0}, down, z, -2.8973, 2.8973)
      .revolute(none, up, z, -0.0175, 3.7525)
      .revolute({0.088, 0, 0}, up, z, -2.8973, 2.8973)
      .fixed({0, 0, 0.107 + 0.095}, none)
      .build();
}

/// A sliding base under six turning joints, seven in all.
inline RobotModel slidingArm() {
  const Eigen::Vector3d x(1, 0, 0), y(0, 1, 0), z(0, 0, 1), none(0, 0, 0);
  return ArmBuilder("sliding")
      .prismatic({0, 0, 0.1}, none, x, -0.4, 0.6)
      .revolute({0, 0, 0.3}, none, z, -2.9, 2.9)
      .revolute({0.02, 0, 0.1}, none, y, -2, 2)
      .revolute({0, 0, 0.35}, none, y, -2.4, 2.4)
      .revolute({0, 0, 0.3}, none, z, -3, 3)
      .revolute({0, 0, 0.05}, none, y, -2, 2)
      .revolute({0, 0, 0.08}, none, z, -3, 3)
      .build();
}

/// Two links in the x-y plane, 0.3 and 0.2 m.
inline RobotModel planarArm() {
  const Eigen::Vector3d z(0, 0, 1), none(0, 0, 0);
  return ArmBuilder("planar")
      .revolute({0, 0, 0}, none, z, -3, 3)
      .revolute({0.3, 0, 0}, none, z, -2.5, 2.5)
      .fixed({0.2, 0, 0}, none)
      .build();
}

}  // namespace handover::test
