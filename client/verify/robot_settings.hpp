// SPDX-License-Identifier: Apache-2.0
// What a robot's yaml file says about how fast it may be run, and where its packages are.
#pragma once

#include "verify/robot.hpp"

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace handover::verify {

/// nullopt: the file says nothing.
struct JointBounds {
  std::optional<double> lower, upper, velocity, acceleration, jerk;
};

struct RobotSettings {
  std::vector<JointBounds> bounds;                        ///< by joint of the robot
  std::map<std::string, std::filesystem::path> packages;  ///< folders of package:// names
  std::vector<std::vector<int>> arms;                     ///< joints of the groups of `arms`
};

/// The packages alone, which are needed before there is a robot.
/// @throws Unreadable when the file is no YAML map.
std::map<std::string, std::filesystem::path> readPackages(const std::filesystem::path& yaml);

/// The keys velocity, acceleration, jerk hold for all joints of the place where they stand: of an
/// entry of `arms` for the joints of its SRDF `group`, of an entry of `hands` or `grippers` for the
/// joints beyond its palm or that it names, at the top for the others. Each may also be a map from
/// joint to value. `limits: {joint: {lower, upper, velocity, acceleration, jerk}}` goes before
/// them.
/// @throws Unreadable naming the file for values that are no numbers.
RobotSettings readRobotSettings(const std::filesystem::path& yaml, const Robot& robot);

}  // namespace handover::verify
