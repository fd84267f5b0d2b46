// SPDX-License-Identifier: Apache-2.0
#include "verify/checks.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

namespace handover::verify {
namespace {

constexpr double kPositionTolerance = 1e-6;  // [rad] or [m]
constexpr double kMimicTolerance = 1e-6;     // [rad] or [m]
constexpr double kTimeTolerance = 1e-9;      // [s]
constexpr double kObjectTolerance = 1e-4;    // [m]
constexpr double kObjectAngleTolerance = 0.01 * M_PI / 180;
constexpr double kRounding = 1e-9;  // of limits that went through text

std::string text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.6g", value);
  return buffer;
}

/// Accelerations are in no URDF; the contract names those of the two robots it knows.
std::optional<double> contractAcceleration(const Robot& robot, std::size_t joint) {
  const bool crichton = robot.name == "crichton";
  if (!crichton && robot.name != "hubo") return std::nullopt;
  for (const ChainGroup& chain : robot.chains) {
    std::vector<int> arm = robot.jointsAbove(chain.tip_link);
    arm.erase(arm.begin(),
              arm.begin() + static_cast<std::ptrdiff_t>(
                                std::min(arm.size(), robot.jointsAbove(chain.base_link).size())));
    if (std::find(arm.begin(), arm.end(), static_cast<int>(joint)) != arm.end()) {
      return crichton ? 0.4 : 0.8;
    }
  }
  return 5.0;
}

void checkRobotStart(const Scene& scene, std::size_t index, Report& report) {
  const Robot& robot = scene.robots[index];
  const PlanRobot& entry = scene.plan.robots[index];
  const auto violation = [&](const char* kind, const std::string& what) {
    report.violations.push_back({"", -1, 0, kind, what, {}});
  };
  std::vector<double> lawful = scene.q_start[index];
  robot.followMimics(lawful);
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const Joint& joint = robot.joints[j];
    if (!joint.movable()) continue;
    const std::string name = entry.name + "/" + joint.name;
    const ClaimedLimits& limits = entry.limits.at(joint.name);
    const double q = scene.q_start[index][j];
    if (q < limits.lower - kPositionTolerance || q > limits.upper + kPositionTolerance) {
      violation("q_start", name + " starts at " + text(q) + ", outside [" + text(limits.lower) +
                               ", " + text(limits.upper) + "]");
    }
    if (std::abs(q - lawful[j]) > kMimicTolerance) {
      violation("mimic", name + " starts at " + text(q) + ", its law says " + text(lawful[j]));
    }
    if (joint.type != JointType::kContinuous &&
        (limits.lower < joint.lower - kRounding || limits.upper > joint.upper + kRounding)) {
      violation("limits", name + " claims [" + text(limits.lower) + ", " + text(limits.upper) +
                              "], the URDF has [" + text(joint.lower) + ", " + text(joint.upper) +
                              "]");
    }
    if (limits.velocity > joint.velocity * (1 + kRounding)) {
      violation("limits", name + " claims velocity " + text(limits.velocity) + ", the URDF has " +
                              text(joint.velocity));
    }
    const auto acceleration = contractAcceleration(robot, j);
    if (acceleration && limits.acceleration > *acceleration * (1 + kRounding)) {
      violation("limits", name + " claims acceleration " + text(limits.acceleration) +
                              ", the contract has " + text(*acceleration));
    }
  }
}

/// Each stage: what it may move and when it may begin, by the table.
class StructureCheck {
 public:
  StructureCheck(const Scene& scene, Report& report) : scene_(scene), report_(report) {}

  bool run() {
    if (!order()) return false;
    bool sound = true;
    for (int s = 0; s < kStages; ++s) sound = times(s) && sound;
    if (!sound) return false;
    for (int s = 0; s < kStages; ++s) sound = robotAndJoints(s) && sound;
    return dependencies() && sound;
  }

 private:
  const PlanEvent& stage(int index) const {
    return scene_.plan.stages[static_cast<std::size_t>(index)];
  }

  void violation(int index, double time, const char* kind, const std::string& what) {
    report_.violations.push_back({stage(index).kind, index, time, kind, what, {}});
  }

  bool order() {
    if (scene_.plan.stages.size() != kStages) {
      report_.violations.push_back({"",
                                    -1,
                                    0,
                                    "order",
                                    std::to_string(scene_.plan.stages.size()) +
                                        " stages instead of " + std::to_string(kStages),
                                    {}});
      return false;
    }
    bool sound = true;
    for (int s = 0; s < kStages; ++s) {
      if (stage(s).kind != stageName(s)) {
        violation(
            s, stage(s).start, "order",
            "stage " + std::to_string(s) + " is " + stage(s).kind + " instead of " + stageName(s));
        sound = false;
      }
      if (stage(s).index != s) {
        violation(s, stage(s).start, "order",
                  "stage " + std::to_string(s) + " has index " + std::to_string(stage(s).index));
      }
    }
    return sound;
  }

  bool times(int s) {
    const PlanEvent& entry = stage(s);
    bool sound = true;
    const auto fault = [&](const std::string& what) {
      violation(s, entry.start, "samples", what);
      sound = false;
    };
    if (entry.start < 0) fault("starts before the plan");
    if (entry.t.size() < 2) fault("fewer than two samples");
    if (entry.t.front() != 0) fault("the first sample is not at 0");
    for (std::size_t k = 1; k < entry.t.size(); ++k) {
      if (entry.t[k] <= entry.t[k - 1]) {
        fault("sample " + std::to_string(k) + " is not after the one before it");
        break;
      }
    }
    return sound;
  }

