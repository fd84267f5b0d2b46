// SPDX-License-Identifier: Apache-2.0
#include "verify/checks.hpp"

#include <algorithm>
#include <cmath>

namespace handover::verify {
namespace {

constexpr double kLeastGap = 1e-3;  // [s] between samples

class StructureCheck {
 public:
  StructureCheck(const Scene& scene, Report& report) : scene_(scene), report_(report) {}

  bool run() {
    if (!chain() || !list()) return false;
    bool sound = true;
    for (int s = 0; s < scene_.stageCount(); ++s) sound = samples(s) && sound;
    if (!sound) return false;
    for (int s = 0; s < scene_.stageCount(); ++s) sound = robotAndJoints(s) && sound;
    return sound && overlaps();
  }

 private:
  void violation(int s, double time, const char* kind, const std::string& what) {
    report_.add({s, time, kind, what, {}});
  }

  void chainFault(const std::string& what) { violation(-1, 0, "chain", what); }

  bool chain() {
    const Plan& plan = scene_.plan;
    const std::size_t before = report_.violations.size();
    if (plan.handovers.size() + 1 != plan.holders.size()) {
      chainFault(std::to_string(plan.handovers.size()) + " handover(s) for " +
                 std::to_string(plan.holders.size()) + " holder(s)");
    }
    const PlanHolder& first = plan.holders.front();
    if (plan.start.held_by && *plan.start.held_by != NamePair(first.robot, first.arm)) {
      chainFault("the object starts in the hand of " + plan.start.held_by->first + "/" +
                 plan.start.held_by->second + ", which is not the first holder");
    }
    for (int k = 0; k < scene_.holderCount(); ++k) {
      const PlanHolder& holder = scene_.planHolder(k);
      if (!scene_.holder(k).group_known) {
        chainFault(holder.arm + " is no group of the SRDF of " + holder.robot);
      } else if (scene_.holder(k).arm_joints.empty()) {
        chainFault("no joint of " + holder.robot + "/" + holder.arm + " moves " + holder.tool_link);
      }
      if (k > 0) {
        const PlanHolder& other = scene_.planHolder(k - 1);
        if (other.robot == holder.robot && other.arm == holder.arm) {
          chainFault("holders " + std::to_string(k - 1) + " and " + std::to_string(k) +
                     " are one arm");
        }
      }
      hand(k);
    }
    return report_.violations.size() == before;
  }

  /// Hand links lie in the tool link's rigid group, which is beyond the arm's last joint, or below.
  void hand(int k) {
    const Holder& holder = scene_.holder(k);
    const Robot& robot = scene_.robot(holder.robot);
    const std::vector<int> groups = robot.rigidGroups();
    const int base = groups[static_cast<std::size_t>(holder.tool_link)];
    for (const int link : holder.hand_links) {
      const bool suction = scene_.planHolder(k).suction;
      const bool lawful =
          suction ? groups[static_cast<std::size_t>(link)] == base : robot.hangsFrom(link, base);
      if (lawful) continue;
      chainFault(scene_.planHolder(k).robot + "/" +
                 robot.links[static_cast<std::size_t>(link)].name +
                 (suction ? " is not rigid with " : " is no part of a hand at ") +
                 scene_.planHolder(k).tool_link);
    }
  }

  bool list() {
    const auto expected = expectedStages(
        scene_.holderCount(), scene_.plan.start.held_by.has_value(), !scene_.plan.goal.release);
    if (scene_.plan.stages.size() != expected.size()) {
      violation(-1, 0, "stages",
                std::to_string(scene_.plan.stages.size()) + " stages instead of " +
                    std::to_string(expected.size()));
      return false;
    }
    bool sound = true;
    for (int s = 0; s < scene_.stageCount(); ++s) {
      const PlanStage& stage = scene_.stage(s);
      const auto& [holder, action] = expected[static_cast<std::size_t>(s)];
      if (stage.holder != holder || stage.action != action) {
        violation(s, stage.start, "stages",
                  "is " + stage.action + " of holder " + std::to_string(stage.holder) +
                      " instead of " + action + " of holder " + std::to_string(holder));
        sound = false;
      }
      if (stage.index != s) {
        violation(s, stage.start, "stages", "has index " + std::to_string(stage.index));
        sound = false;
      }
    }
    return sound;
  }

