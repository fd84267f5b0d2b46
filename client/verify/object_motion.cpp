// SPDX-License-Identifier: Apache-2.0
#include "verify/advance.hpp"
#include "verify/checks.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

namespace handover::verify {
namespace {

constexpr double kJump = 1e-4;  // [m]
constexpr double kJumpAngle = 0.01 * M_PI / 180;
constexpr double kGoal = 1e-3;  // [m]
constexpr double kGoalAngle = 0.5 * M_PI / 180;
constexpr double kConstant = 1e-9;            // of X_LO, [m] and [rad]
constexpr double kStillFineness = 0.05;       // of the tolerance, between two looks
constexpr double kTiltTolerance = 0.01;       // [deg]
constexpr double kTiltFineness = 0.01;        // [deg], between two looks
constexpr double kDexterityTolerance = 1e-2;  // relative
constexpr double kDexterityZero = 1e-6;       // what rounding leaves of zero
constexpr double kDegree = M_PI / 180;

std::string difference(const Pose& X_WA, const Pose& X_WB) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, "%.4g mm and %.4g deg", translationBetween(X_WA, X_WB) * 1e3,
                rotationBetween(X_WA, X_WB) * 180 / M_PI);
  return buffer;
}

bool apart(const Pose& X_WA, const Pose& X_WB, double distance, double angle) {
  return translationBetween(X_WA, X_WB) > distance || rotationBetween(X_WA, X_WB) > angle;
}

class HoldingCheck {
 public:
  HoldingCheck(const Motion& motion, Report& report)
      : motion_(motion), scene_(motion.scene()), report_(report) {}

  void run() {
    for (int s = 0; s < scene_.stageCount(); ++s) stage(s);
  }

 private:
  void violation(int s, const std::string& what) {
    report_.add({s, motion_.start(s), "holding", what, {}});
  }

  void stage(int s) {
    std::vector<bool> lawful(scene_.stage(s).holding.size(), false);
    for (int k = 0; k < scene_.holderCount(); ++k) {
      const bool holds = motion_.holdBegins(k) <= motion_.start(s) + kTimeTolerance &&
                         motion_.start(s) < motion_.holdEnds(k) - kTimeTolerance;
      if (holds) heldBy(s, k, lawful);
    }
    for (const PlanObject& object : scene_.plan.objects) {
      if (object.attached_to && object.name != scene_.plan.object) attached(s, object, lawful);
    }
    for (std::size_t h = 0; h < lawful.size(); ++h) {
      if (lawful[h]) continue;
      const Hold& hold = scene_.stage(s).holding[h];
      violation(s, hold.robot + "/" + hold.link + " does not hold " + hold.object +
                       " as this stage begins");
    }
  }

  /// O hangs from a link that is rigid with the tool, as X_OT says.
  void heldBy(int s, int k, std::vector<bool>& lawful) {
    const Holder& holder = scene_.holder(k);
    const PlanHolder& entry = scene_.planHolder(k);
    const Robot& robot = scene_.robot(holder.robot);
    const std::vector<int> groups = robot.rigidGroups();
    for (std::size_t h = 0; h < lawful.size(); ++h) {
      const Hold& hold = scene_.stage(s).holding[h];
      const int link = hold.robot == entry.robot ? robot.findLink(hold.link) : -1;
      if (lawful[h] || hold.object != scene_.plan.object || link < 0 ||
          groups[static_cast<std::size_t>(link)] !=
              groups[static_cast<std::size_t>(holder.tool_link)]) {
        continue;
      }
      lawful[h] = true;
      const Pose X_LT = linkToTool(k, link);
      if (apart(hold.X_LO * entry.X_OT, X_LT, kJump, kJumpAngle)) {
        violation(s, "X_LO of " + entry.robot + " differs from X_OT by " +
                         difference(hold.X_LO * entry.X_OT, X_LT));
      }
      constant(s, k, hold);
      return;
    }
    violation(s, entry.robot + "/" + entry.arm +
                     " has the object as this stage begins, but `holding` does not say so");
  }

  Pose linkToTool(int k, int link) const {
    const Holder& holder = scene_.holder(k);
    const auto r = static_cast<std::size_t>(holder.robot);
    const Kinematics& kinematics = scene_.kinematics[r];
    return kinematics.linkPose(link, scene_.q_start[r]).inverse() *
           kinematics.linkPose(holder.tool_link, scene_.q_start[r]);
  }

  /// The first stage that names a hold says how it is to the end.
  void constant(int s, int k, const Hold& hold) {
    const auto index = static_cast<std::size_t>(k);
    if (first_.size() <= index) first_.resize(index + 1, nullptr);
    if (!first_[index]) first_[index] = &hold;
    if (hold.link != first_[index]->link ||
        apart(hold.X_LO, first_[index]->X_LO, kConstant, kConstant)) {
      violation(s, "the object's place in the hand of " + hold.robot + " is not what it was");
    }
  }

