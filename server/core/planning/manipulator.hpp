// SPDX-License-Identifier: Apache-2.0
// One robot's arm in a request, with all that the algorithms ask of it.
#pragma once

#include "core/collision/tilt_limit.hpp"
#include "core/planning/handover_pose.hpp"
#include "core/planning/transport_problem.hpp"

#include <optional>
#include <string>
#include <vector>

namespace handover {

/// Points into the problem and its scene, which outlive it.
struct Manipulator {
  RobotId robot;  ///< of the scene
  ArmId arm;      ///< of the robot
  const SceneRobot* placed = nullptr;
  const RobotModel* model = nullptr;
  const Arm* arm_model = nullptr;
  const Hand* hand = nullptr;
  const ArmKinematics* kinematics = nullptr;
  const GraspSet* grasps = nullptr;
  PlacedMap map;                          ///< and X_WA, the arm's base in the world
  std::vector<BodyId> hand_bodies;        ///< palm and fingers
  std::vector<Eigen::Vector3d> p_OWrist;  ///< by grasp; empty where there is no closed form

  const std::string& robotName() const { return placed->name; }

  const std::string& armName() const { return arm_model->name; }

  const std::string& toolLink() const;

  ArmName name() const { return {robotName(), armName()}; }

  bool sameArm(const Manipulator& other) const { return robot == other.robot && arm == other.arm; }

  const Grasp& grasp(int index) const { return grasps->grasps[static_cast<std::size_t>(index)]; }

  /// Arm joints of a robot vector, and a robot vector with the arm's or the fingers' joints
  /// replaced.
  ArmVector armOf(const RobotVector& q) const;
  RobotVector withArm(RobotVector q, const ArmVector& q_arm) const;
  RobotVector withFingers(RobotVector q, const Eigen::VectorXd& q_fingers) const;
  Eigen::VectorXd fingersOf(const RobotVector& q) const;

  Pose worldToArm(const Pose& X_WT) const { return map.X_WA.inverse() * X_WT; }

  /// X_WT at an arm configuration.
  Pose toolPose(const ArmVector& q_arm) const { return map.X_WA * kinematics->toolPose(q_arm); }

  /// Whether the map has seen the tool about there, with about that approach direction.
  bool mapReaches(const Pose& X_WT) const;
  /// Whether any configuration at all, within limits, brings the tool there.
  bool reaches(const Pose& X_WT) const;

  /// The tool moved by `distance` [m] against its approach axis.
  Pose backedOff(const Pose& X_WT, double distance) const;
};

/// Which grasps of an object that lies somewhere an arm may have, as distances alone tell: a
/// hundredth of reaches()'s work for each. Points into the manipulator.
class MayHold {
 public:
  MayHold(const Manipulator& arm, const Pose& X_WO) : wrists_(arm.p_OWrist) {
    if (wrists_.empty()) return;
    reach_ = &*arm.kinematics->wristReach();
    p_OShoulder_ = X_WO.inverse() * (arm.map.X_WA * reach_->p_AShoulder);
  }

  /// False: no configuration at all holds it so. True where there is no closed form.
  bool operator()(int grasp) const {
    return wrists_.empty() ||
           reach_->contains(
               (wrists_[static_cast<std::size_t>(grasp)] - p_OShoulder_).squaredNorm());
  }

 private:
  const std::vector<Eigen::Vector3d>& wrists_;
  const WristReach* reach_ = nullptr;
  Eigen::Vector3d p_OShoulder_;
};

/// How long [s] the slowest joint is under way between two configurations, at its speed limit.
double travelTime(const Manipulator& manipulator, const ArmVector& from, const ArmVector& to);

/// The object's pose at a handover for the receiver's grasp, whose hand is turned from how it gives
/// the object on with X_WO_give ([paper] Alg. 3).
/// @param object_on_point  the object is on the lattice point, as the paper has it; else the tool,
/// about which it is turned back to its limit, where it has one.
Pose handoverPose(const Manipulator& giver, const Manipulator& receiver, const Grasp& grasp,
                  const Pose& X_WO_give, const Eigen::Vector3d& p_W, const ApproachOffset& offset,
                  bool object_on_point, const std::optional<TiltLimit>& tilt);

/// One arm of a scene's robot. @pre indices are valid; the arm has a hand.
Manipulator makeManipulator(const TransportProblem& problem, RobotId robot, ArmId arm);

/// Why an arm cannot take part at all: kHoldsObject, kNoGripper or kNoGrasps.
struct Unfit {
  Cause cause = Cause::kUnspecified;
  std::string object;  ///< kHoldsObject: what it holds
};

/// nullopt if it can.
std::optional<Unfit> unfitReason(const TransportProblem& problem, RobotId robot, ArmId arm);

}  // namespace handover
