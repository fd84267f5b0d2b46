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
  const ArmId index = problem.scene->robots[robot].model->findArm(arm.arm);
  if (!index.valid()) return "";
  const auto& grasps = problem.resources[robot].grasps[index];
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

/// A pair of bodies that is nearly every cause: it is told first.
constexpr double kDominant = 0.95;

std::string dominantPair(const CauseTally& tally) {
  const std::vector<CauseCount> causes = tally.counts();
  const std::uint32_t total = tally.total();
  if (causes.empty() || causes.front().pair.second.empty()) return "";
  const CauseCount& first = causes.front();
  if (first.count < kDominant * total) return "";
  return first.pair.first + " touches " + first.pair.second + " in " + std::to_string(first.count) +
         " of " + std::to_string(total) + " tries. ";
}

/// How often the object would have leaned too far; empty where it never did.
std::string leanedOf(const TransportProblem& problem, const CauseTally& tally) {
  std::uint32_t count = 0;
  for (const CauseCount& it : tally.counts()) count += it.cause == Cause::kTilt ? it.count : 0;
  if (count == 0) return "";
  return " In " + std::to_string(count) + " of " + std::to_string(tally.total()) + " tries " +
         problem.task.object + " would have leaned too far.";
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
    if (score.rejected == Cause::kNotInMap) graspless = false;
  }
  const FailureReason unreachable =
      start ? FailureReason::kStartUnreachable : FailureReason::kGoalUnreachable;
  return failed(graspless ? FailureReason::kNoGrasp : unreachable,
                start ? "arms_at_start" : "arms_at_goal",
                "No arm can " + std::string(start ? "take " : "bring ") + problem.task.object +
                    (start ? " at its start" : " to its goal") + arms + ".",
                tally.counts(8), problem.search == SearchWidth::kWide && ranking.proven);
}

Failed explainUnfitHolder(const TransportProblem& problem, const ChainHolder& holder,
                          const Unfit& unfit) {
  const SceneRobot& robot = problem.scene->robots[holder.robot];
  ArmScore score;
  score.arm = {robot.name, robot.model->arms[holder.arm].name};
  score.rejected = unfit.cause;
  score.object = unfit.object;
  CauseTally tally;
  tally.add(score.rejected, {nameOf(score.arm), score.object});
  return failed(FailureReason::kNoGrasp, "arms_at_start",
                nameOf(score.arm) + " cannot hold " + problem.task.object + " at the start: it " +
                    lackOf(problem, score) + ".",
                tally.counts(), true);
}

Failed explainNoChain(const TransportProblem& problem, std::size_t n,
                      const std::vector<ArmName>& takers, const std::vector<ArmName>& bringers,
                      CauseTally tally) {
  const auto names = [](const std::vector<ArmName>& arms) {
    std::string text;
    for (const ArmName& arm : arms) text += (text.empty() ? "" : " or ") + nameOf(arm);
    return text;
  };
  if (tally.total() == 0) {  // the chain alone forbids it
    for (const ArmName& arm : takers) tally.add(Cause::kExcluded, {nameOf(arm), {}});
  }
  const std::string& object = problem.task.object;
  std::string text =
      n == 1 ? "No arm of the chain can both take and bring " + object
             : "No order of arms fits a chain of " + std::to_string(n) + " for " + object;
  text += ": " + names(takers) + " can take it, " + names(bringers) + " can bring it";
  if (n > 1) text += ", and holders that follow each other must be different arms";
  return failed(FailureReason::kGoalUnreachable, "chains", text + ".", tally.counts(), false);
}

namespace {

/// The arms that have a grasp left.
std::vector<ArmName> armsOf(const PrunedByArm& sets) {
  std::vector<ArmName> arms;
  for (const auto& [arm, pruned] : sets) {
    if (!pruned.kept.empty()) arms.push_back(arm);
  }
  return arms;
}

/// No grasp is left at the start, or at the goal.
Failed explainPruned(const TransportProblem& problem, PruningPlace place, const PrunedByArm& sets) {
  const bool start = place == PruningPlace::kStart;
  CauseTally tally;
  const std::string tested = testedOf(sets, tally);
  const bool proven =
      std::all_of(sets.begin(), sets.end(), [](const auto& entry) { return entry.second.proven; });
  return failed(start ? FailureReason::kNoGraspAtStart : FailureReason::kNoGraspAtGoal,
                start ? "grasps_at_start" : "grasps_at_goal",
                dominantPair(tally) + "No free grasp of " + problem.task.object +
                    (start ? " at its start." : " at its goal.") + tested,
                tally.counts(), problem.search == SearchWidth::kWide && proven);
}

/// An arm that holds the object at the start cannot bring it by that grasp.
Failed explainHeld(const TransportProblem& problem, const ArmName& arm,
                   const PrunedGrasps& placed) {
  CauseTally tally = placed.rejects;
  if (tally.total() == 0) tally.add(Cause::kHoldsObject, {nameOf(arm), {}});
  return failed(FailureReason::kNoGraspAtGoal, "grasps_at_both",
                nameOf(arm) + " cannot bring " + problem.task.object +
                    " to its goal by the grasp that holds it at the start; by " +
                    std::to_string(placed.kept.size()) + " of its " +
                    std::to_string(placed.tested) + " grasps it could.",
                tally.counts(), false);
}

/// One arm has grasps at the start and others at the goal.
Failed explainAlone(const TransportProblem& problem, const PrunedByArm& at_start,
                    const PrunedByArm& at_goal) {
  CauseTally tally;
  std::string counts;
  for (const auto& [arm, pruned] : at_start) {
    const auto placed = at_goal.find(arm);
    if (placed == at_goal.end()) continue;
    if (problem.task.held_by) return explainHeld(problem, arm, placed->second);
    tally.add(pruned.rejects);
    tally.add(placed->second.rejects);
    counts += (counts.empty() ? " " : "; ") + nameOf(arm) + ": " +
              std::to_string(pruned.kept.size()) + " at the start, " +
              std::to_string(placed->second.kept.size()) + " at the goal";
  }
  return failed(FailureReason::kNoGraspAtGoal, "grasps_at_both",
                "No grasp holds " + problem.task.object +
                    " both at its start and at its goal, without a second holder." + counts + ".",
                tally.counts(), false);
}

/// No tuple: at no pose for two, or at none of those that come before the last handover of more.
std::string posesText(const std::string& object, const SearchCounts& counts) {
  const std::string tried = std::to_string(counts.poses_asked) + " handover poses tried";
  if (counts.last_poses == 0)
    return "None of the " + tried + " lets both hands hold " + object + ".";
  return "Of the " + tried + " " + std::to_string(counts.last_poses) + " let both hands hold " +
         object + " at the chain's last handover, but no handover before it leads there.";
}

}  // namespace

