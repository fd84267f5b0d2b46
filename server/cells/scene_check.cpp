// SPDX-License-Identifier: Apache-2.0
#include "cells/scene_check.hpp"

#include "core/planning/arm_selection.hpp"
#include "core/planning/explanation.hpp"
#include "core/planning/scene_validity.hpp"

#include <set>

namespace handover {
namespace {

using Grade = SceneFinding::Grade;

std::string nameOf(const ArmName& arm) { return arm.robot + "/" + arm.arm; }

/// The findings of one task.
class TaskFindings {
 public:
  TaskFindings(const std::string& task, const TransportProblem& problem)
      : task_(task), problem_(problem), world_(problem.collision) {}

  std::vector<SceneFinding> all() {
    for (const Failed& fault : sceneFaults(problem_, world_)) addSceneFault(fault);
    addGrasps();
    addReach();
    return std::move(findings_);
  }

 private:
  void add(Grade grade, std::string text) { findings_.push_back({grade, task_, std::move(text)}); }

  void addSceneFault(const Failed& fault) {
    add(Grade::kFault, std::string(toString(fault.reason)) + ": " + fault.explanation.text);
    for (const CauseCount& cause : fault.explanation.causes) {
      if (cause.cause != Cause::kCollision || cause.pair.second.empty()) continue;
      add(Grade::kFault, cause.pair.first + " touches " + cause.pair.second);
    }
  }

  void addGrasps() {
    for (std::size_t robot = 0; robot < problem_.resources.size(); ++robot) {
      const SceneRobot& placed = problem_.scene->robots[robot];
      for (std::size_t arm = 0; arm < placed.model->arms.size(); ++arm) {
        const auto& grasps = problem_.resources[robot].grasps[arm];
        if (!grasps) continue;
        const std::string who = placed.name + "/" + placed.model->arms[arm].name + ": ";
        if (grasps->grasps.empty()) {
          add(Grade::kWarning,
              who + "no grasp of " + problem_.task.object + ": " + grasps->none_because);
        } else {
          add(Grade::kFact,
              who + std::to_string(grasps->grasps.size()) + " grasps of " + problem_.task.object);
        }
      }
    }
  }

  std::optional<ChainHolder> end(bool first) const {
    const auto& chain = problem_.task.chain;
    if (chain.empty()) return std::nullopt;
    return first ? chain.front() : chain.back();
  }

  void addReach() {
    const std::size_t last = problem_.task.chain.empty() ? 0 : problem_.task.chain.size() - 1;
    const auto start = rankArms(problem_, end(true), 0, problem_.task.X_WO_start, Deadline());
    const auto goal = rankArms(problem_, end(false), last, problem_.task.X_WO_goal, Deadline());
    addEnd(PruningPlace::kStart, start);
    addEnd(PruningPlace::kGoal, goal);
    const auto& chain = problem_.task.chain;
    const bool two_robots = chain.size() == 2 && chain[0].robot != chain[1].robot;
    if (!two_robots || start.arms.empty() || goal.arms.empty()) return;
    const std::size_t points = commonPoints(problem_);
    add(points == 0 ? Grade::kWarning : Grade::kFact,
        std::to_string(points) + " points near the shoulders' middle are in reach of both arms");
  }

  void addEnd(PruningPlace place, const ArmRanking& ranking) {
    if (ranking.arms.empty()) {
      const Failed why = explainArms(problem_, place, ranking);
      return add(Grade::kFault, std::string(toString(why.reason)) + ": " + why.explanation.text);
    }
    std::string arms;
    for (const ArmScore& score : ranking.scores) {
      if (score.rejected == Cause::kUnspecified)
        arms += (arms.empty() ? "" : ", ") + nameOf(score.arm);
    }
    add(Grade::kFact,
        (place == PruningPlace::kStart ? "the start is in reach of " : "the goal is in reach of ") +
            arms);
  }

  const std::string& task_;
  const TransportProblem& problem_;
  CollisionWorld world_;
  std::vector<SceneFinding> findings_;
};

}  // namespace

std::vector<SceneFinding> sceneFindings(CellService& service, const std::string& cell,
                                        const Deadline& deadline) {
  std::vector<SceneFinding> all;
  for (const CellInfo& info : service.served()->infos) {
    if (info.name != cell) continue;
    for (const std::string& task : info.tasks) {
      PlanRequest request;
      request.cell = cell;
      request.task = task;
      auto problem = service.problemOf(request, deadline, Missing::kMake);
      if (auto* ready = std::get_if<TransportProblem>(&problem)) {
        for (SceneFinding& it : TaskFindings(task, *ready).all()) all.push_back(std::move(it));
        continue;
      }
      const auto* rejected = std::get_if<Rejected>(&std::get<Outcome>(problem));
      for (const Fault& fault : rejected != nullptr ? rejected->faults : std::vector<Fault>()) {
        all.push_back({Grade::kFault, task, fault.field + ": " + fault.message});
      }
    }
  }
  return all;
}

}  // namespace handover
