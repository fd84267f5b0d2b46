// SPDX-License-Identifier: Apache-2.0
#include "core/planning/arm_selection.hpp"

#include "core/planning/manipulator.hpp"

#include <algorithm>
#include <optional>

namespace handover {
namespace {

/// What IK says of an arm that the map does not know at a place.
struct IkReach {
  /// Of the first configuration that reaches a grasp of the object; nullopt: none does.
  std::optional<double> manipulability;
  bool proven = true;  ///< by a closed form, and for no grasp only beyond joint limits
};

/// What the map cannot know: it has holes where few samples fell, at the edge of the reach.
IkReach reachedByIk(const Manipulator& manipulator, const Pose& X_WO, const Deadline& deadline) {
  IkReach reach;
  const bool closed_form = manipulator.kinematics->closedForm();
  for (const Grasp& grasp : manipulator.grasps->grasps) {
    if (deadline.over()) return {std::nullopt, false};
    const Pose X_WT = X_WO * grasp.X_OT;
    const Pose X_AT = manipulator.worldToArm(X_WT);
    if (X_AT.translation().norm() > manipulator.kinematics->reach()) continue;
    reach.proven = reach.proven && closed_form;
    // Least squares take a hundred times as long, mostly in vain.
    if (!closed_form && !manipulator.mapReaches(X_WT)) continue;
    const IkCounts counts = manipulator.kinematics->visit(X_AT, IkQuery{}, [&](const ArmVector& q) {
      reach.manipulability = manipulator.kinematics->manipulability(q);
      return false;
    });
    if (reach.manipulability) break;
    if (counts.limits > 0) reach.proven = false;
  }
  return reach;
}

/// The map's entry that ranks the arm; 0: not reached.
double mapEntry(const Manipulator& manipulator, const Pose& X_WO, SearchWidth search) {
  double entry = manipulator.map(X_WO.translation());
  if (search != SearchWidth::kWide) return entry;
  for (const Grasp& grasp : manipulator.grasps->grasps) {
    entry = std::max(entry, manipulator.map((X_WO * grasp.X_OT).translation()));
  }
  return entry;
}

/// Fills manipulability or the cause against the arm. @return whether that is proven.
bool rate(const TransportProblem& problem, const ChainHolder& arm, const Pose& X_WO,
          const Deadline& deadline, ArmScore& score) {
  if (const auto unfit = unfitReason(problem, arm.robot, arm.arm)) {
    score.rejected = unfit->cause;
    score.object = unfit->object;
    return true;
  }
  const Manipulator manipulator = makeManipulator(problem, arm.robot, arm.arm);
  score.manipulability = mapEntry(manipulator, X_WO, problem.search);
  if (score.manipulability > 0) return true;
  score.rejected = Cause::kNotInMap;
  if (problem.search != SearchWidth::kWide) return false;
  const IkReach reach = reachedByIk(manipulator, X_WO, deadline);
  if (reach.manipulability) {
    score.rejected = Cause::kUnspecified;
    score.manipulability = *reach.manipulability;
  }
  return reach.proven;
}

/// Every arm of the robots that `which` allows, in order.
template <typename Visit>
void forEachArm(const TransportProblem& problem, const std::optional<ChainHolder>& which,
                const Visit& visit) {
  for (const RobotId robot : IdRange<RobotId>(problem.scene->robots.size())) {
    if (which && which->robot != robot) continue;
    const RobotModel& model = *problem.scene->robots[robot].model;
    for (const ArmId arm : IdRange<ArmId>(model.arms.size())) {
      visit(ChainHolder{robot, arm});
    }
  }
}

}  // namespace

ArmRanking rankArms(const TransportProblem& problem, const std::optional<ChainHolder>& which,
                    std::size_t holder, const Pose& X_WO, const Deadline& deadline) {
  ArmRanking ranking;
  forEachArm(problem, which, [&](const ChainHolder& arm) {
    const SceneRobot& placed = problem.scene->robots[arm.robot];
    ArmScore score;
    score.arm = {placed.name, placed.model->arms[arm.arm].name};
    score.holder = static_cast<std::uint32_t>(holder);
    ranking.proven = rate(problem, arm, X_WO, deadline, score) && ranking.proven;
    const bool excluded = which && which->arm.valid() && which->arm != arm.arm;
    if (excluded && score.rejected == Cause::kUnspecified) score.rejected = Cause::kExcluded;
    if (score.rejected == Cause::kUnspecified) ranking.arms.push_back({arm, score.manipulability});
    ranking.scores.push_back(std::move(score));
  });
  std::stable_sort(
      ranking.arms.begin(), ranking.arms.end(),
      [](const RankedArm& a, const RankedArm& b) { return a.manipulability > b.manipulability; });
  return ranking;
}

std::vector<ChainHolder> fitArms(const TransportProblem& problem,
                                 const std::optional<ChainHolder>& which) {
  std::vector<ChainHolder> arms;
  forEachArm(problem, which, [&](const ChainHolder& arm) {
    if (which && which->arm.valid() && which->arm != arm.arm) return;
    if (!unfitReason(problem, arm.robot, arm.arm)) arms.push_back(arm);
  });
  return arms;
}

}  // namespace handover
