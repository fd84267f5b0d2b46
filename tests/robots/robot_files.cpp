// SPDX-License-Identifier: Apache-2.0
#include "robot_files.hpp"

#include "core/model_io/robot_loader.hpp"

#include <Eigen/Geometry>

#include <cmath>
#include <fstream>
#include <sstream>

namespace handover::testing {

std::filesystem::path robotsFolder() {
  return std::filesystem::path(HANDOVER_SOURCE_DIR) / "robots";
}

RobotModel loadBody(const std::string& name) {
  RobotSettings settings;
  settings.name = name;
  settings.root = robotsFolder() / name;
  settings.urdf = name + ".urdf";
  settings.srdf = name + ".srdf";
  return loadRobot(settings);
}

RobotVector randomPosture(const RobotModel& model, std::mt19937_64& generator) {
  RobotVector q(model.dofs());
  for (int dof = 0; dof < model.dofs(); ++dof) {
    const Joint& joint = model.joints[model.dof_joints[dof]];
    q[dof] = std::uniform_real_distribution<double>(joint.lower, joint.upper)(generator);
  }
  return q;
}

std::vector<std::vector<std::string>> readTable(const std::filesystem::path& file) {
  std::vector<std::vector<std::string>> rows;
  std::ifstream in(file);
  if (!in) throw std::runtime_error("cannot read " + file.string());
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::vector<std::string> row;
    for (std::string word; words >> word;) row.push_back(word);
    if (!row.empty() && row[0] != "#") rows.push_back(std::move(row));
  }
  return rows;
}

double angleOf(const Eigen::Matrix3d& R) {
  return 2 * std::asin(std::min(1.0, (R - Eigen::Matrix3d::Identity()).norm() / std::sqrt(8.0)));
}

}  // namespace handover::testing
