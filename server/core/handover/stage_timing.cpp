// SPDX-License-Identifier: Apache-2.0
#include "core/handover/stage_timing.hpp"

#include "core/collision/joint_motion.hpp"
#include "core/motion/timing.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace handover {
namespace {

constexpr double kEarlyMotion = 0.005;  // a retreat's first part, where old contacts may last [m]
constexpr std::array<double, 3> kBlends{0.05, 0.01, 0.001};  // corner deviations tried [rad]

/// A timed path for the collision checks, its parameter the share of its duration.
class TimedMotion : public JointMotion {
 public:
  explicit TimedMotion(const TimedPath& path) : path_(path) {}

  void stretch(double from, double to, Eigen::VectorXd& q_middle,
               Eigen::VectorXd& stray) const override {
    const double t_from = from * path_.duration(), t_to = to * path_.duration();
    evaluate(path_, 0.5 * (t_from + t_to), q_middle, qd_);
    stray.setZero(q_middle.size());
    // A cubic stays within its control points: its ends and a third of the way along its end
    // slopes.
    double t = t_from;
    evaluate(path_, t, q_, qd_);
    auto next = static_cast<std::size_t>(std::upper_bound(path_.t.begin(), path_.t.end(), t) -
                                         path_.t.begin());
    for (bool last = false; !last; ++next) {
      last = next >= path_.t.size() || path_.t[next] >= t_to;
      if (last) {
        evaluate(path_, t_to, q_end_, qd_end_);
      } else {
        q_end_ = path_.q[next];
        qd_end_ = path_.qd[next];
      }
      const double t_end = last ? t_to : path_.t[next], third = (t_end - t) / 3;
      stray = stray.cwiseMax((q_ - q_middle).cwiseAbs())
                  .cwiseMax((q_ + third * qd_ - q_middle).cwiseAbs())
                  .cwiseMax((q_end_ - third * qd_end_ - q_middle).cwiseAbs())
                  .cwiseMax((q_end_ - q_middle).cwiseAbs());
      t = t_end;
      std::swap(q_, q_end_);
      std::swap(qd_, qd_end_);
    }
  }

 private:
  const TimedPath& path_;
  mutable Eigen::VectorXd q_, qd_, q_end_, qd_end_;
};

TimingLimits limitsOf(const StagePath& stage) {
  const auto size = static_cast<Eigen::Index>(stage.dofs.size());
  TimingLimits limits{Eigen::VectorXd(size), Eigen::VectorXd(size), Eigen::VectorXd(size),
                      Eigen::VectorXd(size)};
  const RobotModel& model = *stage.mover->model;
  for (Eigen::Index i = 0; i < size; ++i) {
    const int dof = stage.dofs[static_cast<std::size_t>(i)];
    const Joint& joint =
        model.joints[static_cast<std::size_t>(model.dof_joints[static_cast<std::size_t>(dof)])];
    limits.lower[i] = joint.lower;
    limits.upper[i] = joint.upper;
    limits.velocity[i] = joint.velocity;
    limits.acceleration[i] = joint.acceleration;
  }
  return limits;
}

/// Share of a retreat's duration in which its tool has moved less than kEarlyMotion.
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
      if ((tool(t) - p_start).norm() >= kEarlyMotion) return early / timed.duration();
      early = t;
    }
  }
  return 1;
}

/// A contact on the timed curve, if any.
std::optional<BodyContact> hitOnCurve(const CheckerFactory& checkers, const StagePath& stage,
                                      const TimedPath& timed) {
  const TimedMotion motion(timed);
  StateChecker checker = checkers.make(stage.state, *stage.mover, stage.dofs, stage.contacts);
  double from = 0;
  if (stage.early_contacts.giver_hand || stage.early_contacts.receiver_hand) {
    AllowedContacts early = stage.contacts;
    early.giver_hand |= stage.early_contacts.giver_hand;
    early.receiver_hand |= stage.early_contacts.receiver_hand;
    StateChecker early_checker = checkers.make(stage.state, *stage.mover, stage.dofs, early);
    from = earlyPart(stage, timed);
    if (auto hit = early_checker.hit(timed.q.front())) return hit;
    if (auto hit = early_checker.hitAlong(motion, 0, from)) return hit;
  } else if (auto hit = checker.hit(timed.q.front())) {
    return hit;
  }
  if (auto hit = checker.hit(timed.q.back())) return hit;
  return checker.hitAlong(motion, from, 1);
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

}  // namespace

std::variant<std::vector<StageTrajectory>, TimingFailure> timeStages(const HandoverProblem& problem,
                                                                     const CheckerFactory& checkers,
                                                                     const Exchange& exchange,
                                                                     std::uint32_t solution) {
  std::vector<StageTrajectory> trajectories;
  double clock = 0;
  for (const StagePath& stage : exchange.stages) {
    const TimingLimits limits = limitsOf(stage);
    std::optional<TimedPath> timed;
    std::string detail;
    for (const double blend : kBlends) {
      TimingSettings settings;
      settings.blend = blend;
      settings.speed_scale = problem.speed_scale;
      auto result = parameterize(stage.waypoints, limits, settings);
      if (!result) return TimingFailure{toString(stage.kind), result.error().detail};
      const auto hit = hitOnCurve(checkers, stage, *result);
      if (!hit) {
        timed = std::move(*result);
        break;
      }
      detail = problem.collision->name(hit->a) + " touches " + problem.collision->name(hit->b);
    }
    if (!timed) return TimingFailure{toString(stage.kind), detail};

    StageTrajectory trajectory;
    trajectory.solution = solution;
    trajectory.index = static_cast<std::uint32_t>(trajectories.size());
    trajectory.kind = stage.kind;
    trajectory.robot = stage.mover->robotName();
    const RobotModel& model = *stage.mover->model;
    for (const int dof : stage.dofs) {
      const auto joint = static_cast<std::size_t>(model.dof_joints[static_cast<std::size_t>(dof)]);
      trajectory.joints.push_back(model.joints[joint].name);
    }
    trajectory.start = clock;
    trajectory.t = timed->t;
    for (const auto& q : timed->q) trajectory.q.push_back(plain(q));
    for (const auto& qd : timed->qd) trajectory.qd.push_back(plain(qd));
    trajectory.holding = holdsOf(problem, stage, exchange);
    AllowedContacts contacts = stage.contacts;
    contacts.giver_hand |= stage.early_contacts.giver_hand;
    contacts.receiver_hand |= stage.early_contacts.receiver_hand;
    trajectory.may_touch = checkers.names(contacts);
    clock += timed->duration();
    trajectories.push_back(std::move(trajectory));
  }
  return trajectories;
}

}  // namespace handover
