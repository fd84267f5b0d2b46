// SPDX-License-Identifier: Apache-2.0
#include "verify/checks.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

namespace handover::verify {
namespace {

constexpr double kPositionTolerance = 1e-6;  // [rad] or [m]
constexpr double kRateTolerance = 1e-3;      // of velocity and acceleration limits
constexpr double kJerkTolerance = 1e-2;      // of the limit
constexpr double kStoppedTolerance = 1e-9;   // [rad] or [m]
constexpr double kJoinTolerance = 1e-6;      // of q, qd, qdd where an arm does not stop
constexpr double kPostureTolerance = 1e-6;   // [rad] or [m]
constexpr double kSearch = 1e-9;             // to which extremes are found

/// The worst breach of one limit within a stage.
struct Worst {
  double excess = 0, value = 0, limit = 0, time = 0;

  /// The greatest value of the polynomial, if it is above `allowed`.
  template <std::size_t N>
  void take(const Bernstein<N>& curve, double allowed, double named, double sign, double start) {
    const Peak peak = curve.greatest(kSearch, allowed);
    if (peak.value - allowed > excess) {
      *this = {peak.value - allowed, sign * peak.value, named, start + peak.at};
    }
  }

  /// |value| against a limit.
  template <std::size_t N>
  void takeBothSides(const Bernstein<N>& curve, double most, double tolerance, double start) {
    const double allowed = most * (1 + tolerance);
    if (curve.magnitude() <= allowed) return;
    take(curve, allowed, most, 1, start);
    take(curve.scaled(-1), allowed, most, -1, start);
  }
};

/// Where a joint was left by a stage.
struct Left {
  int stage = -1;
  JointSample at;
};

class TrajectoryCheck {
 public:
  TrajectoryCheck(const Motion& motion, Report& report)
      : motion_(motion), scene_(motion.scene()), report_(report) {}

  void run() {
    std::vector<int> by_start;
    for (int s = 0; s < scene_.stageCount(); ++s) by_start.push_back(s);
    std::stable_sort(by_start.begin(), by_start.end(),
                     [&](int a, int b) { return scene_.stage(a).start < scene_.stage(b).start; });
    for (const int s : by_start) {
      for (std::size_t c = 0; c < scene_.stage(s).joints.size(); ++c) {
        checkBeginning(s, c);
        checkCurve(s, c);
      }
    }
    for (const auto& [joint, left] : left_) checkStop(left, joint.second);
    for (int k = 0; k < scene_.holderCount(); ++k) checkHome(k);
  }

 private:
  void violation(int s, double time, const char* kind, const std::string& what) {
    report_.add({s, time, kind, what, {}});
  }

  static JointSample sample(const PlanStage& stage, std::size_t k, std::size_t c) {
    return {stage.q[k][c], stage.qd[k][c], stage.qdd[k][c]};
  }

  static bool still(const JointSample& at) { return at.qd == 0 && at.qdd == 0; }

  /// A joint goes on from where it stopped, or passes on without a stop.
  void checkBeginning(int s, std::size_t c) {
    const PlanStage& stage = scene_.stage(s);
    const int robot = scene_.stage_robot[static_cast<std::size_t>(s)];
    const int joint = scene_.stage_joints[static_cast<std::size_t>(s)][c];
    const JointSample first = sample(stage, 0, c);
    const auto found = left_.find({robot, joint});
    Left before;
    before.at.q = scene_.q_start[static_cast<std::size_t>(robot)][static_cast<std::size_t>(joint)];
    if (found != left_.end()) before = found->second;
    const std::string& name = stage.joints[c];
    if (still(first) && still(before.at)) {
      if (std::abs(first.q - before.at.q) > kStoppedTolerance) {
        violation(s, stage.start, "join",
                  name + " starts at " + text(first.q) + " but stood at " + text(before.at.q));
      }
    } else if (before.stage < 0 ||
               before.stage != motion_.task().previous[static_cast<std::size_t>(s)]) {
      violation(
          s, stage.start, "stop",
          name + " starts from rest with " + text(first.qd) + " /s, " + text(first.qdd) + " /s^2");
    } else {
      checkPassing(s, name, before, first);
    }
    left_[{robot, joint}] = {s, sample(stage, stage.t.size() - 1, c)};
  }

  void checkPassing(int s, const std::string& name, const Left& before, const JointSample& first) {
    const PlanStage& stage = scene_.stage(s);
    const double ended = scene_.stage(before.stage).end();
    if (std::abs(stage.start - ended) > kTimeTolerance) {
      violation(s, stage.start, "stop",
                name + " does not rest between " + scene_.stageName(before.stage) +
                    ", which ends at " + text(ended) + " s, and this stage");
      return;
    }
    if (std::abs(first.q - before.at.q) > kJoinTolerance ||
        std::abs(first.qd - before.at.qd) > kJoinTolerance ||
        std::abs(first.qdd - before.at.qdd) > kJoinTolerance) {
      violation(s, stage.start, "join",
                name + " goes on with " + text(first.q) + ", " + text(first.qd) + " /s, " +
                    text(first.qdd) + " /s^2 after " + text(before.at.q) + ", " +
                    text(before.at.qd) + ", " + text(before.at.qdd));
    }
  }

