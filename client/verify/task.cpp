// SPDX-License-Identifier: Apache-2.0
#include "verify/task.hpp"

#include <algorithm>
#include <map>
#include <set>

namespace handover::verify {
namespace {

int& placeOf(HolderStages& stages, const std::string& action) {
  static const std::map<std::string, int HolderStages::*> kPlaces = {
      {"reach", &HolderStages::reach},     {"approach", &HolderStages::approach},
      {"grasp", &HolderStages::grasp},     {"lift", &HolderStages::lift},
      {"carry", &HolderStages::carry},     {"place", &HolderStages::place},
      {"release", &HolderStages::release}, {"retreat", &HolderStages::retreat},
      {"home", &HolderStages::home}};
  return stages.*kPlaces.at(action);
}

bool moving(const PlanStage& stage, std::size_t sample, std::size_t column) {
  return stage.qd[sample][column] != 0 || stage.qdd[sample][column] != 0;
}

/// Whether some joint passes from one to the other without a stop.
bool passes(const PlanStage& before, const PlanStage& after) {
  for (std::size_t c = 0; c < after.joints.size(); ++c) {
    const auto found = std::find(before.joints.begin(), before.joints.end(), after.joints[c]);
    if (found == before.joints.end()) continue;
    const auto b = static_cast<std::size_t>(found - before.joints.begin());
    if (moving(before, before.t.size() - 1, b) || moving(after, 0, c)) return true;
  }
  return false;
}

void findRuns(const Scene& scene, Task& task) {
  std::map<NamePair, int> last_of_arm;
  for (int s = 0; s < scene.stageCount(); ++s) {
    const PlanHolder& holder = scene.planHolder(scene.stage(s).holder);
    const auto [found, first] = last_of_arm.emplace(NamePair(holder.robot, holder.arm), -1);
    task.previous.push_back(found->second);
    const bool joined = found->second >= 0 && passes(scene.stage(found->second), scene.stage(s));
    task.joined.push_back(joined);
    if (joined) {
      task.run_of.push_back(task.run_of[static_cast<std::size_t>(found->second)]);
    } else {
      task.run_of.push_back(static_cast<int>(task.runs.size()));
      task.runs.emplace_back();
    }
    task.runs[static_cast<std::size_t>(task.run_of.back())].push_back(s);
    found->second = s;
  }
}

/// Every joint that a holder's arm and gripper have, or that its stages name.
std::vector<bool> jointsOf(const Scene& scene, int k) {
  const Holder& holder = scene.holder(k);
  std::vector<bool> joints(scene.robot(holder.robot).joints.size(), false);
  const auto add = [&](const std::vector<int>& some) {
    for (const int j : some) joints[static_cast<std::size_t>(j)] = true;
  };
  add(holder.arm_joints);
  add(holder.gripper_joints);
  for (int s = 0; s < scene.stageCount(); ++s) {
    if (scene.stage(s).holder == k) add(scene.stage_joints[static_cast<std::size_t>(s)]);
  }
  return joints;
}

/// Whether a joint of one is the other's, or moves a joint of it.
bool entangled(const Robot& robot, const std::vector<bool>& a, const std::vector<bool>& b) {
  for (std::size_t j = 0; j < a.size(); ++j) {
    if (!a[j]) continue;
    if (b[j]) return true;
    for (const int above : robot.jointsAbove(robot.joints[j].parent)) {
      if (b[robot.lawOf(static_cast<std::size_t>(above)).master]) return true;
    }
  }
  return false;
}

void findActors(const Scene& scene, Task& task) {
  std::vector<std::vector<int>> holders;  // of the actors
  for (int k = 0; k < scene.holderCount(); ++k) {
    Actor actor{scene.holder(k).robot, {}, jointsOf(scene, k)};
    std::vector<int> members = {k};
    for (std::size_t other = 0; other < task.actors.size();) {
      const Actor& known = task.actors[other];
      const Robot& robot = scene.robot(actor.robot);
      if (known.robot == actor.robot && (entangled(robot, known.joints, actor.joints) ||
                                         entangled(robot, actor.joints, known.joints))) {
        for (std::size_t j = 0; j < actor.joints.size(); ++j) {
          if (known.joints[j]) actor.joints[j] = true;
        }
        members.insert(members.end(), holders[other].begin(), holders[other].end());
        task.actors.erase(task.actors.begin() + static_cast<std::ptrdiff_t>(other));
        holders.erase(holders.begin() + static_cast<std::ptrdiff_t>(other));
        other = 0;
      } else {
        ++other;
      }
    }
    task.actors.push_back(std::move(actor));
    holders.push_back(std::move(members));
  }
  task.actor_of_holder.assign(scene.plan.holders.size(), -1);
  for (std::size_t a = 0; a < holders.size(); ++a) {
    for (const int k : holders[a]) {
      task.actor_of_holder[static_cast<std::size_t>(k)] = static_cast<int>(a);
    }
  }
  for (int s = 0; s < scene.stageCount(); ++s) {
    const int actor = task.actor_of_holder[static_cast<std::size_t>(scene.stage(s).holder)];
    task.actor_of_stage.push_back(actor);
    task.actors[static_cast<std::size_t>(actor)].stages.push_back(s);
  }
}

}  // namespace

std::vector<std::pair<int, std::string>> expectedStages(int holders, bool held_at_start,
                                                        bool ends_held) {
  std::vector<std::pair<int, std::string>> stages;
  const auto add = [&](int holder, const std::vector<const char*>& actions) {
    for (const char* action : actions) stages.emplace_back(holder, action);
  };
  if (!held_at_start) add(0, {"reach", "approach", "grasp", "lift"});
  add(0, {"carry"});
  for (int k = 1; k < holders; ++k) {
    add(k, {"reach", "approach", "grasp"});
    add(k - 1, {"release", "retreat", "home"});
    add(k, {"carry"});
  }
  if (!ends_held) add(holders - 1, {"place", "release", "retreat", "home"});
  return stages;
}

Task makeTask(const Scene& scene) {
  Task task;
  task.held_at_start = scene.plan.start.held_by.has_value();
  task.ends_held = !scene.plan.goal.release;
  task.of.resize(scene.plan.holders.size());
  for (int s = 0; s < scene.stageCount(); ++s) {
    placeOf(task.of[static_cast<std::size_t>(scene.stage(s).holder)], scene.stage(s).action) = s;
  }
  findRuns(scene, task);
  findActors(scene, task);
  return task;
}

}  // namespace handover::verify
