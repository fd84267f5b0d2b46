// SPDX-License-Identifier: Apache-2.0
#include "core/handover/stage_timing.hpp"

#include "core/motion/timing.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace handover {
namespace {

constexpr double kTravel = 0.004;       // between tested points of a curve [m]
constexpr double kEarlyMotion = 0.005;  // a retreat's first part, where old contacts may last [m]
constexpr std::array<double, 3> kBlends{0.05, 0.01, 0.001};  // corner deviations tried [rad]

/// Radius [m] about its own frame that holds everything that a link carries, whatever its joints
/// do.
double reachOf(const RobotModel& model, int link, int held_link, double held_radius) {
  double radius = link == held_link ? held_radius : 0.0;
  for (const Shape& shape : model.links[static_cast<std::size_t>(link)].collision) {
    const double at = shape.X_BS.translation().norm();

    struct Size {
      double operator()(const BoxShape& s) const { return 0.5 * s.size.norm(); }

      double operator()(const SphereShape& s) const { return s.radius; }

      double operator()(const CylinderShape& s) const {
        return std::hypot(s.radius, 0.5 * s.length);
      }

      double operator()(const ConvexShape& s) const {
        double most = 0;
        for (const auto& vertex : s.vertices) most = std::max(most, vertex.norm());
        return most;
      }
    };

    radius = std::max(radius, at + std::visit(Size{}, shape.geometry));
  }
  for (const Joint& joint : model.joints) {
    if (joint.parent_link != link) continue;
    radius = std::max(radius, joint.X_PJ.translation().norm() +
                                  reachOf(model, joint.child_link, held_link, held_radius));
  }
  return radius;
}

double objectRadius(const SceneObject& object) {
  double most = 0;
  for (const Shape& shape : object.shapes) {
    if (const auto* convex = std::get_if<ConvexShape>(&shape.geometry)) {
      for (const auto& vertex : convex->vertices)
        most = std::max(most, (shape.X_BS * vertex).norm());
    } else if (const auto* box = std::get_if<BoxShape>(&shape.geometry)) {
      most = std::max(most, shape.X_BS.translation().norm() + 0.5 * box->size.norm());
    } else if (const auto* sphere = std::get_if<SphereShape>(&shape.geometry)) {
      most = std::max(most, shape.X_BS.translation().norm() + sphere->radius);
    } else if (const auto* cylinder = std::get_if<CylinderShape>(&shape.geometry)) {
      most = std::max(most, shape.X_BS.translation().norm() +
                                std::hypot(cylinder->radius, 0.5 * cylinder->length));
    }
  }
  return most;
}

/// How far [m] a point of the mover can travel per radian of each stage joint.
Eigen::VectorXd leversOf(const StagePath& stage, double object_radius) {
  const RobotModel& model = *stage.mover->model;
  const bool holds = stage.state.holder == stage.mover;
  const int held_link = holds ? stage.mover->arm_model->tool_link : -1;
  const double held_radius = holds ? stage.state.X_TO.translation().norm() + object_radius : 0.0;
  Eigen::VectorXd levers = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(stage.dofs.size()));
  for (std::size_t i = 0; i < stage.dofs.size(); ++i) {
    for (const Joint& joint : model.joints) {
      if (joint.type == JointType::kFixed || joint.dof != stage.dofs[i]) continue;
      const double lever = joint.type == JointType::kPrismatic
                               ? 1.0
                               : reachOf(model, joint.child_link, held_link, held_radius);
      auto& most = levers[static_cast<Eigen::Index>(i)];
      most = std::max(most,
                      lever * std::max(1.0, std::abs(joint.mimic ? joint.mimic_multiplier : 1.0)));
    }
  }
  return levers;
}

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

/// The first contact on the timed curve, if any.
std::optional<BodyContact> hitOnCurve(const CheckerFactory& checkers, const StagePath& stage,
                                      const TimedPath& timed, const Eigen::VectorXd& levers) {
  StateChecker checker = checkers.make(stage.state, *stage.mover, stage.dofs, stage.contacts);
  AllowedContacts early = stage.contacts;
  early.giver_hand |= stage.early_contacts.giver_hand;
  early.receiver_hand |= stage.early_contacts.receiver_hand;
  StateChecker early_checker = checkers.make(stage.state, *stage.mover, stage.dofs, early);
  double travelled = 0;
  Eigen::VectorXd q = timed.q.front();
  if (const auto hit = early_checker.hit(q)) return hit;
  for (std::size_t i = 1; i < timed.t.size(); ++i) {
    const double gap = timed.t[i] - timed.t[i - 1];
    const Eigen::VectorXd speed = timed.qd[i - 1].cwiseAbs().cwiseMax(timed.qd[i].cwiseAbs());
    // The cubic's speed between samples stays below the larger end's and the chord's together.
    const double travel =
        levers.dot((timed.q[i] - timed.q[i - 1]).cwiseAbs().cwiseMax(speed * gap));
    const int steps = std::max(1, static_cast<int>(std::ceil(travel / kTravel)));
    for (int step = 1; step <= steps; ++step) {
      q = evaluate(timed, timed.t[i - 1] + gap * step / steps);
      travelled += travel / steps;
      // `travelled` overestimates, so the early contacts are dropped too soon rather than too late.
      const auto hit = travelled <= kEarlyMotion ? early_checker.hit(q) : checker.hit(q);
      if (hit) return hit;
    }
  }
  return std::nullopt;
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
  const double object_radius =
      objectRadius(problem.scene->objects[static_cast<std::size_t>(checkers.object())]);
  double clock = 0;
  for (const StagePath& stage : exchange.stages) {
    const TimingLimits limits = limitsOf(stage);
    const Eigen::VectorXd levers = leversOf(stage, object_radius);
    std::optional<TimedPath> timed;
    std::string detail;
    for (const double blend : kBlends) {
      TimingSettings settings;
      settings.blend = blend;
      settings.speed_scale = problem.speed_scale;
      auto result = parameterize(stage.waypoints, limits, settings);
      if (!result) return TimingFailure{toString(stage.kind), result.error().detail};
      const auto hit = hitOnCurve(checkers, stage, *result, levers);
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