Failed explainSearch(const TransportProblem& problem, const PrunedByArm& at_start,
                     const PrunedByArm& at_goal, const SearchCounts& counts) {
  const std::string& object = problem.task.object;
  const bool wide = problem.search == SearchWidth::kWide;
  if (!at_start.empty() && noneKept(at_start)) {
    return explainPruned(problem, PruningPlace::kStart, at_start);
  }
  if (!at_goal.empty() && noneKept(at_goal)) {
    return explainPruned(problem, PruningPlace::kGoal, at_goal);
  }
  if (counts.chains == 0 && !at_goal.empty()) {
    CauseTally tally;
    for (const PrunedByArm* sets : {&at_start, &at_goal}) {
      for (const auto& [arm, pruned] : *sets) {
        if (pruned.kept.empty()) tally.add(pruned.rejects);
      }
    }
    return explainNoChain(problem, problem.task.chain.size(), armsOf(at_start), armsOf(at_goal),
                          std::move(tally));
  }
  if (counts.alone && counts.tuples == 0 && !counts.may_meet) {
    return explainAlone(problem, at_start, at_goal);
  }
  CauseTally tally;
  if (counts.lattice_points == 0 && counts.tuples == 0) {
    if (counts.handover_rejects.total() == 0) {
      tally.add(Cause::kNotInMap);
    } else {
      tally.add(counts.handover_rejects);
    }
    return failed(FailureReason::kNoCommonWorkspace, "common_workspace",
                  "No point near the middle of the shoulders is in reach of both arms.",
                  tally.counts(), wide && !counts.may_meet);
  }
  if (counts.tuples == 0) {
    return failed(FailureReason::kNoHandoverPose, "handover_poses",
                  dominantPair(counts.handover_rejects) + posesText(object, counts) +
                      leanedOf(problem, counts.handover_rejects),
                  counts.handover_rejects.counts(), wide && !counts.may_meet);
  }
  const std::vector<CauseCount> causes = counts.motion_rejects.counts();
  std::string text = "Grasps exist, but no motion between them was found";
  if (!causes.empty() && causes.front().stage) {
    text += "; most tries, " + std::to_string(causes.front().count) + " of " +
            std::to_string(counts.motion_rejects.total()) + ", ended at the " +
            stageName(*causes.front().stage);
  }
  return failed(
      FailureReason::kNoPath, "motions",
      dominantPair(counts.motion_rejects) + text + "." + leanedOf(problem, counts.motion_rejects),
      causes, false);
}

Failed explainDeadline(const PrunedByArm& at_start, const PrunedByArm& at_goal,
                       const SearchCounts& counts) {
  const auto late = [](std::string filter, const std::string& at, const CauseTally& tally) {
    return failed(FailureReason::kDeadline, std::move(filter),
                  dominantPair(tally) + "The deadline passed " + at + ".", tally.counts(), false);
  };
  if (counts.motion_rejects.total() > 0) {
    return late("motions", "while motions were sought", counts.motion_rejects);
  }
  if (counts.handover_rejects.total() > 0) {
    return late("handover_poses",
                "after " + std::to_string(counts.poses_asked) + " handover poses were tried",
                counts.handover_rejects);
  }
  CauseTally tally;
  for (const PrunedByArm* sets : {&at_goal, &at_start}) {
    for (const auto& [arm, pruned] : *sets) tally.add(pruned.rejects);
    if (tally.total() == 0) continue;
    const bool goal = sets == &at_goal;
    return late(goal ? "grasps_at_goal" : "grasps_at_start",
                std::string("while grasps were tested at the ") + (goal ? "goal" : "start"), tally);
  }
  tally.add(Cause::kDeadline);
  return late("scene", "before anything was tried", tally);
}

}  // namespace handover
