// SPDX-License-Identifier: Apache-2.0
// A request's task against a cell: names looked up, every fault collected.
#pragma once

#include "core/planning/transport_problem.hpp"
#include "settings/cell_file.hpp"

#include <handover/common/plan_event.hpp>
#include <handover/common/plan_request.hpp>

#include <string>
#include <vector>

namespace handover {

/// The task of a request: named, or made from object and goal; with the request's chain, where it
/// has one. `faults` gets what is wrong; the task is usable only if there were none.
SceneTask resolveTask(const PlanRequest& request, const Cell::Instance& instance,
                      std::vector<Fault>& faults);

/// The request's, else the search's own.
Objective objectiveOf(const PlanRequest& request);

/// What of a request contradicts the search that it asks for, or is not built.
void checkSearch(const PlanRequest& request, const SceneTask& task, std::vector<Fault>& faults);

/// Where the task's object starts in a hand: the best of that hand's grasps, whose fingers close on
/// it; the object goes where the hand has it. @return the grasp's index; -1, nothing changed, if
/// the hand has none. @pre task.held_by.
int takeInHand(Scene& scene, SceneTask& task, const GraspSet* grasps);

}  // namespace handover
