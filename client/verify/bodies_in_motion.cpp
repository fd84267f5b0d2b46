// SPDX-License-Identifier: Apache-2.0
#include "verify/bodies_in_motion.hpp"

namespace handover::verify {

Mount mountOf(const Scene& scene, int body) {
  const SceneBody& entry = scene.body(body);
  if (entry.robot >= 0) return {entry.robot, entry.link, Pose::Identity()};
  const PlanObject& object = scene.planObject(entry.object);
  if (!object.attached_to) return {-1, -1, object.X_WO};
  const int robot = scene.plan.findRobot(object.attached_to->robot);
  return {robot, scene.robot(robot).findLink(object.attached_to->link), object.attached_to->X_LO};
}

Mount mountInHand(const Scene& scene, int holder) {
  return {scene.holder(holder).robot, scene.holder(holder).tool_link,
          scene.planHolder(holder).X_OT.inverse()};
}

Mount mountOfObject(const Motion& motion, double T) {
  const int carrier = motion.carrierAt(T);
  if (carrier >= 0) return mountInHand(motion.scene(), carrier);
  return {-1, -1, motion.objectAt(T)};
}

int actorOfLink(const Scene& scene, const Task& task, int robot, int link) {
  if (robot < 0) return -1;
  const Robot& model = scene.robot(robot);
  for (const int j : model.jointsAbove(link)) {
    const std::size_t master = model.lawOf(static_cast<std::size_t>(j)).master;
    for (std::size_t a = 0; a < task.actors.size(); ++a) {
      if (task.actors[a].robot == robot && task.actors[a].joints[master]) {
        return static_cast<int>(a);
      }
    }
  }
  return -1;
}

}  // namespace handover::verify
