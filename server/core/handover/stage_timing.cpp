// SPDX-License-Identifier: Apache-2.0
#include "core/handover/stage_timing.hpp"

#include "core/handover/overlap.hpp"
#include "core/handover/timed_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace handover {
namespace {

constexpr double kEarlyMotion = 0.005;  // a retreat's first part, where old contacts may last [m]
constexpr std::array<double, 3> kBlends{0.05, 0.01, 0.001};  // corner deviations tried [rad]

TimingLimits limitsOf(const StagePath& stage) {
  const auto size = static_cast<Eigen::Index>(stage.dofs.size());
  TimingLimits limits;
  for (Eigen::VectorXd* it :
       {&limits.lower, &limits.upper, &limits.velocity, &limits.acceleration, &limits.jerk}) {
    it->resize(size);
  }
  const RobotModel& model = *stage.mover->model;
  for (Eigen::Index i = 0; i < size; ++i) {
    const int dof = stage.dofs[static_cast<std::size_t>(i)];
    const Joint& joint =
        model.joints[static_cast<std::size_t>(model.dof_joints[static_cast<std::size_t>(dof)])];
    limits.lower[i] = joint.lower;
    limits.upper[i] = joint.upper;
    limits.velocity[i] = joint.velocity;
    limits.acceleration[i] = joint.acceleration;
    limits.jerk[i] = joint.jerk;
  }
  return limits;
}

/// [s] of a retreat in which its tool has moved less than kEarlyMotion.
double earlyPart(const StagePath& stage, const TimedPath& timed) {
  constexpr int kParts = 8;  // looks from one sample to the next
  const Role& role = *stage.mover;
  const auto tool = [&](double t) -> Eigen::Vector3d {
    return role.kinematics->toolPose(evaluate(timed, t).head(role.kinematics->dofs()))
        .translation();
  };
  const Eigen::Vector3d p_start = tool(0);
  double early = 0;
  for (std::size_t i = 1; i < timed.t.size(); ++i) {
    for (int part = 1; part <= kParts; ++part) {
      const double t = timed.t[i - 1] + (timed.t[i] - timed.t[i - 1]) * part / kParts;
      if ((tool(t) - p_start).norm() >= kEarlyMotion) return early;
      early = t;
    }
  }
  return timed.duration();
}

bool hasEarlyContacts(const StagePath& stage) {
  return stage.early_contacts.giver_hand || stage.early_contacts.receiver_hand;
}

/// Those of its first part too.
AllowedContacts allContacts(const StagePath& stage) {
  AllowedContacts contacts = stage.contacts;
  contacts.giver_hand |= stage.early_contacts.giver_hand;
  contacts.receiver_hand |= stage.early_contacts.receiver_hand;
  return contacts;
}

/// A contact on the timed curve, if any.
std::optional<BodyContact> hitOnCurve(const CheckerFactory& checkers, const StagePath& stage,
                                      const TimedPath& timed, double early_part) {
  const TimedMotion motion(timed);
  StateChecker checker = checkers.make(stage.state, *stage.mover, stage.dofs, stage.contacts);
  double from = 0;
  if (early_part > 0) {
    StateChecker early_checker =
        checkers.make(stage.state, *stage.mover, stage.dofs, allContacts(stage));
    from = early_part / timed.duration();
    if (auto hit = early_checker.hit(timed.q.front())) return hit;
    if (auto hit = early_checker.hitAlong(motion, 0, from, kTimedClearance)) return hit;
  } else if (auto hit = checker.hit(timed.q.front())) {
    return hit;
  }
  if (auto hit = checker.hit(timed.q.back())) return hit;
  return checker.hitAlong(motion, from, 1, kTimedClearance);
}

std::vector<Hold> holdsOf(const HandoverProblem& problem, const StagePath& stage,
                          const Exchange& exchange) {
  std::vector<Hold> holds;
  for (const Role* role : stage.holders) {
    const bool giver = role->robotName() == problem.task.giver;
    const int grasp = giver ? exchange.giver_grasp : exchange.receiver_grasp;
    const Pose X_TO = role->grasps->grasps[static_cast<std::size_t>(grasp)].X_OT.inverse();
    holds.push_back({problem.task.object, role->robotName(), role->toolLink(), toValue(X_TO)});
  }
  for (const SceneObject& object : problem.scene->objects) {
    if (!object.attached_to) continue;
    const SceneRobot& robot =
        problem.scene->robots[static_cast<std::size_t>(object.attached_to->robot)];
    holds.push_back({object.name, robot.name,
                     robot.model->links[static_cast<std::size_t>(object.attached_to->link)].name,
                     toValue(object.attached_to->X_LO)});
  }
  return holds;
}

std::vector<double> plain(const Eigen::VectorXd& values) {
  std::vector<double> numbers(values.begin(), values.end());
  for (double& number : numbers) number += 0.0;  // no -0.0
  return numbers;
}

std::variant<TimedStage, TimingFailure> timeStage(const HandoverProblem& problem,
                                                  const CheckerFactory& checkers,
                                                  const StagePath& stage) {
  const TimingLimits limits = limitsOf(stage);
  std::string detail;
  for (const double blend : kBlends) {
    TimingSettings settings;
    settings.blend = blend;
    settings.speed_scale = problem.speed_scale;
    auto timed = parameterize(stage.waypoints, limits, settings);
    if (!timed) return TimingFailure{toString(stage.kind), timed.error().detail};
    const double early = hasEarlyContacts(stage) ? earlyPart(stage, *timed) : 0;
    const auto hit = hitOnCurve(checkers, stage, *timed, early);
    if (!hit) return TimedStage{&stage, std::move(*timed), early};
    detail = problem.collision->name(hit->a) + " touches " + problem.collision->name(hit->b);
  }
  return TimingFailure{toString(stage.kind), detail};
}

StageTrajectory trajectoryOf(const HandoverProblem& problem, const CheckerFactory& checkers,
                             const Exchange& exchange, const TimedStage& timed) {
  const StagePath& stage = *timed.stage;
  StageTrajectory trajectory;
  trajectory.kind = stage.kind;
  trajectory.robot = stage.mover->robotName();
  const RobotModel& model = *stage.mover->model;
  for (const int dof : stage.dofs) {
    const auto joint = static_cast<std::size_t>(model.dof_joints[static_cast<std::size_t>(dof)]);
    trajectory.joints.push_back(model.joints[joint].name);
  }
  trajectory.t = timed.path.t;
  for (const auto& q : timed.path.q) trajectory.q.push_back(plain(q));
  for (const auto& qd : timed.path.qd) trajectory.qd.push_back(plain(qd));
  trajectory.holding = holdsOf(problem, stage, exchange);
  trajectory.may_touch = checkers.names(allContacts(stage));
  return trajectory;
}

}  // namespace

std::variant<std::vector<StageTrajectory>, TimingFailure> timeStages(const HandoverProblem& problem,
                                                                     const CheckerFactory& checkers,
                                                                     const Exchange& exchange,
                                                                     std::uint32_t solution) {
  std::vector<TimedStage> timed;
  for (const StagePath& stage : exchange.stages) {
    auto result = timeStage(problem, checkers, stage);
    if (const auto* failure = std::get_if<TimingFailure>(&result)) return *failure;
    timed.push_back(std::get<TimedStage>(std::move(result)));
  }
  const std::vector<double> starts = startTimes(checkers, timed);
  std::vector<StageTrajectory> trajectories;
  for (std::size_t i = 0; i < timed.size(); ++i) {
    trajectories.push_back(trajectoryOf(problem, checkers, exchange, timed[i]));
    trajectories.back().solution = solution;
    trajectories.back().index = static_cast<std::uint32_t>(i);
    trajectories.back().start = starts[i];
  }
  return trajectories;
}

}  // namespace handover
