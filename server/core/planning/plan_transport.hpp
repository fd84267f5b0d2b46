// SPDX-License-Identifier: Apache-2.0
// The whole answer to one request: arms, grasps, handover poses, trajectories ([paper] §IV).
#pragma once

#include "core/planning/plan_event_sink.hpp"
#include "core/planning/transport_problem.hpp"

#include <handover/common/deadline.hpp>

#include <vector>

namespace handover {

/// What a search did.
struct SearchEffort {
  std::uint64_t poses = 0;    ///< X_WH asked for
  std::uint64_t motions = 0;  ///< whole plans, takes and inner grasps that motions were sought for

  /// In poses, about: a motion costs as much as 3,000 of them (butler: 40 ms and 14 us).
  std::uint64_t work() const { return poses + 3'000 * motions; }
};

/// Plans; emits the scene snapshot, the funnel, solutions and trajectories, and returns the outcome
/// (which the caller emits). Same problem, same events, byte for byte. Safe from any thread.
/// @param[out] effort  what it took, where wanted.
Outcome planTransport(const TransportProblem& problem, PlanEventSink& sink,
                      const Deadline& deadline, SearchEffort* effort = nullptr);

/// How many lattice points the maps know that both arms of a chain of two reach, of the arms that
/// have most; 0 too where no arm reaches the start or the goal (rankArms). No collisions; of
/// `collision` only which bodies there are. `wide` also looks at points beyond the maps, and may
/// now and then find a plan where this is 0. @pre the task's chain has two holders.
std::size_t commonPoints(const TransportProblem& problem);

/// All that an arm can reach, and more: a ball about its shoulder.
struct ReachBall {
  Eigen::Vector3d p_WShoulder;
  double radius = 0;  ///< [m]
};

/// The balls of the arms that may take a place in a chain.
std::vector<ReachBall> reachBalls(const TransportProblem& problem, const ChainHolder& holder);

}  // namespace handover
