// SPDX-License-Identifier: Apache-2.0
// The whole answer to one request: arms, grasps, handover pose, trajectories ([paper] §IV, Alg.
// 1-3).
#pragma once

#include "core/collision/collision_scene.hpp"
#include "core/grasp/grasp_set.hpp"
#include "core/model/scene.hpp"
#include "core/reachability/reachability_map.hpp"

#include <handover/common/deadline.hpp>
#include <handover/common/plan_event.hpp>

#include <memory>
#include <vector>

namespace handover {

/// Takes the stages of an answer as they become known. Called from the planning thread.
class PlanEventSink {
 public:
  virtual ~PlanEventSink() = default;
  virtual void emit(PlanEventPayload payload) = 0;
};

/// What was prepared offline for one robot of the scene.
struct RobotResources {
  std::vector<std::shared_ptr<const ArmKinematics>> kinematics;  ///< per arm
  std::vector<std::shared_ptr<const ReachabilityMap>> maps;      ///< per arm
  /// Per arm: grasp sets of the task's object; empty pointer where there is none.
  std::vector<std::shared_ptr<const GraspSet>> grasps;
};

/// Everything a plan depends on, resolved from the request; all names known to exist.
struct HandoverProblem {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const CollisionScene> collision;
  SceneTask task;
  std::vector<RobotResources> resources;  ///< per robot of the scene
  std::string giver_arm, receiver_arm;    ///< empty: free choice
  SearchMode mode = SearchMode::kBest;
  SearchWidth search = SearchWidth::kWide;
  std::uint64_t seed = 1;
  double speed_scale = 1.0;
};

/// Plans; emits the scene snapshot, the funnel, solutions and trajectories, and returns the outcome
/// (which the caller emits). Same problem, same stages, byte for byte. Safe from any thread.
Outcome planHandover(const HandoverProblem& problem, PlanEventSink& sink, const Deadline& deadline);

/// Whether the maps leave the problem a chance: an arm for the start, one for the goal (rankArms)
/// and a lattice point that both reach by their maps. No collisions; of `collision` only which
/// bodies there are. `wide` also looks at points beyond the maps, and may now and then find a plan
/// where this says no.
bool mapsAllow(const HandoverProblem& problem);

/// All that an arm can reach, and more: a ball about its shoulder.
struct ReachBall {
  Eigen::Vector3d p_WShoulder;
  double radius = 0;  ///< [m]
};

/// The balls of a robot's arms that may take part. @pre `only`: name of an arm, or empty for any.
std::vector<ReachBall> reachBalls(const HandoverProblem& problem, int robot,
                                  const std::string& only);

}  // namespace handover
