// SPDX-License-Identifier: Apache-2.0
#include "verify/checks.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

namespace handover::verify {
namespace {

constexpr double kJump = 1e-4;  // [m]
constexpr double kJumpAngle = 0.01 * M_PI / 180;
constexpr double kGoal = 1e-3;  // [m]
constexpr double kGoalAngle = 0.5 * M_PI / 180;
constexpr double kConstant = 1e-9;            // of X_LO, [m] and [rad]
constexpr double kDexterityTolerance = 1e-6;  // relative
constexpr int kStandstillSamples = 50;

std::string difference(const Pose& X_WA, const Pose& X_WB) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, "%.4g mm and %.4g deg", translationBetween(X_WA, X_WB) * 1e3,
                rotationBetween(X_WA, X_WB) * 180 / M_PI);
  return buffer;
}

bool apart(const Pose& X_WA, const Pose& X_WB, double distance, double angle) {
  return translationBetween(X_WA, X_WB) > distance || rotationBetween(X_WA, X_WB) > angle;
}

class HoldCheck {
 public:
  HoldCheck(const Scene& scene, Report& report) : scene_(scene), report_(report) {}

  bool run() {
    bool sound = true;
    for (int s = 0; s < kStages; ++s) {
      if (giverHolds(s)) sound = holdsObject(s, scene_.giver, giver_) && sound;
      if (receiverHolds(s)) sound = holdsObject(s, scene_.receiver, receiver_) && sound;
      attachments(s);
      nothingElse(s);
    }
    if (!sound) return false;
    consistent(scene_.giver, *giver_, scene_.plan.X_OT_giver, kGiverLift);
    consistent(scene_.receiver, *receiver_, scene_.plan.X_OT_receiver, kGiverRelease);
    return true;
  }

 private:
  const PlanEvent& stage(int s) const { return scene_.plan.stages[static_cast<std::size_t>(s)]; }

  const Hold* find(int s, const std::string& object, const std::string& robot) const {
    for (const Hold& hold : stage(s).holding) {
      if (hold.object == object && hold.robot == robot) return &hold;
    }
    return nullptr;
  }

  void violation(int s, const std::string& what) {
    report_.violations.push_back({stage(s).kind, s, stage(s).start, "holding", what, {}});
  }

  /// O is held by a link that is rigid with the tool, always in the same way.
  bool holdsObject(int s, const Party& party, std::optional<Hold>& held) {
    const std::string& robot = scene_.plan.robots[static_cast<std::size_t>(party.robot)].name;
    const Hold* hold = find(s, scene_.plan.object, robot);
    if (!hold) {
      violation(s, robot + " holds the object in this stage, but `holding` does not say so");
      return false;
    }
    const Robot& model = scene_.robots[static_cast<std::size_t>(party.robot)];
    const std::vector<int> groups = model.rigidGroups();
    if (groups[static_cast<std::size_t>(model.findLink(hold->link))] !=
        groups[static_cast<std::size_t>(party.arm.tool_link)]) {
      violation(s, robot + "/" + hold->link + " is not rigid with the tool link");
      return false;
    }
    if (!held) held = *hold;
    if (hold->link != held->link || apart(hold->X_LO, held->X_LO, kConstant, kConstant)) {
      violation(s, "the object's place in the hand of " + robot + " differs from the stage before");
    }
    return true;
  }

  void attachments(int s) {
    for (const PlanObject& object : scene_.plan.objects) {
      if (!object.attached_to || object.name == scene_.plan.object) continue;
      const Attachment& attached = *object.attached_to;
      const Hold* hold = find(s, object.name, attached.robot);
      if (!hold) {
        violation(s, attached.robot + " holds " + object.name + ", but `holding` does not say so");
      } else if (hold->link != attached.link ||
                 apart(hold->X_LO, attached.X_LO, kConstant, kConstant)) {
        violation(s, "the hold of " + object.name + " differs from attached_to");
      }
    }
  }

  void nothingElse(int s) {
    for (std::size_t h = 0; h < stage(s).holding.size(); ++h) {
      const Hold& hold = stage(s).holding[h];
      const auto& plan = scene_.plan;
      const auto& object = plan.objects[static_cast<std::size_t>(plan.findObject(hold.object))];
      bool lawful = false;
      if (hold.object == plan.object) {
        lawful = (hold.robot == plan.giver && giverHolds(s)) ||
                 (hold.robot == plan.receiver && receiverHolds(s));
      } else {
        lawful = object.attached_to && object.attached_to->robot == hold.robot;
      }
      if (!lawful) violation(s, hold.robot + " does not hold " + hold.object + " in this stage");
      for (std::size_t other = 0; other < h; ++other) {
        if (stage(s).holding[other].object == hold.object &&
            stage(s).holding[other].robot == hold.robot) {
          violation(s, hold.robot + " is said to hold " + hold.object + " twice");
        }
      }
    }
  }

