// SPDX-License-Identifier: Apache-2.0
#include "core/model/scene.hpp"

#include "core/model/content_hash.hpp"

#include <algorithm>

namespace handover {
namespace {

template <typename Items>
int indexOf(const Items& items, std::string_view name) {
  const auto found = std::find_if(items.begin(), items.end(),
                                  [name](const auto& item) { return item.name == name; });
  return found == items.end() ? -1 : static_cast<int>(found - items.begin());
}

const std::string& linkName(const RobotModel& model, LinkId link) { return model.links[link].name; }

RobotSnapshot snapshotOf(const SceneRobot& robot) {
  const RobotModel& model = *robot.model;
  RobotSnapshot shown;
  shown.name = robot.name;
  shown.urdf = model.urdf_path;
  shown.urdf_sha256 = model.urdf_sha256;
  shown.srdf = model.srdf_path;
  shown.yaml = model.yaml_path;
  shown.yaml_sha256 = model.yaml_sha256;
  shown.X_WB = toValue(robot.X_WB);
  for (const JointId i : IdRange<JointId>(model.joints.size())) {
    const Joint& joint = model.joints[i];
    if (joint.type == JointType::kFixed) continue;
    shown.q_start.emplace_back(joint.name, model.jointPosition(i, robot.q_start) + 0.0);
    JointLimits limits{joint.lower, joint.upper, joint.velocity, joint.acceleration, joint.jerk};
    if (joint.continuous) limits.lower = limits.upper = std::nullopt;
    shown.limits.emplace_back(joint.name, limits);
  }
  for (const auto& [link, object] : robot.resting) {
    shown.resting.emplace_back(linkName(model, link), object);
  }
  return shown;
}

RestSnapshot snapshotOf(const TaskRest& rest) {
  return {rest.none, rest.objects.value_or(std::vector<std::string>())};
}

ArmName armName(const Scene& scene, const ChainHolder& holder) {
  const SceneRobot& robot = scene.robots[holder.robot];
  return {robot.name, robot.model->arms[holder.arm].name};
}

ObjectSnapshot snapshotOf(const Scene& scene, const SceneObject& object) {
  ObjectSnapshot shown;
  shown.name = object.name;
  shown.geometry = object.geometry;
  shown.X_WO = toValue(object.X_WO);
  shown.resting = object.resting;
  if (object.attached_to) {
    const Attachment& held = *object.attached_to;
    const SceneRobot& robot = scene.robots[held.robot];
    AttachmentSnapshot attachment{
        robot.name, linkName(*robot.model, held.link), toValue(held.X_LO), {}};
    for (const LinkId link : held.touch_links) {
      attachment.touch_links.push_back(linkName(*robot.model, link));
    }
    shown.attached_to = std::move(attachment);
  }
  return shown;
}

void add(ContentHash& hash, const SceneRobot& robot) {
  const RobotModel& model = *robot.model;
  hash.add(robot.name);
  hash.add(model.content_hash.empty() ? modelHash(model) : model.content_hash);
  hash.add(robot.X_WB).add(robot.q_start).add(robot.resting.size());
  for (const auto& [link, object] : robot.resting) hash.add(link).add(object);
}

void add(ContentHash& hash, const std::vector<std::string>& names) {
  hash.add(names.size());
  for (const std::string& name : names) hash.add(name);
}

void add(ContentHash& hash, const TaskRest& rest) {
  hash.add(rest.none ? 1 : 0).add(rest.objects ? 1 : 0);
  if (rest.objects) add(hash, *rest.objects);
}

void add(ContentHash& hash, const SceneObject& object, const Pose& X_WO) {
  hash.add(object.name).add(object.shapes).add(X_WO);
  if (object.divided) {
    for (const DividedBody& body : *object.divided) hash.add(body.hash);
  }
  hash.add(object.attached_to ? 1 : 0);
  if (object.attached_to) {
    const Attachment& held = *object.attached_to;
    hash.add(held.robot).add(held.link).add(held.X_LO).add(held.touch_links);
  }
  add(hash, object.resting);
}

}  // namespace

RobotId Scene::findRobot(std::string_view robot) const { return RobotId(indexOf(robots, robot)); }

ObjectId Scene::findObject(std::string_view object) const {
  return ObjectId(indexOf(objects, object));
}

bool beginsWithHolder(const SceneTask& task) {
  if (!task.held_by || task.chain.empty()) return true;
  const ChainHolder& first = task.chain.front();
  return first.robot == task.held_by->robot &&
         (!first.arm.valid() || first.arm == task.held_by->arm);
}

std::shared_ptr<const Scene> startOf(const std::shared_ptr<const Scene>& scene,
                                     const SceneTask& task) {
  const ObjectId index = scene->findObject(task.object);
  if (!index.valid()) return scene;
  const SceneObject& stands = scene->objects[index];
  const auto rest = task.start_rest.objects.value_or(stands.resting);
  if (stands.X_WO.matrix() == task.X_WO_start.matrix() && stands.resting == rest) return scene;
  auto moved = std::make_shared<Scene>(*scene);
  moved->objects[index].X_WO = task.X_WO_start;
  moved->objects[index].resting = rest;
  return moved;
}

SceneSnapshot snapshot(const Scene& scene, const SceneTask& task, std::uint64_t seed) {
  SceneSnapshot shown;
  shown.cell = scene.cell;
  shown.task = task.name;
  shown.seed = seed;
  shown.scene_hash = sceneHash(scene, task);
  shown.object = task.object;
  shown.start = {toValue(task.X_WO_start), {}, snapshotOf(task.start_rest)};
  if (task.held_by) shown.start.held_by = armName(scene, *task.held_by);
  shown.goal = {toValue(task.X_WO_goal), task.end, snapshotOf(task.goal_rest)};
  shown.upright = task.upright;
  for (const SceneRobot& robot : scene.robots) shown.robots.push_back(snapshotOf(robot));
  for (const SceneObject& object : scene.objects) {
    shown.objects.push_back(snapshotOf(scene, object));
    if (object.name != task.object) continue;
    shown.objects.back().X_WO = shown.start.X_WO;
    shown.objects.back().resting.clear();
  }
  return shown;
}

std::string sceneHash(const Scene& scene, const SceneTask& task) {
  ContentHash hash;
  hash.add(scene.robots.size());
  for (const SceneRobot& robot : scene.robots) add(hash, robot);
  hash.add(scene.objects.size());
  for (const SceneObject& object : scene.objects) {
    add(hash, object, object.name == task.object ? task.X_WO_start : object.X_WO);
  }
  hash.add(task.object).add(task.chain.size());
  for (const ChainHolder& holder : task.chain) hash.add(holder.robot).add(holder.arm);
  hash.add(task.X_WO_start).add(task.X_WO_goal).add(static_cast<int>(task.end));
  const ChainHolder held_by = task.held_by.value_or(ChainHolder{});
  hash.add(held_by.robot).add(held_by.arm);
  add(hash, task.start_rest);
  add(hash, task.goal_rest);
  if (task.upright) {
    for (const double value : task.upright->axis) hash.add(value);
    hash.add(task.upright->within_deg);
  }
  return hash.hex();
}

}  // namespace handover
