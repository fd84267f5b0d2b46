// SPDX-License-Identifier: Apache-2.0
// Cell files: YAML -> Scene and tasks, with the overrides of one request applied by the same
// reader.
#pragma once

#include "core/model/scene.hpp"
#include "core/model_io/file_fault.hpp"
#include "core/model_io/robot_loader.hpp"

#include <handover/common/status.hpp>

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace handover {

/// Models already loaded, by name: cells share them.
using ModelCache = std::map<std::string, std::shared_ptr<const RobotModel>>;

/// Reads a robot's yaml file; its URDF and SRDF lie beside it and are named relative to `root`.
/// @throws FileError with every fault.
RobotSettings readRobotSettings(const std::filesystem::path& file,
                                const std::filesystem::path& root);

/// What is wrong where a task's chain does not begin with the arm that holds the object.
inline constexpr const char* kNotItsHolder =
    "must begin with the arm that holds the object at the start";

/// A loaded cell file. Immutable; safe from any thread.
class Cell {
 public:
  /// What a cell is at one moment: the scene and its tasks, goals resolved into the world.
  struct Instance {
    std::shared_ptr<const Scene> scene;
    std::vector<SceneTask> tasks;  ///< in the file's order
  };

  /// `divide` is for meshes that are not convex, now and when overrides name others; safe from any
  /// thread. @throws FileError with every fault of the cell and of the robot files it names.
  static Cell load(const std::filesystem::path& file, const std::filesystem::path& root,
                   ModelCache& models, const ConvexDecomposer& divide = convexParts);

  const std::string& name() const;
  const std::filesystem::path& file() const;
  std::vector<std::string> taskNames() const;
  /// What looks like a slip, though the cell can be planned with; what it is made of.
  const std::vector<FileFault>& warnings() const;
  const std::vector<FileFault>& facts() const;
  /// The `vary:` part, in the file's order.
  const std::vector<Variation>& variations() const;

  /// The cell with overrides applied in their order; or every fault, `field` = the override's path.
  /// Arm postures given by tool pose are solved by IK, the same way every time: of all solutions
  /// the one nearest to the posture before. Unreachable ones are faults naming robot and arm.
  std::variant<Instance, std::vector<Fault>> instantiate(const std::vector<Override>& overrides,
                                                         std::uint64_t revision) const;
  /// The same with another decomposer for what the overrides name; what it throws comes through.
  std::variant<Instance, std::vector<Fault>> instantiate(const std::vector<Override>& overrides,
                                                         std::uint64_t revision,
                                                         const ConvexDecomposer& divide) const;

 private:
  struct Data;
  std::shared_ptr<const Data> data_;
};

}  // namespace handover
