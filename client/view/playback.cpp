// SPDX-License-Identifier: Apache-2.0
#include "view/playback.hpp"

#include "view/plan_json.hpp"
#include "view/root_files.hpp"

#include <nlohmann/json.hpp>

#include <cmath>
#include <stdexcept>

namespace handover::view {

using Json = nlohmann::json;

Playback::Playback(const Json& file, const RootFiles& files) : motion_(file.at("plan")) {
  const Json& scene = file.at("scene");
  for (const Json& robot : scene.at("robots")) {
    const auto urdf = robot.at("urdf").get<std::string>();
    robots_.push_back({robot.at("name"), urdf, Robot(files.read(urdf), urdf),
                       poseOf(robot.at("X_WB")), robot.at("q_start").get<Positions>()});
  }
  for (const Json& object : scene.at("objects")) {
    if (object.at("name") == scene.at("object")) object_ = objects_.size();
    addObject(object);
  }
  objects_.at(object_).X_WO = poseOf(scene.at("start").at("X_WO"));
  for (const Json& json : file.at("plan").at("holders")) {
    const auto robot = json.at("robot").get<std::string>();
    holders_.push_back({robot, json.at("arm"), linkOf(robot, json.at("tool_link")),
                        poseOf(json.at("X_OT")).inverse()});
  }
  if (std::isfinite(motion_.putDown())) {
    X_WO_end_ = heldBy(holders_.back(), robotsAt(motion_.putDown()));
  }
}

LinkPlace Playback::linkOf(const std::string& robot, const std::string& link) const {
  for (std::size_t r = 0; r < robots_.size(); ++r) {
    if (robots_[r].name == robot) return {r, robots_[r].model.linkIndex(link)};
  }
  throw std::out_of_range(robot);
}

void Playback::addObject(const Json& json) {
  SceneObject object;
  object.name = json.at("name");
  object.geometry = geometryOf(json.at("geometry"));
  object.X_WO = poseOf(json.at("X_WO"));
  if (const Json& attached = json.at("attached_to"); !attached.is_null()) {
    object.attached_to = linkOf(attached.at("robot"), attached.at("link"));
    object.X_LO = poseOf(attached.at("X_LO"));
  }
  objects_.push_back(std::move(object));
}

Moment Playback::at(double time) const {
  Moment moment = robotsAt(time);
  for (std::size_t o = 0; o < objects_.size(); ++o) {
    moment.X_WO.push_back(objectAt(o, time, moment));
  }
  return moment;
}

Moment Playback::robotsAt(double time) const {
  Moment moment;
  for (const SceneRobot& robot : robots_) {
    moment.q.push_back(motion_.jointsAt(robot.name, robot.q_start, time));
    moment.X_WL.push_back(robot.model.linkPoses(robot.X_WB, moment.q.back()));
  }
  return moment;
}

Pose Playback::heldBy(const Holder& holder, const Moment& moment) const {
  return moment.X_WL[holder.tool.robot][holder.tool.link] * holder.X_TO;
}

Pose Playback::plannedObjectAt(double time, const Moment& moment) const {
  for (std::size_t h = 0; h < holders_.size(); ++h) {
    const HoldTime& hold = motion_.holds()[h];
    if (hold.from <= time && time < hold.to) return heldBy(holders_[h], moment);
  }
  return time >= motion_.putDown() ? X_WO_end_ : objects_[object_].X_WO;
}

Pose Playback::objectAt(std::size_t index, double time, const Moment& moment) const {
  const SceneObject& object = objects_[index];
  if (index == object_) return plannedObjectAt(time, moment);
  if (!object.attached_to) return object.X_WO;
  return moment.X_WL[object.attached_to->robot][object.attached_to->link] * object.X_LO;
}

}  // namespace handover::view