  bool robotAndJoints(int s) {
    const PlanEvent& entry = stage(s);
    const std::string& robot = isGiverStage(s) ? scene_.plan.giver : scene_.plan.receiver;
    if (entry.robot != robot) {
      violation(s, entry.start, "robot", "moves " + entry.robot + " instead of " + robot);
      return false;
    }
    const Party& party = isGiverStage(s) ? scene_.giver : scene_.receiver;
    const Robot& model = scene_.robots[static_cast<std::size_t>(party.robot)];
    const std::vector<int>& allowed = isHandStage(s) ? party.arm.hand_joints : party.arm.joints;
    bool sound = true;
    for (const std::string& name : entry.joints) {
      const int joint = model.findJoint(name);
      if (std::find(allowed.begin(), allowed.end(), joint) != allowed.end()) continue;
      violation(s, entry.start, "joints",
                name + " is no " +
                    (isHandStage(s) ? "independent finger joint of the hand" : "joint of the arm") +
                    " that this stage moves");
      sound = false;
    }
    return sound;
  }

  /// `later` must not begin before `earlier` has ended.
  bool after(int later, int earlier) {
    if (stage(later).start >= stage(earlier).end() - kTimeTolerance) return true;
    violation(later, stage(later).start,
              isGiverStage(later) == isGiverStage(earlier) ? "overlap" : "sequence",
              "starts at " + text(stage(later).start) + " s, before the end of " +
                  stageName(earlier) + " at " + text(stage(earlier).end()) + " s");
    return false;
  }

  bool dependencies() {
    bool sound = true;
    if (scene_.giver.robot == scene_.receiver.robot) {
      report_.violations.push_back({"", -1, 0, "robot", "giver and receiver are one robot", {}});
      return false;
    }
    // Stages of one robot follow one another.
    for (const bool giver : {true, false}) {
      int previous = -1;
      for (int s = 0; s < kStages; ++s) {
        if (isGiverStage(s) != giver) continue;
        if (previous >= 0) sound = after(s, previous) && sound;
        previous = s;
      }
    }
    // Across robots, from the column of holds: a stage lies within the time of the holds that its
    // row names. The receiver may start when the giver has O in hand ...
    if (stage(kReceiverReach).start < stage(kGiverLift).start - kTimeTolerance) {
      violation(kReceiverReach, stage(kReceiverReach).start, "sequence",
                "starts before the giver holds the object, at the start of giver_lift");
      sound = false;
    }
    // ... O stands still from receiver_grasp to the end of giver_release ...
    sound = after(kReceiverGrasp, kGiverTransfer) && sound;
    sound = after(kGiverRelease, kReceiverGrasp) && sound;
    // ... only then it is the receiver's alone ...
    sound = after(kReceiverTransfer, kGiverRelease) && sound;
    // ... and giver_retreat is one of the stages in which the receiver holds it throughout.
    sound = after(kReceiverRelease, kGiverRetreat) && sound;
    return sound;
  }

  const Scene& scene_;
  Report& report_;
};

}  // namespace

void checkStart(const Scene& scene, Report& report) {
  for (std::size_t r = 0; r < scene.robots.size(); ++r) checkRobotStart(scene, r, report);
  const auto differs = [](const Pose& a, const Pose& b) {
    return translationBetween(a, b) > kObjectTolerance ||
           rotationBetween(a, b) > kObjectAngleTolerance;
  };
  for (const PlanObject& object : scene.plan.objects) {
    if (object.name == scene.plan.object) {
      if (object.attached_to) {
        report.violations.push_back({"",
                                     -1,
                                     0,
                                     "object_start",
                                     object.name + " is to be moved but attached to a robot",
                                     {object.name}});
      }
      if (differs(object.X_WO, scene.plan.X_WO_start)) {
        report.violations.push_back({"",
                                     -1,
                                     0,
                                     "object_start",
                                     object.name + " does not start at X_WO_start",
                                     {object.name}});
      }
    } else if (object.attached_to) {
      const int robot = scene.plan.findRobot(object.attached_to->robot);
      const auto at = static_cast<std::size_t>(robot);
      std::vector<Pose> X_WL;
      scene.kinematics[at].linkPoses(scene.q_start[at], X_WL);
      const int link = scene.robots[at].findLink(object.attached_to->link);
      if (differs(object.X_WO, X_WL[static_cast<std::size_t>(link)] * object.attached_to->X_LO)) {
        report.violations.push_back({"",
                                     -1,
                                     0,
                                     "object_start",
                                     object.name + " is not where the link that holds it has it",
                                     {object.name}});
      }
    }
  }
}

bool checkStructure(const Scene& scene, Report& report) {
  return StructureCheck(scene, report).run();
}

void checkClaims(const Scene& scene, const ContactRules& rules, Report& report) {
  for (int s = 0; s < kStages; ++s) {
    const PlanEvent& stage = scene.plan.stages[static_cast<std::size_t>(s)];
    for (const auto& [a, b] : stage.may_touch) {
      if (rules.mayTouch(s, true, a, b) || rules.standing(a, b)) continue;
      report.violations.push_back(
          {stage.kind,
           s,
           stage.start,
           "contact_smuggled",
           "may_touch claims " + a + " with " + b + ", which the stage does not allow",
           {a, b}});
    }
  }
}

}  // namespace handover::verify
