// SPDX-License-Identifier: Apache-2.0
#include "verify/checks.hpp"

#include <algorithm>
#include <string>
#include <vector>

namespace handover::verify {
namespace {

constexpr double kUp = 1e-3;    // [m] by which O is raised
constexpr double kDown = 2e-3;  // [m] by which it is lowered
constexpr double kNear = 1e-2;  // [m]

class RestCheck {
 public:
  RestCheck(const Motion& motion, Report& report)
      : motion_(motion), scene_(motion.scene()), report_(report) {}

  void start(const std::set<int>& rests) {
    const PlanStart& start = scene_.plan.start;
    if (start.held_by) {
      empty(start.rest, "start", "starts");
    } else {
      stands("start", start.X_WO, 0, !start.rest, rests);
    }
  }

  void goal(const std::set<int>& rests) {
    const PlanGoal& goal = scene_.plan.goal;
    if (!goal.release) {
      empty(goal.rest, "goal", "ends");
    } else {
      stands("goal", goal.X_WO, motion_.end(), !goal.rest, rests);
    }
  }

 private:
  void violation(double T, const std::string& what, std::vector<std::string> bodies = {}) {
    report_.add({-1, T, "rest", what, std::move(bodies)});
  }

  void empty(const Rest& rest, const std::string& where, const std::string& does) {
    if (rest && rest->empty()) return;
    violation(0,
              "`rest` of the " + where + " is not empty though the object " + does + " in a hand");
  }

  static Pose moved(Pose X_WO, double up) {
    X_WO.translation().z() += up;
    return X_WO;
  }

  void stands(const std::string& where, const Pose& X_WO, double T, bool none,
              const std::set<int>& rests) {
    const Body& object = scene_.body(scene_.object_body).body;
    const std::string& name = scene_.plan.object;
    bool supported = none;
    for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
      const SceneBody& other = scene_.bodies[b];
      if (static_cast<int>(b) == scene_.object_body) continue;
      const Pose X_WS = motion_.bodyAt(static_cast<int>(b), T);
      if (clearance(object, moved(X_WO, kUp), other.body, X_WS, kNear).touching &&
          !(none && shallow(object, X_WO, other.body, X_WS))) {
        violation(T, name + " is more than 1 mm deep in " + other.name + " at the " + where,
                  {name, other.name});
      }
      if (other.object >= 0 && rests.count(other.object) &&
          clearance(object, moved(X_WO, -kDown), other.body, X_WS, kNear).touching) {
        supported = true;
      }
    }
    if (!supported)
      violation(T, name + " rests on nothing that `rest` names at the " + where, {name});
  }

  /// For what holds O from above or from the side, raising says nothing: the depth as it is.
  static bool shallow(const Body& object, const Pose& X_WO, const Body& other, const Pose& X_WS) {
    return !clearance(object, X_WO, other, X_WS, kNear).touching ||
           depthAtLeast(object, X_WO, other, X_WS, kRestDepth) <= kRestDepth;
  }

  const Motion& motion_;
  const Scene& scene_;
  Report& report_;
};

}  // namespace

void checkRests(const Motion& motion, const std::set<int>& start_rests,
                const std::set<int>& goal_rests, Report& report) {
  RestCheck check(motion, report);
  check.start(start_rests);
  check.goal(goal_rests);
}

}  // namespace handover::verify
