// SPDX-License-Identifier: Apache-2.0
#include "verify/checks.hpp"

#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <utility>

namespace handover::verify {
namespace {

constexpr double kPositionTolerance = 1e-6;  // [rad] or [m]
constexpr double kRateTolerance = 1e-3;      // of the limit
constexpr double kJoinTolerance = 1e-9;      // [rad] or [m]
constexpr double kRestTolerance = 1e-9;      // [rad/s] or [m/s]
constexpr double kPostureTolerance = 1e-6;   // [rad] or [m]

std::string text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.9g", value);
  return buffer;
}

/// The worst breach of one limit within a stage.
struct Worst {
  double excess = 0, value = 0, limit = 0, time = 0;

  void take(double over, double of, double allowed, double at) {
    if (over > excess) *this = {over, of, allowed, at};
  }
};

class TrajectoryCheck {
 public:
  TrajectoryCheck(const Scene& scene, Report& report) : scene_(scene), report_(report) {}

  void run() {
    std::map<std::pair<int, std::string>, double> stopped_at;
    // In the file's order, which is each robot's order in time.
    for (int s = 0; s < kStages; ++s) {
      const PlanEvent& stage = scene_.plan.stages[static_cast<std::size_t>(s)];
      const int robot = scene_.plan.findRobot(stage.robot);
      const auto at = static_cast<std::size_t>(robot);
      for (std::size_t c = 0; c < stage.joints.size(); ++c) {
        const std::string& name = stage.joints[c];
        const auto joint = static_cast<std::size_t>(scene_.robots[at].findJoint(name));
        const auto stopped = stopped_at.find({robot, name});
        const double from =
            stopped != stopped_at.end() ? stopped->second : scene_.q_start[at][joint];
        checkEnds(s, c, from);
        checkCurve(s, c, at, joint);
        stopped_at[{robot, name}] = stage.q.back()[c];
      }
      if (s == kGiverRetreat || s == kReceiverRetreat) checkPosture(s, at);
    }
  }

 private:
  void violation(int s, double time, const char* kind, const std::string& what) {
    const PlanEvent& stage = scene_.plan.stages[static_cast<std::size_t>(s)];
    report_.violations.push_back({stage.kind, s, time, kind, what, {}});
  }

  void checkEnds(int s, std::size_t c, double from) {
    const PlanEvent& stage = scene_.plan.stages[static_cast<std::size_t>(s)];
    const std::string& name = stage.joints[c];
    if (std::abs(stage.q.front()[c] - from) > kJoinTolerance) {
      violation(s, stage.start, "join",
                name + " starts at " + text(stage.q.front()[c]) + " but stood at " + text(from));
    }
    if (std::abs(stage.qd.front()[c]) > kRestTolerance) {
      violation(s, stage.start, "rest", name + " starts with " + text(stage.qd.front()[c]) + " /s");
    }
    if (std::abs(stage.qd.back()[c]) > kRestTolerance) {
      violation(s, stage.end(), "rest", name + " ends with " + text(stage.qd.back()[c]) + " /s");
    }
  }

  /// The joint itself and every joint that follows it.
  void checkCurve(int s, std::size_t c, std::size_t robot, std::size_t joint) {
    const Robot& model = scene_.robots[robot];
    for (std::size_t j = 0; j < model.joints.size(); ++j) {
      double multiplier = 1, offset = 0;
      std::size_t master = j;
      while (model.joints[master].mimic >= 0) {
        offset += multiplier * model.joints[master].offset;
        multiplier *= model.joints[master].multiplier;
        master = static_cast<std::size_t>(model.joints[master].mimic);
      }
      if (master == joint) {
        checkAgainstLimits(s, c, model.joints[j].name,
                           scene_.plan.robots[robot].limits.at(model.joints[j].name), multiplier,
                           offset);
      }
    }
  }

  void checkAgainstLimits(int s, std::size_t c, const std::string& name,
                          const ClaimedLimits& limits, double multiplier, double offset) {
    const PlanEvent& stage = scene_.plan.stages[static_cast<std::size_t>(s)];
    Worst position, velocity, acceleration;
    for (std::size_t k = 0; k + 1 < stage.t.size(); ++k) {
      const HermiteCubic cubic = cubicOf(stage, k, c);
      const double start = stage.start + stage.t[k];
      for (const double at : cubic.positionExtremes()) {
        const double q = multiplier * cubic.position(at) + offset;
        position.take(limits.lower - q - kPositionTolerance, q, limits.lower, start + at);
        position.take(q - limits.upper - kPositionTolerance, q, limits.upper, start + at);
      }
      for (const double at : cubic.velocityExtremes()) {
        const double qd = std::abs(multiplier * cubic.velocity(at));
        velocity.take(qd - limits.velocity * (1 + kRateTolerance), qd, limits.velocity, start + at);
      }
      for (const double at : cubic.accelerationExtremes()) {
        const double qdd = std::abs(multiplier * cubic.acceleration(at));
        acceleration.take(qdd - limits.acceleration * (1 + kRateTolerance), qdd,
                          limits.acceleration, start + at);
      }
    }
    const auto tell = [&](const Worst& worst, const char* kind) {
      if (worst.excess <= 0) return;
      violation(s, worst.time, kind,
                name + " reaches " + text(worst.value) + ", the limit is " + text(worst.limit));
    };
    tell(position, "position");
    tell(velocity, "velocity");
    tell(acceleration, "acceleration");
  }

  void checkPosture(int s, std::size_t robot) {
    const PlanEvent& stage = scene_.plan.stages[static_cast<std::size_t>(s)];
    for (std::size_t c = 0; c < stage.joints.size(); ++c) {
      const auto joint = static_cast<std::size_t>(scene_.robots[robot].findJoint(stage.joints[c]));
      const double home = scene_.q_start[robot][joint];
      if (std::abs(stage.q.back()[c] - home) > kPostureTolerance) {
        violation(s, stage.end(), "posture",
                  stage.joints[c] + " ends at " + text(stage.q.back()[c]) +
                      " instead of the start posture's " + text(home));
      }
    }
  }

  const Scene& scene_;
  Report& report_;
};

}  // namespace

void checkTrajectories(const Scene& scene, Report& report) { TrajectoryCheck(scene, report).run(); }

}  // namespace handover::verify