  /// X_LO and X_OT are two ways of saying how the hand has O.
  void consistent(const Party& party, const Hold& hold, const Pose& X_OT, int s) {
    const auto robot = static_cast<std::size_t>(party.robot);
    std::vector<Pose> X_WL;
    scene_.kinematics[robot].linkPoses(scene_.q_start[robot], X_WL);
    const auto link = static_cast<std::size_t>(scene_.robots[robot].findLink(hold.link));
    const Pose X_LT = X_WL[link].inverse() * X_WL[static_cast<std::size_t>(party.arm.tool_link)];
    const Pose X_LT_claimed = hold.X_LO * X_OT;
    if (apart(X_LT, X_LT_claimed, kJump, kJumpAngle)) {
      violation(s,
                "X_LO and X_OT of " + hold.robot + " differ by " + difference(X_LT, X_LT_claimed));
    }
  }

  const Scene& scene_;
  Report& report_;
  std::optional<Hold> giver_, receiver_;
};

class ObjectCheck {
 public:
  ObjectCheck(const Motion& motion, Report& report) : motion_(motion), report_(report) {}

  void run() {
    const Plan& plan = motion_.scene().plan;
    const double lifted = motion_.stage(kGiverLift).start;
    compare(kGiverLift, lifted, motion_.objectByGiver(lifted), plan.X_WO_start, "object_jump",
            "the giver's hand has the object away from X_WO_start by ");

    standstill(kReceiverGrasp);
    standstill(kGiverRelease);

    const PlanEvent& place = motion_.stage(kReceiverPlace);
    const Pose X_WO_end = motion_.objectByReceiver(place.end());
    if (apart(X_WO_end, plan.X_WO_goal, kGoal, kGoalAngle)) {
      add(kReceiverPlace, place.end(), "goal",
          "the object ends away from the goal by " + difference(X_WO_end, plan.X_WO_goal));
    }
    // What is let go stays where it is only if nothing that it lies on moves away under it; that
    // nothing touches it is a matter of collisions.
    for (const std::string& rest : goalRests(motion_)) restStands(rest, place.end());
  }

 private:
  void add(int s, double time, const char* kind, const std::string& what) {
    report_.violations.push_back(
        {stageName(s), s, time, kind, what, {motion_.scene().plan.object}});
  }

  void compare(int s, double time, const Pose& X_WO, const Pose& X_WO_wanted, const char* kind,
               const std::string& what) {
    if (apart(X_WO, X_WO_wanted, kJump, kJumpAngle)) {
      add(s, time, kind, what + difference(X_WO, X_WO_wanted));
    }
  }

  /// At X_WO_handover throughout the stage, for both hands.
  void standstill(int s) {
    const PlanEvent& stage = motion_.stage(s);
    const Pose& X_WO_handover = motion_.scene().plan.X_WO_handover;
    for (int k = 0; k <= kStandstillSamples; ++k) {
      const double time = stage.start + (stage.end() - stage.start) * k / kStandstillSamples;
      const std::size_t before = report_.violations.size();
      compare(s, time, motion_.objectByGiver(time), X_WO_handover, "handover",
              "the giver's hand has the object away from X_WO_handover by ");
      compare(s, time, motion_.objectByReceiver(time), X_WO_handover, "handover",
              "the receiver's hand has the object away from X_WO_handover by ");
      if (report_.violations.size() != before) return;  // once per stage is enough
    }
  }

  void restStands(const std::string& rest, double placed) {
    const Plan& plan = motion_.scene().plan;
    const int index = plan.findObject(rest);
    const Pose X_WS = motion_.otherObjectAt(index, placed);
    for (int s = 0; s < kStages; ++s) {
      const double end = motion_.stage(s).end();
      if (end <= placed) continue;
      if (apart(motion_.otherObjectAt(index, end), X_WS, kJump, kJumpAngle)) {
        add(s, end, "object_moved", rest + " moves with the object on it");
        return;
      }
    }
  }

  const Motion& motion_;
  Report& report_;
};

}  // namespace

bool checkHolds(const Scene& scene, Report& report) { return HoldCheck(scene, report).run(); }

void checkObjectMotion(const Motion& motion, Report& report) { ObjectCheck(motion, report).run(); }

void checkDexterity(const Motion& motion, Report& report) {
  const Scene& scene = motion.scene();
  const auto check = [&](const char* name, double claimed, const Party& party, int s) {
    const double time = motion.stage(s).end();
    const double computed = scene.kinematics[static_cast<std::size_t>(party.robot)].manipulability(
        party.arm, motion.jointsAt(party.robot, time));
    // An arm with joints to spare in a plane has none at all, but for rounding.
    constexpr double kZero = 1e-7;  // the square root of what rounding leaves of zero
    if (std::abs(computed - claimed) >
        kDexterityTolerance * std::max(std::abs(computed), std::abs(claimed)) + kZero) {
      char what[128];
      std::snprintf(what, sizeof what, "%s is given as %.9g, the configuration has %.9g", name,
                    claimed, computed);
      report.violations.push_back({stageName(s), s, time, "dexterity", what, {}});
    }
  };
  check("giver_pick", scene.plan.giver_pick, scene.giver, kGiverApproach);
  check("giver_handover", scene.plan.giver_handover, scene.giver, kGiverTransfer);
  check("receiver_handover", scene.plan.receiver_handover, scene.receiver, kReceiverApproach);
  check("receiver_place", scene.plan.receiver_place, scene.receiver, kReceiverPlace);
}

}  // namespace handover::verify
