// SPDX-License-Identifier: Apache-2.0
#include "core/planning/plan_assembly.hpp"

#include "core/planning/plan_quality.hpp"

#include <algorithm>
#include <limits>

namespace handover {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kSameTime = 1e-9;  // design §5: times nearer than this are equal [s]

/// When one holder's hand has to do with the object [s].
struct HolderTimes {
  double touches = 0;       ///< the start of its grasp
  double holds = 0;         ///< the end of its grasp
  double lets_go = kNever;  ///< the end of its release
  double clear = kNever;    ///< its hand has left
};

struct PlanTimes {
  std::vector<HolderTimes> holders;
  double lifted = kNever;  ///< the end of the first lift
  double placed = kNever;  ///< the start of the place
};

PlanTimes timesOf(const std::vector<TimedStage>& timed, const std::vector<ScheduledStage>& schedule,
                  std::size_t holders) {
  PlanTimes times;
  times.holders.resize(holders);
  for (std::size_t i = 0; i < timed.size(); ++i) {
    const TaskStage& stage = timed[i].stage->stage;
    const double start = schedule[i].start;
    const double end = start + timed[i].path.duration();
    HolderTimes& holder = times.holders[stage.holder];
    if (stage.action == StageAction::kGrasp) holder.touches = start, holder.holds = end;
    if (stage.action == StageAction::kRelease) holder.lets_go = end;
    if (stage.action == StageAction::kRetreat) holder.clear = start + timed[i].clear;
    if (stage.action == StageAction::kLift) times.lifted = end;
    if (stage.action == StageAction::kPlace) times.placed = start;
  }
  return times;
}

/// What is allowed from `start` to `end`.
AllowedContacts contactsDuring(const PlanTimes& times, bool held_at_start, double start,
                               double end) {
  AllowedContacts contacts;
  for (std::size_t k = 0; k < times.holders.size(); ++k) {
    const HolderTimes& holder = times.holders[k];
    if (holder.touches <= start + kSameTime && end <= holder.clear + kSameTime) {
      contacts.hands.insert(k);
    }
  }
  contacts.start_rest = !held_at_start && end <= times.lifted + kSameTime;
  contacts.goal_rest = times.placed <= start + kSameTime;
  return contacts;
}

std::vector<Hold> holdsAt(const TransportProblem& problem, const TransportPath& path,
                          const PlanTimes& times, double time) {
  std::vector<Hold> holds;
  for (std::size_t k = 0; k < path.holders.size(); ++k) {
    const HolderTimes& holder = times.holders[k];
    if (time < holder.holds - kSameTime || time >= holder.lets_go - kSameTime) continue;
    const Manipulator& arm = *path.holders[k].manipulator;
    holds.push_back({problem.task.object, arm.robotName(), arm.toolLink(),
                     toValue(arm.grasp(path.holders[k].grasp).X_OT.inverse())});
  }
  for (const SceneObject& object : problem.scene->objects) {
    if (!object.attached_to || object.name == problem.task.object) continue;
    const SceneRobot& robot = problem.scene->robots[object.attached_to->robot];
    holds.push_back({object.name, robot.name, robot.model->links[object.attached_to->link].name,
                     toValue(object.attached_to->X_LO)});
  }
  return holds;
}

std::vector<std::vector<double>> plain(const std::vector<Eigen::VectorXd>& rows) {
  std::vector<std::vector<double>> numbers;
  numbers.reserve(rows.size());
  for (const Eigen::VectorXd& row : rows) {
    auto& last = numbers.emplace_back(row.begin(), row.end());
    for (double& number : last) number += 0.0;  // no -0.0
  }
  return numbers;
}

std::vector<std::string> jointNames(const TimedStage& timed) {
  const RobotModel& model = *timed.stage->mover->model;
  std::vector<std::string> names;
  for (const DofId dof : timed.dofs) {
    const JointId joint = model.dof_joints[dof];
    names.push_back(model.joints[joint].name);
  }
  return names;
}

GripperSnapshot gripperOf(const Manipulator& arm) {
  const auto linkName = [&](LinkId link) { return arm.model->links[link].name; };
  if (arm.hand->suction) {
    const Suction& suction = *arm.hand->suction;
    return SuctionGripper{linkName(suction.cup_link),
                          {suction.axis.x(), suction.axis.y(), suction.axis.z()},
                          suction.radius};
  }
  FingerGripper fingers{linkName(arm.hand->palm_link), {}};
  for (const LinkId link : arm.hand->links) {
    if (link != arm.hand->palm_link) fingers.finger_links.push_back(linkName(link));
  }
  return fingers;
}

/// As the contract has it: J J^T of fewer than six joints is singular. Ours ranks such arms by the
/// joints' space.
Dexterity dexterityOf(const HolderPath& path) {
  return path.manipulator->kinematics->dofs() < 6 ? Dexterity{} : path.dexterity;
}

Holder holderOf(const HolderPath& path) {
  const Manipulator& arm = *path.manipulator;
  return {arm.name(),
          arm.toolLink(),
          gripperOf(arm),
          toValue(arm.grasp(path.grasp).X_OT),
          static_cast<std::uint32_t>(path.grasp),
          dexterityOf(path)};
}

}  // namespace

TransportPlan assemblePlan(const TransportProblem& problem, CollisionContext& context,
                           const TransportPath& path, const std::vector<TimedStage>& timed,
                           const std::vector<ScheduledStage>& schedule) {
  TransportPlan plan;
  for (const HolderPath& holder : path.holders) plan.solution.holders.push_back(holderOf(holder));
  for (const Pose& X_WH : path.X_WH) plan.solution.X_WO_handovers.push_back(toValue(X_WH));
  plan.solution.stage_count = static_cast<std::uint32_t>(timed.size());
  plan.solution.quality = qualityOf(problem, path, timed, schedule);
  plan.solution.quality->cost = plan.solution.cost;

  const bool held = problem.task.held_by.has_value();
  PlanTimes times = timesOf(timed, schedule, path.holders.size());
  for (std::size_t i = 0; i < timed.size(); ++i) {
    const TimedPath& curve = timed[i].path;
    const double start = schedule[i].start;
    StageTrajectory trajectory;
    trajectory.index = static_cast<std::uint32_t>(i);
    trajectory.holder = static_cast<std::uint32_t>(timed[i].stage->stage.holder);
    trajectory.action = timed[i].stage->stage.action;
    trajectory.robot = timed[i].stage->mover->robotName();
    trajectory.joints = jointNames(timed[i]);
    trajectory.start = start;
    trajectory.t = curve.t;
    trajectory.q = plain(curve.q);
    trajectory.qd = plain(curve.qd);
    trajectory.qdd = plain(curve.qdd);
    trajectory.holding = holdsAt(problem, path, times, start);
    trajectory.may_touch =
        context.names(contactsDuring(times, held, start, start + curve.duration()));
    trajectory.after = schedule[i].after;
    plan.trajectories.push_back(std::move(trajectory));
  }
  return plan;
}

}  // namespace handover
