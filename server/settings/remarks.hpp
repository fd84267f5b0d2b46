// SPDX-License-Identifier: Apache-2.0
// What is to be said of a cell besides its faults: what it is made of, and what looks like a slip.
#pragma once

#include "core/model/scene.hpp"
#include "settings/yaml_reader.hpp"

#include <string>
#include <vector>

namespace handover {

/// By the paths of a cell file.
struct Remarks {
  YamlReport warnings;  ///< open surfaces, sizes and limits that look like another unit
  YamlReport facts;     ///< sizes, convex parts, volumes
};

/// Of one object, under a path: its size, its convex parts, whether its surface is closed.
void remarkOnShapes(const SceneObject& object, const std::string& path, Remarks& remarks);

/// Of every object: its size, its convex parts, whether its surface is closed; of those that the
/// tasks move, whether their size fits the hands.
void remarkOnObjects(const Scene& scene, const std::vector<SceneTask>& tasks, Remarks& remarks);

/// Of a robot: its size as it starts, its parts, limits that look like degrees.
void remarkOnRobot(const RobotModel& model, const RobotVector& q_start, const std::string& path,
                   Remarks& remarks);

}  // namespace handover
