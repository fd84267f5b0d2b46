// SPDX-License-Identifier: Apache-2.0
// URDF -> links and joints in topological order: urdfdom's values, once our own check has found no
// fault.
#pragma once

#include "core/decomposition/convex_decomposition.hpp"
#include "core/model/robot_model.hpp"
#include "core/model_io/file_fault.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace handover {

/// The kinematic part of a RobotModel; accelerations are 0, mimic joints resolved to their masters.
struct UrdfModel {
  std::string name;
  std::vector<Link> links;
  std::vector<Joint> joints;
  std::vector<JointId> dof_joints;
  std::vector<int> limit_lines;  ///< by joint: where its <limit> stands in the file; 0: nowhere
};

/// Reads `file`. Faults (checkUrdf(), and what urdfdom refuses beyond it) are appended, called
/// `shown_file`; the model is usable only if none were. `divide` is for collision meshes that are
/// not convex.
UrdfModel readUrdf(const std::filesystem::path& file, const std::string& shown_file,
                   std::vector<FileFault>& faults, const ConvexDecomposer& divide = convexParts);

}  // namespace handover
