// SPDX-License-Identifier: Apache-2.0
// Every fault of a URDF with its line. It comes before urdfdom, which stops at the first fault,
// names no line and takes zero axes, lower > upper, unknown mimic masters and negative sizes.
#pragma once

#include "core/decomposition/convex_decomposition.hpp"
#include "core/model/body_shapes.hpp"
#include "core/model_io/file_fault.hpp"

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace handover {

/// A link and the joint above it.
struct UrdfNode {
  std::string link, joint;  ///< no joint above the root
  int parent = -1;          ///< node of the link above
  int mimic_line = 0;       ///< of the joint's <mimic>
  int limit_line = 0;       ///< of the joint's <limit>
};

/// What was found on the way, for those who read the values.
struct CheckedUrdf {
  std::string text;             ///< the document written out again, as it was understood
  std::vector<UrdfNode> nodes;  ///< the root, then depth first in the order of the written joints
  /// Collision meshes by file name and scale, as written.
  std::map<std::pair<std::string, std::array<double, 3>>, BodyShapes> meshes;
};

/// Collision meshes by `package://` or relative path stand on the URDF's folder. Faults are
/// appended, called `shown_file`; the result is usable only if none were.
CheckedUrdf checkUrdf(const std::filesystem::path& file, const std::string& shown_file,
                      std::vector<FileFault>& faults, const ConvexDecomposer& divide);

}  // namespace handover