  bool samples(int s) {
    const PlanStage& stage = scene_.stage(s);
    bool sound = true;
    const auto fault = [&](const std::string& what) {
      violation(s, stage.start, "samples", what);
      sound = false;
    };
    if (stage.start < 0) fault("starts before the plan");
    if (stage.t.size() < 2) {
      fault("fewer than two samples");
      return false;
    }
    if (stage.t.front() != 0) fault("the first sample is not at 0");
    for (std::size_t k = 1; k < stage.t.size(); ++k) {
      if (stage.t[k] - stage.t[k - 1] >= kLeastGap - kTimeTolerance) continue;
      fault("sample " + std::to_string(k) + " is less than 1 ms after the one before it");
      break;
    }
    return sound;
  }

  bool robotAndJoints(int s) {
    const PlanStage& stage = scene_.stage(s);
    const PlanHolder& holder = scene_.planHolder(stage.holder);
    if (stage.robot != holder.robot) {
      violation(s, stage.start, "stages", "moves " + stage.robot + " instead of " + holder.robot);
      return false;
    }
    const bool gripper_stage = stage.action == "grasp" || stage.action == "release";
    if (gripper_stage && !holder.suction && stage.joints.empty()) {
      violation(s, stage.start, "joints", "moves no joint of the gripper");
      return false;
    }
    const std::vector<int> allowed = allowedJoints(stage);
    bool sound = true;
    for (std::size_t c = 0; c < stage.joints.size(); ++c) {
      const int joint = scene_.stage_joints[static_cast<std::size_t>(s)][c];
      if (std::find(allowed.begin(), allowed.end(), joint) != allowed.end()) continue;
      violation(s, stage.start, "joints",
                stage.joints[c] + " is no joint that this stage may move");
      sound = false;
    }
    return sound;
  }

  std::vector<int> allowedJoints(const PlanStage& stage) const {
    const Holder& holder = scene_.holder(stage.holder);
    const std::vector<int> gripper =
        scene_.planHolder(stage.holder).suction ? std::vector<int>() : holder.gripper_joints;
    if (stage.action == "grasp" || stage.action == "release") return gripper;
    std::vector<int> allowed = holder.arm_joints;
    if (stage.action == "reach" || stage.action == "home") {
      allowed.insert(allowed.end(), gripper.begin(), gripper.end());
    }
    return allowed;
  }

  bool overlaps() {
    bool sound = true;
    for (int a = 0; a < scene_.stageCount(); ++a) {
      for (int b = 0; b < a; ++b) {
        const PlanStage& one = scene_.stage(a);
        const PlanStage& other = scene_.stage(b);
        if (one.robot != other.robot ||
            std::min(one.end(), other.end()) - std::max(one.start, other.start) <= kTimeTolerance) {
          continue;
        }
        const auto shared = std::find_first_of(one.joints.begin(), one.joints.end(),
                                               other.joints.begin(), other.joints.end());
        if (shared == one.joints.end()) continue;
        violation(a, one.start, "overlap",
                  *shared + " is moved by " + scene_.stageName(b) + " at the same time");
        sound = false;
      }
    }
    return sound;
  }

  const Scene& scene_;
  Report& report_;
};

}  // namespace

bool checkStructure(const Scene& scene, Report& report) {
  return StructureCheck(scene, report).run();
}

void checkClaims(const Motion& motion, const ContactRules& rules, Report& report) {
  const Scene& scene = motion.scene();
  for (int s = 0; s < scene.stageCount(); ++s) {
    const double from = motion.start(s), to = motion.end(s);
    Allowances allowances;
    for (int k = 0; k <= motion.task().last(); ++k) {
      allowances.hand.push_back(handWindow(motion, k).overlaps(from, to));
    }
    allowances.start_rest = startRestWindow(motion).overlaps(from, to);
    allowances.goal_rest = goalRestWindow(motion).overlaps(from, to);
    for (const auto& [a, b] : scene.stage(s).may_touch) {
      if (rules.mayTouch(allowances, a, b) || rules.standing(a, b)) continue;
      report.add({s,
                  from,
                  "may_touch",
                  "claims " + a + " with " + b + ", which may not touch in this stage",
                  {a, b}});
    }
  }
}

}  // namespace handover::verify
