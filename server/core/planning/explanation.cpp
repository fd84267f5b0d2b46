// SPDX-License-Identifier: Apache-2.0
#include "core/planning/explanation.hpp"

#include <algorithm>

namespace handover {
namespace {

std::string nameOf(const ArmName& arm) { return arm.robot + "/" + arm.arm; }

/// Why the arm's grasp set is empty, after a colon; empty where nothing is known.
std::string whyNoGrasps(const TransportProblem& problem, const ArmName& arm) {
  const RobotId robot = problem.scene->findRobot(arm.robot);
  if (!robot.valid()) return "";
  const auto r = static_cast<std::size_t>(robot);
  const ArmId index = problem.scene->robots[r].model->findArm(arm.arm);
  if (index < 0) return "";
  const auto& grasps = problem.resources[r].grasps[static_cast<std::size_t>(index)];
  return grasps && !grasps->none_because.empty() ? ": " + grasps->none_because : "";
}

/// What an arm lacks, after its name.
std::string lackOf(const TransportProblem& problem, const ArmScore& score) {
  switch (score.rejected) {
    case Cause::kHoldsObject:
      return "holds " + score.object;
    case Cause::kNoGripper:
      return "has no gripper";
    case Cause::kNoGrasps:
      return "has no grasp that fits" + whyNoGrasps(problem, score.arm);
    case Cause::kExcluded:
      return "is excluded by the request";
    default:
      return "does not reach it";
  }
}

/// Adds the sets' rejects to the tally and tells how many grasps of which arms were tested.
std::string testedOf(const PrunedByArm& sets, CauseTally& tally) {
  std::string text;
  for (const auto& [arm, pruned] : sets) {
    tally.add(pruned.rejects);
    text += text.empty() ? " Tested: " : ", ";
    text += std::to_string(pruned.tested) + " of " + nameOf(arm);
  }
  return text + ".";
}

std::string stageName(const StageRef& stage) {
  return std::string(toString(stage.action)) + " of holder " + std::to_string(stage.holder + 1);
}

}  // namespace

Failed failed(FailureReason reason, std::string filter, std::string text,
              std::vector<CauseCount> causes, bool exhaustive) {
  Failed result;
  result.reason = reason;
  result.explanation.filter = std::move(filter);
  result.explanation.text = std::move(text);
  result.explanation.causes = std::move(causes);
  result.explanation.exhaustive = exhaustive;
  return result;
}

bool noneKept(const PrunedByArm& sets) {
  return std::all_of(sets.begin(), sets.end(),
                     [](const auto& entry) { return entry.second.kept.empty(); });
}

Failed explainArms(const TransportProblem& problem, PruningPlace place, const ArmRanking& ranking) {
  const bool start = place == PruningPlace::kStart;
  CauseTally tally;
  std::string arms;
  bool graspless = true;
  for (const ArmScore& score : ranking.scores) {
    tally.add(score.rejected, {nameOf(score.arm), score.object});
    arms += (arms.empty() ? ": " : ", ") + nameOf(score.arm) + " " + lackOf(problem, score);
    if (score.rejected != Cause::kNoGrasps && score.rejected != Cause::kExcluded) graspless = false;
  }
  const FailureReason unreachable =
      start ? FailureReason::kStartUnreachable : FailureReason::kGoalUnreachable;
  return failed(graspless ? FailureReason::kNoGrasp : unreachable,
                start ? "arms_at_start" : "arms_at_goal",
                "No arm can " + std::string(start ? "take " : "bring ") + problem.task.object +
                    (start ? " at its start" : " to its goal") + arms + ".",
                tally.counts(8), problem.search == SearchWidth::kWide);
}

Failed explainSearch(const TransportProblem& problem, const PrunedByArm& at_start,
                     const PrunedByArm& at_goal, const SearchCounts& counts) {
  const std::string& object = problem.task.object;
  const bool wide = problem.search == SearchWidth::kWide;
  CauseTally tally;
  if (noneKept(at_start)) {
    const std::string tested = testedOf(at_start, tally);
    return failed(FailureReason::kNoGraspAtStart, "grasps_at_start",
                  "No free grasp of " + object + " at its start." + tested, tally.counts(), wide);
  }
  if (noneKept(at_goal)) {
    const std::string tested = testedOf(at_goal, tally);
    return failed(FailureReason::kNoGraspAtGoal, "grasps_at_goal",
                  "No free grasp of " + object + " at its goal." + tested, tally.counts(), wide);
  }
  if (counts.lattice_points == 0 && counts.tuples == 0) {
    tally.add(Cause::kNotInMap);
    return failed(FailureReason::kNoCommonWorkspace, "common_workspace",
                  "No point near the middle of the shoulders is in reach of both arms.",
                  tally.counts(), wide && !counts.cut);
  }
  if (counts.tuples == 0) {
    const bool all = wide && !counts.cut;
    const std::string which =
        all ? "No handover pose"
            : "None of the " + std::to_string(counts.poses_asked) + " handover poses tried";
    return failed(FailureReason::kNoHandoverPose, "handover_poses",
                  which + " lets both hands hold " + object + ".", counts.handover_rejects.counts(),
                  all);
  }
  const std::vector<CauseCount> causes = counts.motion_rejects.counts();
  std::string text = "Grasps exist, but no motion between them was found";
  if (!causes.empty() && causes.front().stage) {
    text += "; most tries, " + std::to_string(causes.front().count) + " of " +
            std::to_string(counts.motion_rejects.total()) + ", ended at the " +
            stageName(*causes.front().stage);
  }
  return failed(FailureReason::kNoPath, "motions", text + ".", causes, false);
}

}  // namespace handover
