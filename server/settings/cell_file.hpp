// SPDX-License-Identifier: Apache-2.0
// Cell files: YAML -> Scene and tasks, with the overrides of one request applied by the same reader.
#pragma once

#include "core/model/robot_loader.hpp"
#include "core/model/scene.hpp"

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace handover {

/// Models already loaded, by name: cells share them.
using ModelCache = std::map<std::string, std::shared_ptr<const RobotModel>>;

/// Reads robots/<name>/<name>.yaml under `root`. @throws FileError with every fault.
RobotSettings readRobotSettings(const std::filesystem::path& file, const std::filesystem::path& root);

/// A loaded cell file. Immutable; safe from any thread.
class Cell {
 public:
  /// What a cell is at one moment: the scene and its tasks, goals resolved into the world.
  struct Instance {
    std::shared_ptr<const Scene> scene;
    std::vector<SceneTask> tasks;               ///< in the file's order
  };

  /// @throws FileError with every fault of the cell and of the robot files it names.
  static Cell load(const std::filesystem::path& file, const std::filesystem::path& root,
                   ModelCache& models);

  const std::string& name() const;
  std::vector<std::string> taskNames() const;

  /// The cell with overrides applied; or every fault, `field` = the override's path. Arm postures given
  /// by tool pose are solved by IK, the same way every time; unreachable ones are faults naming the arm.
  std::variant<Instance, std::vector<Fault>> instantiate(const std::vector<Override>& overrides,
                                                         std::uint64_t revision) const;

 private:
  struct Data;
  std::shared_ptr<const Data> data_;
};

}  // namespace handover
