// SPDX-License-Identifier: Apache-2.0
// URDF -> links and joints in topological order, every fault with its line. A reader of our own
// rather than urdfdom's: that one stops at the first fault, names no line and takes zero axes,
// lower > upper, unknown mimic masters and negative sizes. The tests hold the two against each
// other.
#pragma once

#include "core/model/robot_loader.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace handover {

/// The kinematic part of a RobotModel; accelerations are 0, mimic joints resolved to their masters.
struct UrdfModel {
  std::string name;
  std::vector<Link> links;
  std::vector<Joint> joints;
  std::vector<int> dof_joints;
};

/// Reads `file`; collision meshes by `package://` or relative path stand on the URDF's folder.
/// Faults are appended, called `shown_file`; the model is usable only if none were.
UrdfModel readUrdf(const std::filesystem::path& file, const std::string& shown_file,
                   std::vector<FileFault>& faults);

}  // namespace handover
