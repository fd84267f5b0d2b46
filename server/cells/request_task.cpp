// SPDX-License-Identifier: Apache-2.0
#include "cells/request_task.hpp"

#include "settings/yaml_reader.hpp"

#include <algorithm>

namespace handover {
namespace {

/// `robot` or `robot/arm`.
ChainHolder holderNamed(const std::string& name, const Scene& scene, const std::string& field,
                        std::vector<Fault>& faults) {
  const std::size_t slash = name.find('/');
  const std::string robot = name.substr(0, slash);
  ChainHolder holder{scene.findRobot(robot), {}};
  if (!holder.robot.valid()) {
    faults.push_back(
        {field, "the cell has no robot '" + robot + "'" + nearestNamed(scene.robots, robot)});
    return holder;
  }
  const RobotModel& model = *scene.robots[holder.robot].model;
  if (slash == std::string::npos) {
    if (model.arms.empty()) faults.push_back({field, "robot '" + robot + "' has no arm"});
    return holder;
  }
  const std::string arm = name.substr(slash + 1);
  holder.arm = model.findArm(arm);
  if (!holder.arm.valid()) {
    faults.push_back(
        {field, "robot '" + robot + "' has no arm '" + arm + "'" + nearestNamed(model.arms, arm)});
  }
  return holder;
}

void applyChain(const PlanRequest& request, const Scene& scene, SceneTask& task,
                std::vector<Fault>& faults) {
  if (request.chain.empty()) return;
  task.chain.clear();
  if (request.chain == std::vector<std::string>{kAutoChain}) return;
  for (std::size_t i = 0; i < request.chain.size(); ++i) {
    const std::string field = "chain[" + std::to_string(i) + "]";
    const ChainHolder holder = holderNamed(request.chain[i], scene, field, faults);
    if (i > 0 && holder.robot.valid() && holder.robot == task.chain.back().robot) {
      const auto& model = *scene.robots[holder.robot].model;
      const bool same = holder.arm.valid() && holder.arm == task.chain.back().arm;
      if (same || model.arms.size() < 2) {
        faults.push_back({field, "successive holders must be different arms"});
      }
    }
    task.chain.push_back(holder);
  }
}

SceneTask namedTask(const PlanRequest& request, const Cell::Instance& instance,
                    std::vector<Fault>& faults) {
  for (const auto& task : instance.tasks) {
    if (request.task.empty() || task.name == request.task) return task;
  }
  faults.push_back({"task", "the cell has no task '" + request.task + "'" +
                                nearestNamed(instance.tasks, request.task)});
  return {};
}

SceneTask describedTask(const PlanRequest& request, const Scene& scene,
                        std::vector<Fault>& faults) {
  SceneTask task;
  task.object = request.object;
  if (const ObjectId object = scene.findObject(request.object); !object.valid()) {
    faults.push_back({"object_name", "the cell has no object '" + request.object + "'" +
                                         nearestNamed(scene.objects, request.object)});
  } else {
    const SceneObject& it = scene.objects[object];
    task.X_WO_start = it.X_WO;
    if (!it.resting.empty()) task.start_rest.objects = it.resting;
    if (it.attached_to) {
      faults.push_back({"object_name", "'" + request.object + "' is attached to a robot"});
    }
  }
  if (request.X_WO_goal) {
    task.X_WO_goal = toPose(*request.X_WO_goal);
  } else {
    faults.push_back({"X_WO_goal", "a request without a task needs a goal pose"});
  }
  return task;
}

}  // namespace

SceneTask resolveTask(const PlanRequest& request, const Cell::Instance& instance,
                      std::vector<Fault>& faults) {
  const bool named = !request.task.empty() || request.object.empty();
  SceneTask task = named ? namedTask(request, instance, faults)
                         : describedTask(request, *instance.scene, faults);
  applyChain(request, *instance.scene, task, faults);
  if (!beginsWithHolder(task)) {
    faults.push_back(
        {request.chain.empty() ? "tasks." + task.name + ".chain" : "chain", kNotItsHolder});
  }
  return task;
}

Objective objectiveOf(const PlanRequest& request) {
  if (request.objective != Objective::kUnspecified) return request.objective;
  return request.search == SearchWidth::kPaper ? Objective::kDexterity : Objective::kBalanced;
}

void checkSearch(const PlanRequest& request, const SceneTask& task, std::vector<Fault>& faults) {
  const bool paper = request.search == SearchWidth::kPaper;
  if (paper && task.chain.size() != 2) {
    faults.push_back({"search", "paper needs a chain of exactly two holders"});
  }
  if (paper && objectiveOf(request) != Objective::kDexterity) {
    faults.push_back({"objective", "paper has the objective dexterity"});
  }
  if (request.slack_s > 0) faults.push_back({"slack_s", "not built yet: must be 0"});
}

int takeInHand(Scene& scene, SceneTask& task, const GraspSet* grasps) {
  if (grasps == nullptr || grasps->grasps.empty()) return -1;
  SceneRobot& robot = scene.robots[task.held_by->robot];
  const Arm& arm = robot.model->arms[task.held_by->arm];
  const Hand& hand = robot.model->hands[arm.hand];
  const Grasp& grasp = grasps->grasps.front();
  for (std::size_t i = 0; i < hand.dofs.size(); ++i) {
    robot.q_start[hand.dofs[i].value()] = grasp.closed[static_cast<Eigen::Index>(i)];
  }
  std::vector<Pose> X_WL;
  linkPoses(*robot.model, robot.X_WB, robot.q_start, X_WL);
  task.X_WO_start = X_WL[arm.tool_link] * grasp.X_OT.inverse();
  return 0;
}

}  // namespace handover
