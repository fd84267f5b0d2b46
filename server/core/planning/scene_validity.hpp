// SPDX-License-Identifier: Apache-2.0
// May a transport begin and end as its scene says? (design §5, Rest)
#pragma once

#include "core/planning/transport_problem.hpp"

#include <handover/common/plan_event.hpp>

#include <optional>
#include <vector>

namespace handover {

/// Finds out what the object rests on at its start and goal, where the task leaves that open, and
/// whether it does: raised by 0.8 mm it intersects nothing, lowered by 1.8 mm it intersects what it
/// rests on. Where it starts or ends in a hand it rests on nothing. Nothing may intersect
/// anything else at the start, and what can move not touch it.
/// @param[in,out] task  of the problem: its rests are filled in.
/// @return the failure, if any: kStartInCollision, kStartUnsupported, kGoalInCollision,
///         kGoalUnsupported; kNoPath where it is to be held nearer to something than motions come.
std::optional<Failed> checkScene(const TransportProblem& problem, CollisionWorld& world,
                                 SceneTask& task);

/// The same of what can be said without the problem's maps and grasps: not of an end in a hand.
/// @pre it does not start in a hand.
std::optional<Failed> checkBodies(const TransportProblem& problem, CollisionWorld& world,
                                  SceneTask& task);

/// The same, not ending at the first: of everything that stands, of the start, of the goal.
std::vector<Failed> sceneFaults(const TransportProblem& problem, CollisionWorld& world);

}  // namespace handover
