// SPDX-License-Identifier: Apache-2.0
// The robots and things of this repository, as the grasp tests need them.
#pragma once

#include "core/model_io/mesh_reader.hpp"
#include "core/model_io/robot_loader.hpp"
#include "settings/cell_file.hpp"
#include "test_hands.hpp"

#include <string>

namespace handover {

inline RobotModel loadRobotNamed(const std::string& name) {
  const std::filesystem::path root(HANDOVER_SOURCE_DIR);
  return loadRobot(readRobotSettings(root / "robots" / name / (name + ".yaml"), root));
}

/// "jar" is the kneeling scene's cylinder, the others are meshes of robots/objects.
inline SceneObject loadObjectNamed(const std::string& name) {
  if (name == "jar") return cylinderObject(0.05, 0.18);
  const std::filesystem::path folder =
      std::filesystem::path(HANDOVER_SOURCE_DIR) / "robots/objects" / name;
  return objectOf(name, readConvexMesh(folder / (name + ".obj"), {1, 1, 1}));
}

struct RobotHand {
  const char* robot;
  const char* arm;
};

}  // namespace handover
