// SPDX-License-Identifier: Apache-2.0
#include "core/handover/arm_selection.hpp"

#include "core/handover/manipulator.hpp"

#include <algorithm>
#include <optional>

namespace handover {
namespace {

/// What the map cannot know: it has holes where few samples fell, at the edge of the reach.
/// The manipulability of the first configuration that reaches a grasp of the object; nullopt: none.
std::optional<double> reachedByIk(const Manipulator& role, const Pose& X_WO) {
  std::optional<double> manipulability;
  for (const Grasp& grasp : role.grasps->grasps) {
    role.kinematics->visit(role.worldToArm(X_WO * grasp.X_OT), IkQuery{}, [&](const ArmVector& q) {
      manipulability = role.kinematics->manipulability(q);
      return false;
    });
    if (manipulability) break;
  }
  return manipulability;
}

}  // namespace

ArmRanking rankArms(const HandoverProblem& problem, int robot, const Pose& X_WO,
                    const std::string& only, SearchWidth search) {
  const SceneRobot& placed = problem.scene->robots[static_cast<std::size_t>(robot)];
  ArmRanking ranking;
  for (int arm = 0; arm < static_cast<int>(placed.model->arms.size()); ++arm) {
    ArmScore score;
    score.robot = placed.name;
    score.arm = placed.model->arms[static_cast<std::size_t>(arm)].name;
    score.rejected = unfitReason(problem, robot, arm);
    if (score.rejected.empty()) {
      const Manipulator role = makeManipulator(problem, robot, arm);
      score.manipulability = role.map(X_WO.translation());
      if (search == SearchWidth::kWide) {
        for (const Grasp& grasp : role.grasps->grasps) {
          score.manipulability =
              std::max(score.manipulability, role.map((X_WO * grasp.X_OT).translation()));
        }
      }
      if (!only.empty() && score.arm != only) {
        score.rejected = "not asked for";
      } else if (score.manipulability > 0) {
        ranking.arms.push_back({arm, score.manipulability});
      } else if (const auto reached =
                     search == SearchWidth::kWide ? reachedByIk(role, X_WO) : std::nullopt) {
        score.manipulability = *reached;
        ranking.arms.push_back({arm, *reached});
      } else {
        score.rejected = "does not reach";
      }
    }
    ranking.scores.push_back(std::move(score));
  }
  std::stable_sort(
      ranking.arms.begin(), ranking.arms.end(),
      [](const RankedArm& a, const RankedArm& b) { return a.manipulability > b.manipulability; });
  return ranking;
}

}  // namespace handover
