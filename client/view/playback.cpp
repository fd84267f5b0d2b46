// SPDX-License-Identifier: Apache-2.0
#include "view/playback.hpp"

#include "view/root_files.hpp"

#include <algorithm>
#include <cmath>

namespace handover::view {

using client::PlanFileError;

Playback::Playback(client::PlanFile file, const RootFiles& files) : motion_(std::move(file)) {
  for (const RobotSnapshot& robot : scene().robots) {
    models_.emplace_back(files.read(robot.urdf), robot.urdf);
  }
  for (const ObjectSnapshot& object : scene().objects) {
    auto& link = attached_to_.emplace_back();
    if (object.attached_to) link = linkOf(object.attached_to->robot, object.attached_to->link);
  }
  for (const Holder& holder : plan().solution.holders) {
    tools_.push_back(linkOf(holder.arm.robot, holder.tool_link));
  }
  findHolds();
}

std::string Playback::labelOf(const StageTrajectory& stage) const {
  const ArmName& arm = plan().solution.holders[stage.holder].arm;
  return arm.robot + "/" + arm.arm + " " + toString(stage.action);
}

Playback::LinkPlace Playback::linkOf(const std::string& robot, const std::string& link) const {
  for (std::size_t r = 0; r < models_.size(); ++r) {
    if (scene().robots[r].name != robot) continue;
    if (const auto index = models_[r].findLink(link)) return {r, *index};
  }
  throw PlanFileError("/", "the URDF of " + robot + " has no link " + link);
}

void Playback::findHolds() {
  holds_.resize(tools_.size());
  for (const StageTrajectory& stage : plan().stages) {
    const double end = stage.start + stage.t.back();
    if (stage.action == StageAction::kGrasp) holds_[stage.holder].from = end;
    if (stage.action == StageAction::kRelease) holds_[stage.holder].to = end;
  }
  if (const double end = holds_.back().to; std::isfinite(end)) {
    X_WO_end_ = heldBy(holds_.size() - 1, robotsAt(end));
  }
}

Moment Playback::at(double time) const {
  Moment moment = robotsAt(time);
  for (std::size_t o = 0; o < scene().objects.size(); ++o) {
    moment.X_WO.push_back(objectAt(o, time, moment));
  }
  return moment;
}

Moment Playback::robotsAt(double time) const {
  Moment moment;
  for (std::size_t r = 0; r < models_.size(); ++r) {
    const RobotSnapshot& robot = scene().robots[r];
    const std::vector<client::JointState> states = motion_.sample(r, time);
    Positions q;
    for (std::size_t j = 0; j < states.size(); ++j) q[robot.q_start[j].first] = states[j].q;
    moment.X_WL.push_back(models_[r].linkPoses(toPose(robot.X_WB), q));
    moment.q.push_back(std::move(q));
  }
  return moment;
}

Pose Playback::heldBy(std::size_t holder, const Moment& moment) const {
  const LinkPlace& tool = tools_[holder];
  const Pose X_OT = toPose(plan().solution.holders[holder].X_OT);
  return moment.X_WL[tool.robot][tool.link] * X_OT.inverse();
}

Pose Playback::plannedObjectAt(double time, const Moment& moment) const {
  for (std::size_t holder = 0; holder < holds_.size(); ++holder) {
    if (holds_[holder].from <= time && time < holds_[holder].to) return heldBy(holder, moment);
  }
  return time >= holds_.back().to ? X_WO_end_ : toPose(scene().start.X_WO);
}

Pose Playback::objectAt(std::size_t index, double time, const Moment& moment) const {
  const ObjectSnapshot& object = scene().objects[index];
  if (object.name == scene().object) return plannedObjectAt(time, moment);
  const auto& link = attached_to_[index];
  if (!link) return toPose(object.X_WO);
  return moment.X_WL[link->robot][link->link] * toPose(object.attached_to->X_LO);
}

}  // namespace handover::view
