// SPDX-License-Identifier: Apache-2.0
// Whether the stages of a plan join: each goes on where its joints are, at rest or in motion.
#pragma once

#include <handover/common/plan_event.hpp>

#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace handover::test {

/// Where a joint stopped, and how.
struct JointEnd {
  double time = -1, q = 0, qd = 0, qdd = 0;
};

/// What is wrong with the joint's passing from `before` to a stage that starts, if anything: it
/// rests, exactly, on both sides, or the stage takes over its motion as the other ends.
inline std::optional<std::string> jointFault(const JointEnd& before, const JointEnd& after) {
  if (std::abs(after.q - before.q) > 1e-9) return "jumps by " + std::to_string(after.q - before.q);
  const bool moves = before.qd != 0 || before.qdd != 0;
  if (moves && std::abs(after.time - before.time) < 1e-9) {
    if (std::abs(after.qd - before.qd) > 1e-6) return "changes its speed";
    if (std::abs(after.qdd - before.qdd) > 1e-6) return "changes its acceleration";
    return std::nullopt;
  }
  if (moves) return "stops with a speed or an acceleration";
  if (after.qd != 0) return "starts with a speed";
  if (after.qdd != 0) return "starts with an acceleration";
  return std::nullopt;
}

/// The first joint of a plan that jumps, or whose speed or acceleration does, and where; nothing
/// when all stages join. @param stages  of one plan, by rising index.
inline std::optional<std::string> stagesFault(const SceneSnapshot& scene,
                                              const std::vector<StageTrajectory>& stages) {
  std::map<std::string, JointEnd> at;
  for (const RobotSnapshot& robot : scene.robots) {
    for (const auto& [joint, q] : robot.q_start) at[robot.name + "/" + joint].q = q;
  }
  for (const StageTrajectory& stage : stages) {
    for (std::size_t j = 0; j < stage.joints.size(); ++j) {
      const std::string name = stage.robot + "/" + stage.joints[j];
      JointEnd& joint = at.at(name);
      const JointEnd begin{stage.start, stage.q.front()[j], stage.qd.front()[j],
                           stage.qdd.front()[j]};
      if (const auto fault = jointFault(joint, begin)) {
        return "stage " + std::to_string(stage.index) + ": " + name + " " + *fault;
      }
      joint = {stage.start + stage.t.back(), stage.q.back()[j], stage.qd.back()[j],
               stage.qdd.back()[j]};
    }
  }
  for (const auto& [name, joint] : at) {
    if (joint.qd != 0 || joint.qdd != 0) return "in the end: " + name + " still moves";
  }
  return std::nullopt;
}

}  // namespace handover::test
