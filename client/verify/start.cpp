// SPDX-License-Identifier: Apache-2.0
#include "verify/checks.hpp"

#include <cmath>
#include <cstdio>

namespace handover::verify {
namespace {

constexpr double kPositionTolerance = 1e-6;  // [rad] or [m]
constexpr double kMimicTolerance = 1e-6;     // [rad] or [m]
constexpr double kObjectTolerance = 1e-4;    // [m]
constexpr double kObjectAngleTolerance = 0.01 * M_PI / 180;
constexpr double kRounding = 1e-9;          // of limits that went through text
constexpr double kJerkOfAcceleration = 10;  // [1/s], where the robot's file says none

class StartCheck {
 public:
  StartCheck(const Scene& scene, Report& report) : scene_(scene), report_(report) {}

  void run() {
    for (std::size_t r = 0; r < scene_.robots.size(); ++r) robot(r);
    for (const PlanObject& entry : scene_.plan.objects) {
      if (entry.name == scene_.plan.object) {
        objectToMove(entry);
      } else if (entry.attached_to) {
        attached(entry);
      }
    }
  }

 private:
  void violation(const char* kind, const std::string& what, std::vector<std::string> bodies = {}) {
    report_.add({-1, 0, kind, what, std::move(bodies)});
  }

  void robot(std::size_t index) {
    const Robot& robot = scene_.robots[index];
    const PlanRobot& entry = scene_.plan.robots[index];
    std::vector<double> lawful = scene_.q_start[index];
    robot.followMimics(lawful);
    for (std::size_t j = 0; j < robot.joints.size(); ++j) {
      const Joint& joint = robot.joints[j];
      if (!joint.movable()) continue;
      const std::string name = entry.name + "/" + joint.name;
      const double q = scene_.q_start[index][j];
      // A follower goes where its master does; its own range narrows nothing.
      if (std::abs(q - lawful[j]) > kMimicTolerance) {
        violation("mimic", name + " starts at " + text(q) + ", its law says " + text(lawful[j]));
      }
      const auto claimed = entry.limits.find(joint.name);
      if (claimed == entry.limits.end()) continue;
      const ClaimedLimits& limits = claimed->second;
      if (joint.independent() && ((limits.lower && q < *limits.lower - kPositionTolerance) ||
                                  (limits.upper && q > *limits.upper + kPositionTolerance))) {
        violation("start", name + " starts at " + text(q) + ", outside its limits");
      }
      range(name, joint, scene_.settings[index].bounds[j], limits);
      rates(name, joint, scene_.settings[index].bounds[j], limits);
    }
  }

  void range(const std::string& name, const Joint& joint, const JointBounds& bounds,
             const ClaimedLimits& limits) {
    std::optional<double> lower = bounds.lower, upper = bounds.upper;
    if (joint.type != JointType::kContinuous) {
      lower = std::max(joint.lower, lower.value_or(joint.lower));
      upper = std::min(joint.upper, upper.value_or(joint.upper));
    }
    if (lower && (!limits.lower || *limits.lower < *lower - kRounding)) {
      violation("limits", name + " claims a lower limit below " + text(*lower));
    }
    if (upper && (!limits.upper || *limits.upper > *upper + kRounding)) {
      violation("limits", name + " claims an upper limit above " + text(*upper));
    }
  }

  void rates(const std::string& name, const Joint& joint, const JointBounds& bounds,
             const ClaimedLimits& limits) {
    const auto check = [&](const char* what, double claimed, std::optional<double> most) {
      if (!most || claimed <= *most * (1 + kRounding)) return;
      violation("limits",
                name + " claims " + what + " " + text(claimed) + ", its files say " + text(*most));
    };
    std::optional<double> velocity = bounds.velocity;
    if (joint.velocity > 0) velocity = joint.velocity;
    check("velocity", limits.velocity, velocity);
    check("acceleration", limits.acceleration, bounds.acceleration);
    check("jerk", limits.jerk,
          bounds.jerk.value_or(kJerkOfAcceleration *
                               bounds.acceleration.value_or(limits.acceleration)));
  }

  static bool differs(const Pose& a, const Pose& b) {
    return translationBetween(a, b) > kObjectTolerance ||
           rotationBetween(a, b) > kObjectAngleTolerance;
  }

  void objectToMove(const PlanObject& entry) {
    if (entry.attached_to) {
      violation("scene", entry.name + " is to be moved but attached to a robot", {entry.name});
    }
    if (!entry.resting.empty()) {
      violation("scene",
                entry.name +
                    " is to be moved; start and goal say what it rests on, not "
                    "its `resting`",
                {entry.name});
    }
    if (differs(entry.X_WO, scene_.plan.start.X_WO)) {
      violation("scene", entry.name + " is not where `start` has it", {entry.name});
    }
  }

  void attached(const PlanObject& entry) {
    const int robot = scene_.plan.findRobot(entry.attached_to->robot);
    const int link = scene_.robot(robot).findLink(entry.attached_to->link);
    const auto r = static_cast<std::size_t>(robot);
    const Pose X_WL = scene_.kinematics[r].linkPose(link, scene_.q_start[r]);
    if (differs(entry.X_WO, X_WL * entry.attached_to->X_LO)) {
      violation("scene", entry.name + " is not where the link that holds it has it", {entry.name});
    }
  }

  const Scene& scene_;
  Report& report_;
};

}  // namespace

std::string text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.9g", value);
  return buffer;
}

void checkStart(const Scene& scene, Report& report) { StartCheck(scene, report).run(); }

}  // namespace handover::verify
