// SPDX-License-Identifier: Apache-2.0
// A cell's description with every name looked up and every pose brought into the world.
#pragma once

#include "settings/cell_description.hpp"

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace handover {

/// Shapes made before, with the geometry that they come from.
struct KnownShapes {
  Geometry geometry;
  std::vector<Shape> shapes;
  std::shared_ptr<const DividedBodies> divided;
};

struct ResolvedCell {
  Scene scene;
  std::vector<SceneTask> tasks;
};

/// `models` by name, as loaded with the cell; `known` shapes by object name spare reading meshes
/// again, and `divide` takes those that are not convex. Faults go to `report` by path; the result
/// is usable only if there were none.
ResolvedCell resolveCell(const CellDescription& cell, const ModelCache& models,
                         const std::filesystem::path& root, const ConvexDecomposer& divide,
                         const std::map<std::string, KnownShapes>& known, YamlReport& report);

}  // namespace handover
