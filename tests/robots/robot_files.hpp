// SPDX-License-Identifier: Apache-2.0
// The robots as committed, and the tables they are compared with.
#pragma once

#include "core/model/robot_model.hpp"

#include <filesystem>
#include <random>
#include <string>
#include <vector>

namespace handover::testing {

/// robots/ of the source tree.
std::filesystem::path robotsFolder();

/// A robot's URDF and SRDF through our loader, without arms and hands.
RobotModel loadBody(const std::string& name);

/// Uniform within the limits.
RobotVector randomPosture(const RobotModel& model, std::mt19937_64& generator);

/// A line of a table as words; comments and empty lines left out.
std::vector<std::vector<std::string>> readTable(const std::filesystem::path& file);

/// Angle of a rotation [rad], exact for small ones too.
double angleOf(const Eigen::Matrix3d& R);

}  // namespace handover::testing