  void attached(int s, const PlanObject& object, std::vector<bool>& lawful) {
    const Attachment& attachment = *object.attached_to;
    for (std::size_t h = 0; h < lawful.size(); ++h) {
      const Hold& hold = scene_.stage(s).holding[h];
      if (lawful[h] || hold.object != object.name || hold.robot != attachment.robot) continue;
      lawful[h] = true;
      if (hold.link != attachment.link || apart(hold.X_LO, attachment.X_LO, kConstant, kConstant)) {
        violation(s, "the hold of " + object.name + " differs from attached_to");
      }
      return;
    }
    violation(s, attachment.robot + " holds " + object.name + ", but `holding` does not say so");
  }

  const Motion& motion_;
  const Scene& scene_;
  Report& report_;
  std::vector<const Hold*> first_;  ///< per holder
};

class StateCheck {
 public:
  StateCheck(const Motion& motion, Report& report)
      : motion_(motion), scene_(motion.scene()), report_(report) {}

  void run() {
    const Task& task = motion_.task();
    const int first = task.of.front().grasp;
    const double taken = motion_.holdBegins(0);
    compare(first, taken, motion_.objectBy(0, taken), scene_.plan.start.X_WO,
            "the first hand takes the object away from its start by ");
    if (first >= 0) restsStand(scene_.plan.start.rest, 0, taken);
    for (int k = 0; k < task.last(); ++k) handover(k);
    goal();
  }

 private:
  void violation(int s, double time, const std::string& what) {
    report_.add({s, time, "state", what, {scene_.plan.object}});
  }

  bool compare(int s, double time, const Pose& X_WO, const Pose& X_WO_wanted,
               const std::string& what) {
    if (!apart(X_WO, X_WO_wanted, kJump, kJumpAngle)) return true;
    violation(s, time, what + difference(X_WO, X_WO_wanted));
    return false;
  }

  /// Both hands have O at the handover pose, and it stays there until the first has let go.
  void handover(int k) {
    const HolderStages& gives = motion_.task().of[static_cast<std::size_t>(k)];
    const HolderStages& takes = motion_.task().of[static_cast<std::size_t>(k) + 1];
    const double from = motion_.start(takes.grasp), taken = motion_.end(takes.grasp),
                 to = motion_.end(gives.release);
    const Pose& X_WO = scene_.plan.handovers[static_cast<std::size_t>(k)];
    const std::string name = "handover " + std::to_string(k);
    if (!compare(takes.grasp, from, motion_.objectBy(k, from), X_WO,
                 "the object is away from " + name + " by ")) {
      return;
    }
    compare(takes.grasp, taken, motion_.objectBy(k + 1, taken), X_WO,
            "the hand that takes has the object away from " + name + " by ");
    standsStill(k, from, to, gives.carry, "the hand that gives moves the object in " + name);
    standsStill(k + 1, taken, to, takes.grasp, "the hand that takes moves the object in " + name);
  }

  /// O as the holder has it does not leave its pose at `from`.
  void standsStill(int k, double from, double to, int stage, const std::string& what) {
    if (!(to > from)) return;
    const Holder& holder = scene_.holder(k);
    const Pose X_WO = motion_.objectBy(k, from);
    const Eigen::Vector3d p_TO = scene_.planHolder(k).X_OT.inverse().translation();
    // One number for both: 1 is the tolerance.
    const auto away = [&](double T) {
      const Pose now = motion_.objectBy(k, T);
      return std::max(translationBetween(now, X_WO) / kJump,
                      rotationBetween(now, X_WO) / kJumpAngle);
    };
    const auto rate = [&](double a, double b) {
      const Rates rates = motion_.ratesOf(holder.robot, holder.tool_link, p_TO, a, b);
      return std::max(rates.point / kJump, rates.turn / kJumpAngle);
    };
    const auto found =
        firstAbove(motion_.cutsOf(holder.robot, from, to), away, rate, 1.0, kStillFineness);
    if (found) violation(stage, *found, what);
  }

  void goal() {
    const int last = motion_.task().last();
    const HolderStages& stages = motion_.task().of[static_cast<std::size_t>(last)];
    const double placed =
        motion_.task().ends_held ? motion_.end(stages.carry) : motion_.end(stages.place);
    const int stage = motion_.task().ends_held ? stages.carry : stages.place;
    const double let_go = motion_.task().ends_held ? motion_.end() : motion_.holdEnds(last);
    const Pose X_WO = motion_.objectBy(last, let_go);
    if (apart(X_WO, scene_.plan.goal.X_WO, kGoal, kGoalAngle)) {
      violation(stage, let_go,
                "the object ends away from the goal by " + difference(X_WO, scene_.plan.goal.X_WO));
    }
    standsStill(last, placed, let_go, stage, "the object is moved at the goal");
    if (!motion_.task().ends_held) restsStand(scene_.plan.goal.rest, placed, motion_.end());
  }

