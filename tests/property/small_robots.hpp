// SPDX-License-Identifier: Apache-2.0
// Robots of a few boxes whose inverse kinematics is known by hand, as files that planner and
// verifier read: a planar arm, the same on a slide, a gantry with a wrist, a seven-axis arm. Each
// holds a gripper of two fingers that close along the tool's y, approach along its x.
#pragma once

#include "core/kinematics/arm_kinematics.hpp"
#include "core/reachability/reachability_map.hpp"
#include "support/temporary_folder.hpp"

#include <memory>
#include <vector>

namespace handover::test {

enum class RobotKind { kPlanar, kSlidingPlanar, kGantry, kSevenAxes };
inline constexpr int kRobotKinds = 4;

/// Figures of the gripper [m]; the tool link lies between the fingers, its x away from the palm.
struct Gripper {
  static constexpr double kPalmToTool = 0.04;
  static constexpr double kFingerBeyondTool = 0.02;
  static constexpr double kWidestOpening = 0.045;  ///< of each finger from the middle
};

struct SmallRobot {
  RobotKind kind = RobotKind::kPlanar;
  std::vector<double> lengths;  ///< [m]; planar: upper arm, forearm, wrist to tool
  std::shared_ptr<const RobotModel> model;
  std::shared_ptr<const ArmKinematics> kinematics;
  std::shared_ptr<const ReachabilityMap> map;

  /// All configurations within limits that put the tool at X_BT, seen from the root link; by hand
  /// for all kinds but the seven-axis arm, where our closed form is asked at `steps` swivel angles.
  /// A slide is tried at `steps` places.
  std::vector<ArmVector> configurations(const Pose& X_BT, int steps) const;
};

/// A few robots of each kind, made once, in a folder that the scenes' paths are relative to.
class SmallRobots {
 public:
  static constexpr int kPerKind = 2;

  SmallRobots();

  const SmallRobot& get(RobotKind kind, int which) const;

  const std::filesystem::path& root() const { return folder_.path(); }

 private:
  SmallRobot make(RobotKind kind, int which) const;

  TemporaryFolder folder_;
  std::vector<SmallRobot> robots_;
};

}  // namespace handover::test
