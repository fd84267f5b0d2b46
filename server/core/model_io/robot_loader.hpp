// SPDX-License-Identifier: Apache-2.0
// URDF + SRDF + our own per-robot settings -> RobotModel. Every fault is collected with file and
// line.
#pragma once

#include "core/decomposition/convex_decomposition.hpp"
#include "core/model/robot_model.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace handover {

/// [1/s] A jerk limit that is not given is this times that of the acceleration.
inline constexpr double kJerkPerAcceleration = 10;

struct ArmSettings {
  std::string name;  ///< a group of the SRDF, whose movable joints are the arm
  std::string tool_link, hand;
  Eigen::Vector3d approach_axis = Eigen::Vector3d::UnitZ();
  std::optional<Eigen::Vector3d> p_AShoulder;
  double acceleration = 1.0;   ///< [rad/s^2], each joint of the arm
  std::optional<double> jerk;  ///< [rad/s^3]
};

struct SuctionSettings {
  std::string cup_link;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit, in the cup link, towards the object
  double radius = 0;                                ///< [m]
  double engage_s = 0;
};

/// A gripper: with `suction` nothing below counts but its name.
struct HandSettings {
  std::string name, palm_link;
  std::optional<SuctionSettings> suction;
  std::vector<std::vector<std::string>>
      fingers;  ///< joint names, palm outwards, one list per finger
  std::vector<std::string> finger_links;
  std::map<std::string, double> open, closed;  ///< per joint [rad]
  double acceleration = 5.0;
  std::optional<double> jerk;
};

/// The robot's yaml file as values (read by settings/).
struct RobotSettings {
  std::string name;
  std::filesystem::path root;  ///< what relative PATHs and package:// stand on
  std::string urdf, srdf;      ///< relative to root
  std::string yaml;            ///< the settings file itself, likewise; empty: none
  std::vector<ArmSettings> arms;
  std::vector<HandSettings> hands;
  double acceleration = 1.0;   ///< [rad/s^2], joints of no arm and no hand
  std::optional<double> jerk;  ///< [rad/s^3], the same
  std::string settings_file;   ///< for messages
  /// Lines of the settings file by key path ("arms.left.tool_link"), for messages; may be empty.
  std::map<std::string, int> lines;
};

/// Loads and checks a robot; `divide` is for collision meshes that are not convex.
/// @throws FileError listing every fault found.
RobotModel loadRobot(const RobotSettings& settings, const ConvexDecomposer& divide = convexParts);

}  // namespace handover