  /// What O lies on does not go away under it.
  void restsStand(const Rest& rest, double from, double to) {
    if (!rest || !(to > from)) return;
    for (const std::string& name : *rest) {
      const int object = scene_.plan.findObject(name);
      const auto& attached = scene_.planObject(object).attached_to;
      if (!attached) continue;
      const Pose X_WS = motion_.otherObjectAt(object, from);
      const int robot = scene_.plan.findRobot(attached->robot);
      for (const double T : motion_.cutsOf(robot, from, to)) {
        if (!apart(motion_.otherObjectAt(object, T), X_WS, kJump, kJumpAngle)) continue;
        violation(-1, T, name + " moves with the object on it");
        break;
      }
    }
  }

  const Motion& motion_;
  const Scene& scene_;
  Report& report_;
};

/// Angle between O's axis and world z [deg].
double tiltOf(const Pose& X_WO, const Eigen::Vector3d& axis) {
  const Eigen::Vector3d z = X_WO.linear() * axis;
  return std::atan2(z.head<2>().norm(), z.z()) / kDegree;
}

}  // namespace

void checkHolding(const Motion& motion, Report& report) { HoldingCheck(motion, report).run(); }

void checkState(const Motion& motion, Report& report) { StateCheck(motion, report).run(); }

double checkUpright(const Motion& motion, Report& report) {
  const Scene& scene = motion.scene();
  const auto& rule = scene.plan.upright;
  const Eigen::Vector3d axis = rule ? rule->axis : Eigen::Vector3d::UnitZ();
  const double lawful =
      std::max(tiltOf(scene.plan.start.X_WO, axis), tiltOf(scene.plan.goal.X_WO, axis));
  double most = 0;
  for (int k = 0; k <= motion.task().last(); ++k) {
    const int robot = scene.holder(k).robot;
    const double from = motion.holdBegins(k);
    const double to = std::min(motion.end(), motion.holdEnds(k));
    if (!(to > from)) continue;
    const std::vector<double> cuts = motion.cutsOf(robot, from, to);
    const auto tilt = [&](double T) { return tiltOf(motion.objectBy(k, T), axis) - lawful; };
    const auto rate = [&](double a, double b) {
      return motion.ratesOf(robot, scene.holder(k).tool_link, {0, 0, 0}, a, b).turn / kDegree;
    };
    most = std::max(most, greatest(cuts, tilt, rate, kTiltFineness));
    if (!rule) continue;
    const auto found =
        firstAbove(cuts, tilt, rate, rule->within_deg + kTiltTolerance, kTiltFineness);
    if (!found) continue;
    int stage = motion.task().of[static_cast<std::size_t>(k)].carry;
    for (int s = 0; s < scene.stageCount(); ++s) {
      if (scene.stage(s).holder == k && motion.start(s) <= *found && *found <= motion.end(s)) {
        stage = s;
      }
    }
    report.add(
        {stage,
         *found,
         "upright",
         "the object leans more than " + text(rule->within_deg) + " deg beyond its start and goal",
         {scene.plan.object}});
  }
  return most;
}

double takeTime(const Motion& motion, int holder) {
  const int grasp = motion.task().of[static_cast<std::size_t>(holder)].grasp;
  return grasp < 0 ? 0 : motion.start(grasp);
}

double giveTime(const Motion& motion, int holder) {
  const HolderStages& stages = motion.task().of[static_cast<std::size_t>(holder)];
  return stages.release < 0 ? motion.end(stages.carry) : motion.start(stages.release);
}

namespace {

double dexterityAt(const Motion& motion, int holder, double T) {
  const Scene& scene = motion.scene();
  const int robot = scene.holder(holder).robot;
  const int carry = motion.task().of[static_cast<std::size_t>(holder)].carry;
  std::vector<double> q;
  motion.jointsAt(robot, T, q);
  return scene.kinematics[static_cast<std::size_t>(robot)].manipulability(
      scene.holder(holder).tool_link, scene.stage_joints[static_cast<std::size_t>(carry)], q);
}

}  // namespace

double dexterityAtTake(const Motion& motion, int holder) {
  return dexterityAt(motion, holder, takeTime(motion, holder));
}

double dexterityAtGive(const Motion& motion, int holder) {
  return dexterityAt(motion, holder, giveTime(motion, holder));
}

void checkDexterity(const Motion& motion, Report& report) {
  const Scene& scene = motion.scene();
  const auto check = [&](int k, const char* name, double claimed, double computed, double time) {
    if (std::abs(computed - claimed) <=
        kDexterityTolerance * std::max(std::abs(computed), std::abs(claimed)) + kDexterityZero) {
      return;
    }
    report.add({motion.task().of[static_cast<std::size_t>(k)].carry,
                time,
                "dexterity",
                std::string(name) + " of holder " + std::to_string(k) + " is given as " +
                    text(claimed) + ", the posture has " + text(computed),
                {}});
  };
  for (int k = 0; k < scene.holderCount(); ++k) {
    check(k, "take", scene.planHolder(k).take, dexterityAtTake(motion, k), takeTime(motion, k));
    check(k, "give", scene.planHolder(k).give, dexterityAtGive(motion, k), giveTime(motion, k));
  }
}

}  // namespace handover::verify
