// SPDX-License-Identifier: Apache-2.0
// What a plan costs under the request's objective (design §7, Objective).
#pragma once

#include "core/planning/transport_path.hpp"
#include "core/planning/transport_problem.hpp"

#include <string>
#include <utility>
#include <vector>

namespace handover {

/// Seconds by name: the duration, and what `balanced` adds to it.
using CostTerms = std::vector<std::pair<std::string, double>>;

/// Lower is better. `dexterity`: -manipulability of the last holder where it gives the object;
/// `time`: duration_s; `balanced`: the sum of the terms.
struct PlanCost {
  double cost = 0;
  CostTerms terms;
};

/// @param placing  manipulability where the last holder gives the object.
/// @param best_placing  the most that any grasp has there.
PlanCost costOf(const TransportProblem& problem, const Quality& quality, double placing,
                double best_placing);

/// Puts it into a solution and its quality.
void setCost(const TransportProblem& problem, double placing, double best_placing,
             Solution& solution);

/// What a tuple's plan costs at least, if its grasps' first configurations are the ones that it
/// takes: every arm goes straight and stops nowhere, nothing is in the way.
double promisedCost(const TransportProblem& problem, const std::vector<const Manipulator*>& holders,
                    const TransportTuple& tuple, const CellState& start, double best_placing);

}  // namespace handover