  /// The last thing that a joint does is to stop; so it does before a stage that leaves it out.
  void checkStop(const Left& left, int joint) {
    if (still(left.at)) return;
    const PlanStage& stage = scene_.stage(left.stage);
    violation(left.stage, stage.end(), "stop",
              scene_.robot(scene_.stage_robot[static_cast<std::size_t>(left.stage)])
                      .joints[static_cast<std::size_t>(joint)]
                      .name +
                  " comes to rest with " + text(left.at.qd) + " /s, " + text(left.at.qdd) +
                  " /s^2");
  }

  void checkCurve(int s, std::size_t c) {
    const PlanStage& stage = scene_.stage(s);
    const std::string& name = stage.joints[c];
    const int robot = scene_.stage_robot[static_cast<std::size_t>(s)];
    const ClaimedLimits& limits =
        scene_.plan.robots[static_cast<std::size_t>(robot)].limits.at(name);
    Worst position, velocity, acceleration, jerk;
    for (std::size_t k = 0; k + 1 < stage.t.size(); ++k) {
      const HermiteQuintic curve = curveOf(stage, k, c);
      const double start = stage.start + stage.t[k];
      const double first = curve.first();
      if (limits.upper) {
        position.take(curve.change().scaled(1, first), *limits.upper + kPositionTolerance,
                      *limits.upper, 1, start);
      }
      if (limits.lower) {
        position.take(curve.change().scaled(-1, -first), -*limits.lower + kPositionTolerance,
                      *limits.lower, -1, start);
      }
      const Bernstein<4> qd = curve.change().derivative();
      const Bernstein<3> qdd = qd.derivative();
      velocity.takeBothSides(qd, limits.velocity, kRateTolerance, start);
      acceleration.takeBothSides(qdd, limits.acceleration, kRateTolerance, start);
      jerk.takeBothSides(qdd.derivative(), limits.jerk, kJerkTolerance, start);
    }
    const auto tell = [&](const Worst& worst, const char* kind) {
      if (worst.excess <= 0) return;
      violation(s, worst.time, kind,
                name + " reaches " + text(worst.value) + ", the limit is " + text(worst.limit));
    };
    tell(position, "position");
    tell(velocity, "velocity");
    tell(acceleration, "acceleration");
    tell(jerk, "jerk");
  }

  void checkHome(int k) {
    const int s = motion_.task().of[static_cast<std::size_t>(k)].home;
    if (s < 0) return;
    const int robot = scene_.holder(k).robot;
    std::vector<double> q;
    motion_.jointsAt(robot, motion_.end(s), q);
    for (const int j : scene_.holder(k).arm_joints) {
      const auto joint = static_cast<std::size_t>(j);
      const double home = scene_.q_start[static_cast<std::size_t>(robot)][joint];
      if (std::abs(q[joint] - home) > kPostureTolerance) {
        violation(s, motion_.end(s), "home",
                  scene_.robot(robot).joints[joint].name + " ends at " + text(q[joint]) +
                      " instead of the start posture's " + text(home));
      }
    }
  }

  const Motion& motion_;
  const Scene& scene_;
  Report& report_;
  std::map<std::pair<int, int>, Left> left_;  ///< by robot and joint
};

}  // namespace

void checkTrajectories(const Motion& motion, Report& report) {
  TrajectoryCheck(motion, report).run();
}

double jerkShare(const Scene& scene) {
  double share = 0;
  for (int s = 0; s < scene.stageCount(); ++s) {
    const PlanStage& stage = scene.stage(s);
    const auto robot = static_cast<std::size_t>(scene.stage_robot[static_cast<std::size_t>(s)]);
    for (std::size_t c = 0; c < stage.joints.size(); ++c) {
      const double limit = scene.plan.robots[robot].limits.at(stage.joints[c]).jerk;
      if (limit <= 0) continue;
      for (std::size_t k = 0; k + 1 < stage.t.size(); ++k) {
        const Bernstein<2> jerk =
            curveOf(stage, k, c).change().derivative().derivative().derivative();
        if (jerk.magnitude() <= share * limit) continue;
        const double most = std::max(jerk.greatest(kSearch, share * limit).value,
                                     jerk.scaled(-1).greatest(kSearch, share * limit).value);
        share = std::max(share, most / limit);
      }
    }
  }
  return share;
}

}  // namespace handover::verify
