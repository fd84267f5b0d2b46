// SPDX-License-Identifier: Apache-2.0
// One request, resolved: everything that a plan depends on.
#pragma once

#include "core/collision/collision_scene.hpp"
#include "core/grasp/grasp_set.hpp"
#include "core/model/scene.hpp"
#include "core/planning/search_settings.hpp"
#include "core/reachability/reachability_map.hpp"
#include "core/task/stages.hpp"

#include <handover/common/plan_request.hpp>

#include <memory>
#include <vector>

namespace handover {

/// What was prepared offline for one robot of the scene.
struct RobotResources {
  std::vector<std::shared_ptr<const ArmKinematics>> kinematics;  ///< per arm
  std::vector<std::shared_ptr<const ReachabilityMap>> maps;      ///< per arm
  /// Per arm: grasp sets of the task's object; empty pointer where there is none.
  std::vector<std::shared_ptr<const GraspSet>> grasps;
};

/// All names known to exist.
struct TransportProblem {
  std::shared_ptr<const Scene> scene;  ///< as the task starts (startOf())
  std::shared_ptr<const CollisionScene> collision;
  SceneTask task;                         ///< with the request's chain
  std::vector<RobotResources> resources;  ///< per robot of the scene
  SearchMode mode = SearchMode::kFirst;
  SearchWidth search = SearchWidth::kWide;
  Objective objective = Objective::kDexterity;
  std::uint64_t seed = 1;
  double speed_scale = 1.0;
  SearchSettings settings;
  int held_grasp = -1;  ///< where the object starts in a hand: the index of its grasp
};

/// The task's shape with a chain of so many holders.
inline Transport transportOf(const SceneTask& task, std::size_t holders) {
  return {holders, task.held_by.has_value(), task.end};
}

}  // namespace handover
