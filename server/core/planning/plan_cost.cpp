// SPDX-License-Identifier: Apache-2.0
#include "core/planning/plan_cost.hpp"

#include "core/motion/least_time.hpp"

#include <algorithm>
#include <cmath>

namespace handover {
namespace {

constexpr double kDegree = M_PI / 180;

/// 1 at none, 0 from `enough` on.
double lack(double value, double enough) { return std::clamp(1 - value / enough, 0.0, 1.0); }

/// From rest to rest, the slowest joint [s].
double restToRest(const Manipulator& arm, const ArmVector& from, const ArmVector& to) {
  double time = 0;
  for (Eigen::Index j = 0; j < from.size(); ++j) {
    const Joint& joint =
        arm.model->joints[arm.model->dof_joints[arm.arm_model->dofs[std::size_t(j)]]];
    time = std::max(time, leastTime(to[j] - from[j], 0, 0, joint.velocity, joint.acceleration));
  }
  return time;
}

double marginOf(const Manipulator& arm, const ArmVector& q) {
  double margin = 0.5;
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    const Joint& joint =
        arm.model->joints[arm.model->dof_joints[arm.arm_model->dofs[std::size_t(j)]]];
    if (joint.continuous) continue;
    margin = std::min(
        margin, std::min(q[j] - joint.lower, joint.upper - q[j]) / (joint.upper - joint.lower));
  }
  return margin;
}

double angleBetween(const Pose& a, const Pose& b) {
  return Eigen::Quaterniond(a.linear()).angularDistance(Eigen::Quaterniond(b.linear()));
}

double leastClearance(const Quality& quality, const std::string& between, double wide) {
  double least = wide;
  for (const ClearanceQuality& clearance : quality.clearance) {
    if (clearance.between == between) least = std::min(least, clearance.least_m);
  }
  return least;
}

/// What the plan's figures without its ways add to its duration.
void addFigures(const CostWeights& weights, double weaker_grip, double turn, double margin,
                double dexterity, CostTerms& terms) {
  terms.emplace_back("grip", weights.grip * lack(weaker_grip, weights.firm));
  terms.emplace_back("turn", weights.turn * turn / (M_PI / 2));
  terms.emplace_back("limit", weights.limit * lack(margin, weights.margin));
  terms.emplace_back("dexterity", dexterity < weights.dexterous ? weights.clumsy : 0.0);
}

double sumOf(const CostTerms& terms) {
  double sum = 0;
  for (const auto& [name, seconds] : terms) sum += seconds;
  return sum;
}

}  // namespace

PlanCost costOf(const TransportProblem& problem, const Quality& quality, double placing,
                double best_placing) {
  const CostWeights& weights = problem.settings.cost;
  PlanCost cost;
  cost.terms.emplace_back("duration", quality.duration_s);
  if (problem.objective == Objective::kDexterity) {
    cost.cost = -placing;
    return cost;
  }
  if (problem.objective == Objective::kTime) {
    cost.cost = quality.duration_s;
    return cost;
  }
  for (const char* between : {"furniture", "robots", "object"}) {
    cost.terms.emplace_back(
        std::string("clearance_") + between,
        weights.clearance * lack(leastClearance(quality, between, weights.wide), weights.wide));
  }
  double weaker = 1;
  for (const GripQuality& grip : quality.grip) weaker = std::min(weaker, grip.of_best);
  const double turn = (quality.object_turn_deg[0] - quality.object_turn_deg[1]) * kDegree;
  addFigures(weights, weaker, turn, quality.limit_margin,
             best_placing > 0 ? placing / best_placing : 1, cost.terms);
  cost.cost = sumOf(cost.terms);
  return cost;
}

void setCost(const TransportProblem& problem, double placing, double best_placing,
             Solution& solution) {
  PlanCost cost = costOf(problem, *solution.quality, placing, best_placing);
  solution.cost = solution.quality->cost = cost.cost;
  solution.quality->terms = std::move(cost.terms);
}

double promisedCost(const TransportProblem& problem, const std::vector<const Manipulator*>& holders,
                    const TransportTuple& tuple, const CellState& start, double best_placing) {
  const double placing = tuple.holders.back().give.manipulability;
  if (problem.objective == Objective::kDexterity) return -placing;
  double now = 0, end = 0, weaker = 1, margin = 0.5, turn = 0;
  const Pose* X_WO = &problem.task.X_WO_start;
  for (std::size_t k = 0; k < holders.size(); ++k) {
    const Manipulator& arm = *holders[k];
    const ArmVector home = arm.armOf(start.of(arm));
    const HolderGrasp& grasp = tuple.holders[k];
    const ArmVector& q_take = grasp.take.configurations.front();
    const ArmVector& q_give = grasp.give.configurations.front();
    now = std::max(now, restToRest(arm, home, q_take));
    now += restToRest(arm, q_take, q_give);
    const bool ends = k + 1 == holders.size() && problem.task.end == TransportEnd::kHold;
    end = std::max(end, ends ? now : now + restToRest(arm, q_give, home));
    const double best = arm.grasps->grasps.front().quality;
    if (best > 0) weaker = std::min(weaker, arm.grasp(grasp.take.grasp).quality / best);
    margin = std::min({margin, marginOf(arm, q_take), marginOf(arm, q_give)});
    const Pose& X_WO_next = k + 1 < holders.size() ? tuple.X_WH[k] : problem.task.X_WO_goal;
    turn += angleBetween(*X_WO, X_WO_next);
    X_WO = &X_WO_next;
  }
  if (problem.objective == Objective::kTime) return end;
  turn -= angleBetween(problem.task.X_WO_start, problem.task.X_WO_goal);
  CostTerms terms{{"duration", end}};
  addFigures(problem.settings.cost, weaker, turn, margin,
             best_placing > 0 ? placing / best_placing : 1, terms);
  return sumOf(terms);
}

}  // namespace handover
