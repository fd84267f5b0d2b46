// SPDX-License-Identifier: Apache-2.0
#include "core/planning/plan_quality.hpp"

#include "core/motion/quintic.hpp"
#include "core/planning/collision_context.hpp"
#include "core/planning/plan_clearance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>

namespace handover {
namespace {

using Stages = std::vector<TimedStage>;
using Schedule = std::vector<ScheduledStage>;

constexpr double kDegree = M_PI / 180;
constexpr double kNever = std::numeric_limits<double>::infinity();

const TaskStage& taskOf(const TimedStage& timed) { return timed.stage->stage; }

RobotId robotOf(const TimedStage& timed) { return timed.stage->mover->robot; }

const Joint& jointOf(const TimedStage& timed, std::size_t dof) {
  const RobotModel& model = *timed.stage->mover->model;
  return model.joints[model.dof_joints[timed.dofs[dof]]];
}

// ---- times --------------------------------------------------------------------------------------

struct HoldTimes {
  double from = 0, to = kNever;
};

/// When things happen in a plan [s].
class PlanClock {
 public:
  PlanClock(const Stages& timed, const Schedule& schedule, std::size_t holders)
      : timed_(timed), schedule_(schedule), holds_(holders) {
    double released = kNever, carried = 0;
    for (std::size_t i = 0; i < timed.size(); ++i) {
      const TaskStage& stage = taskOf(timed[i]);
      end_ = std::max(end_, end(i));
      if (stage.action == StageAction::kGrasp) holds_[stage.holder].from = end(i);
      if (stage.action == StageAction::kRelease) holds_[stage.holder].to = end(i);
      if (stage.holder + 1 < holders) continue;
      if (stage.action == StageAction::kRelease) released = start(i);
      if (stage.action == StageAction::kCarry) carried = end(i);
    }
    object_from_ = holds_.front().from;
    object_to_ = released < kNever ? released : carried;
  }

  double start(std::size_t stage) const { return schedule_[stage].start; }

  double end(std::size_t stage) const { return start(stage) + timed_[stage].path.duration(); }

  double end() const { return end_; }

  double underWay() const { return object_to_ - object_from_; }

  /// Seconds while the object is under way in which an arm of the robot has it and no stage of the
  /// robot's runs.
  double idle(const TransportPath& path, RobotId robot) const {
    std::set<double> cuts{object_from_, object_to_};
    const auto cut = [&](double time) {
      if (object_from_ < time && time < object_to_) cuts.insert(time);
    };
    for (std::size_t i = 0; i < timed_.size(); ++i) {
      cut(start(i));
      cut(end(i));
    }
    double sum = 0;
    for (auto it = cuts.begin(); std::next(it) != cuts.end(); ++it) {
      const double from = *it, to = *std::next(it), middle = 0.5 * (from + to);
      if (has(path, robot, middle) && !runs(robot, middle)) sum += to - from;
    }
    return sum;
  }

 private:
  bool has(const TransportPath& path, RobotId robot, double time) const {
    for (std::size_t k = 0; k < holds_.size(); ++k) {
      if (path.holders[k].manipulator->robot != robot) continue;
      if (holds_[k].from < time && time < holds_[k].to) return true;
    }
    return false;
  }

  bool runs(RobotId robot, double time) const {
    for (std::size_t i = 0; i < timed_.size(); ++i) {
      if (robotOf(timed_[i]) == robot && start(i) < time && time < end(i)) return true;
    }
    return false;
  }

  const Stages& timed_;
  const Schedule& schedule_;
  std::vector<HoldTimes> holds_;
  double end_ = 0, object_from_ = 0, object_to_ = 0;
};

// ---- the least that it could take ---------------------------------------------------------------

/// From rest to rest over a distance, within velocity and acceleration.
double restToRest(double distance, const Joint& joint) {
  const double v = joint.velocity, a = joint.acceleration;
  return distance * a <= v * v ? 2 * std::sqrt(distance / a) : distance / v + v / a;
}

/// bound_s: every movement in the time that its slowest joint needs alone, as early as the required
/// order allows.
class LeastTime {
 public:
  explicit LeastTime(const Stages& timed) : timed_(timed) {
    for (std::size_t i = 0; i < timed.size(); ++i) {
      const bool goes_on =
          i > 0 && (timed[i].goes_on || joinable(taskOf(timed[i - 1]), taskOf(timed[i])));
      if (!goes_on) movements_.emplace_back();
      Movement& movement = movements_.back();
      movement_of_.push_back(movements_.size() - 1);
      offset_.push_back(movement.actual);
      movement.actual += timed[i].path.duration();
      addTo(movement, timed[i]);
    }
    for (Movement& movement : movements_) {
      movement.bound = movement.still;
      double longest = 0;
      for (const auto& [dof, way] : movement.ways) longest = std::max(longest, way.least());
      movement.bound += longest;
    }
  }

  double end() {
    findEdges();
    double end = 0;
    std::vector<double> starts(movements_.size());
    for (std::size_t round = 0; round < movements_.size(); ++round) {
      for (const Edge& edge : edges_) {
        starts[edge.to] = std::max(starts[edge.to], starts[edge.from] + edge.gap);
      }
    }
    for (std::size_t m = 0; m < movements_.size(); ++m) {
      end = std::max(end, starts[m] + movements_[m].bound);
    }
    return end;
  }

 private:
  struct Way {
    const Joint* joint = nullptr;
    double distance = 0;

    double least() const { return distance > 0 ? restToRest(distance, *joint) : 0; }
  };

  /// Stages of one arm that count as one.
  struct Movement {
    std::map<DofId, Way> ways;
    double still = 0;   ///< of stages without joints [s]
    double actual = 0;  ///< what its stages take [s]
    double bound = 0;   ///< what they could take [s]

    double scale() const { return bound / actual; }
  };

  struct Edge {
    std::size_t from, to;  ///< movements
    double gap;            ///< from start to start, at least [s]
  };

  static void addTo(Movement& movement, const TimedStage& stage) {
    if (stage.dofs.empty()) movement.still += stage.path.duration();
    for (std::size_t j = 0; j < stage.dofs.size(); ++j) {
      Way& way = movement.ways[stage.dofs[j]];
      const auto at = static_cast<Eigen::Index>(j);
      way.joint = &jointOf(stage, j);
      way.distance += std::abs(stage.path.q.back()[at] - stage.path.q.front()[at]);
    }
  }

  void findEdges() {
    std::vector<TaskStage> task;
    for (const TimedStage& stage : timed_) task.push_back(taskOf(stage));
    const std::vector<int> arms = armNumbers();
    for (std::size_t i = 0; i < timed_.size(); ++i) {
      for (const Precedence& before : precedenceOf(task, i, arms)) {
        const std::size_t from = movement_of_[before.stage], to = movement_of_[i];
        if (from == to) continue;
        const TimedStage& other = timed_[before.stage];
        const double progress =
            before.progress == Progress::kClear ? other.clear : other.path.duration();
        edges_.push_back({from, to,
                          (offset_[before.stage] + progress) * movements_[from].scale() -
                              offset_[i] * movements_[to].scale()});
      }
    }
  }

  /// Per holder; equal numbers are one arm.
  std::vector<int> armNumbers() const {
    std::vector<const Manipulator*> holders;
    for (const TimedStage& stage : timed_) {
      holders.resize(std::max(holders.size(), taskOf(stage).holder + 1));
      holders[taskOf(stage).holder] = stage.stage->mover;
    }
    std::vector<int> numbers;
    for (std::size_t k = 0; k < holders.size(); ++k) {
      std::size_t first = 0;
      while (!holders[first]->sameArm(*holders[k])) ++first;
      numbers.push_back(static_cast<int>(first));
    }
    return numbers;
  }

  const Stages& timed_;
  std::vector<Movement> movements_;
  std::vector<std::size_t> movement_of_;  ///< by stage
  std::vector<double> offset_;            ///< by stage: its start in its movement [s]
  std::vector<Edge> edges_;
};

// ---- the object's turning -----------------------------------------------------------------------

/// Follows the object while arms carry it.
class ObjectTurning {
 public:
  /// @param axis_O  whose tilt is meant, unit.
  explicit ObjectTurning(const Eigen::Vector3d& axis_O) : axis_O_(axis_O) {}

  void follow(const TimedStage& stage, const Eigen::Matrix3d& R_TO) {
    const double duration = stage.path.duration();
    const int parts = std::max(1, static_cast<int>(std::ceil(duration / kPart)));
    axis_T_ = R_TO * axis_O_;
    stage_ = &stage;
    Sample from = at(0);
    for (int part = 1; part <= parts; ++part) {
      const Sample to = at(duration * part / parts);
      measure(from, to, 0);
      from = to;
    }
  }

  double turned() const { return turned_; }

  /// The greatest angle to the vertical [rad]; < 0: nothing was carried.
  double most() const { return most_; }

 private:
  static constexpr double kPart = 0.16;    // [s] between looks, at most
  static constexpr double kAgree = 3e-4;   // of two rules of integration [rad]
  static constexpr int kMostHalvings = 6;  // down to 2.5 ms

  struct Sample {
    double t = 0;
    double speed = 0;  ///< of turning [rad/s]
    double up = 0;     ///< cosine of the axis' angle to the vertical
    double rate = 0;   ///< of `up` [1/s]
  };

  Sample at(double t) {
    const Manipulator& arm = *stage_->stage->mover;
    evaluate(stage_->path, t, q_, qd_);
    const Eigen::Matrix3d R_WA = arm.map.X_WA.linear();
    const Pose X_AT = arm.kinematics->toolPose(q_, J_);
    const Eigen::Vector3d w_W = R_WA * (J_.bottomRows<3>() * qd_);
    const Eigen::Vector3d axis_W = R_WA * (X_AT.linear() * axis_T_);
    most_ = std::max(most_, tiltOf(axis_W));
    return {t, w_W.norm(), axis_W.z(), w_W.cross(axis_W).z()};
  }

  void measure(const Sample& from, const Sample& to, int depth) {
    const double h = to.t - from.t;
    const Sample middle = at(0.5 * (from.t + to.t));
    const double trapezoid = 0.5 * h * (from.speed + to.speed);
    const double simpson = h / 6 * (from.speed + 4 * middle.speed + to.speed);
    if (std::abs(simpson - trapezoid) > kAgree && depth < kMostHalvings) {
      measure(from, middle, depth + 1);
      measure(middle, to, depth + 1);
      return;
    }
    turned_ += simpson;
    lookBetween(from, middle);
    lookBetween(middle, to);
  }

  /// The greatest tilt of the cubic through both.
  void lookBetween(const Sample& from, const Sample& to) {
    if (!(from.rate < 0 && to.rate > 0)) return;
    const double h = to.t - from.t, d = to.up - from.up;
    const double c2 = 3 * d - h * (2 * from.rate + to.rate);
    const double c3 = h * (from.rate + to.rate) - 2 * d;
    // Where h * rate + 2 c2 x + 3 c3 x^2 is 0, falling through to rising.
    const double p = h * from.rate;
    const double root = std::sqrt(std::max(0.0, c2 * c2 - 3 * c3 * p));
    const double x = std::clamp(-p / (c2 + root), 0.0, 1.0);
    const double least = from.up + x * (p + x * (c2 + x * c3));
    most_ = std::max(most_, std::acos(std::clamp(least, -1.0, 1.0)));
  }

  Eigen::Vector3d axis_O_, axis_T_ = Eigen::Vector3d::UnitZ();
  const TimedStage* stage_ = nullptr;
  double turned_ = 0, most_ = -1;
  Eigen::VectorXd q_, qd_;
  ArmJacobian J_;
};

void measureTurning(const TransportProblem& problem, const TransportPath& path, const Stages& timed,
                    Quality& quality) {
  const TiltLimit ends = tiltAtEnds(problem.task);
  const Eigen::Matrix3d R_start = problem.task.X_WO_start.linear();
  const Eigen::Matrix3d R_goal = problem.task.X_WO_goal.linear();
  ObjectTurning turning(ends.axis_O);
  for (const TimedStage& stage : timed) {
    if (!carries(taskOf(stage))) continue;
    const HolderPath& holder = path.holders[taskOf(stage).holder];
    turning.follow(stage, holder.manipulator->grasp(holder.grasp).X_OT.linear().transpose());
  }
  quality.tilt_deg = std::max(0.0, turning.most() - ends.most) / kDegree;
  quality.object_turn_deg = {
      turning.turned() / kDegree,
      Eigen::Quaterniond(R_start).angularDistance(Eigen::Quaterniond(R_goal)) / kDegree};
}

// ---- the rest -----------------------------------------------------------------------------------

/// Where holders take and give: at the first and the last of a holder's carrying stages.
double limitMargin(const Stages& timed) {
  double least = 0.5;  // in the middle
  const auto look = [&](const TimedStage& stage, const Eigen::VectorXd& q) {
    for (std::size_t j = 0; j < stage.dofs.size(); ++j) {
      const Joint& joint = jointOf(stage, j);
      if (joint.continuous || joint.upper <= joint.lower) continue;
      const double at = q[static_cast<Eigen::Index>(j)];
      least = std::min(least,
                       std::min(at - joint.lower, joint.upper - at) / (joint.upper - joint.lower));
    }
  };
  const auto carriedBy = [&](std::size_t stage, std::size_t holder) {
    return stage < timed.size() && carries(taskOf(timed[stage])) &&
           taskOf(timed[stage]).holder == holder;
  };
  for (std::size_t i = 0; i < timed.size(); ++i) {
    const std::size_t holder = taskOf(timed[i]).holder;
    if (!carriedBy(i, holder)) continue;
    if (i == 0 || !carriedBy(i - 1, holder)) look(timed[i], timed[i].path.q.front());
    if (!carriedBy(i + 1, holder)) look(timed[i], timed[i].path.q.back());
  }
  return least;
}

std::vector<GripQuality> gripsOf(const TransportPath& path) {
  std::vector<GripQuality> grips;
  for (std::size_t k = 0; k < path.holders.size(); ++k) {
    const Manipulator& arm = *path.holders[k].manipulator;
    const double quality = arm.grasp(path.holders[k].grasp).quality;
    double best = quality;
    for (const Grasp& grasp : arm.grasps->grasps) best = std::max(best, grasp.quality);
    grips.push_back({static_cast<std::uint32_t>(k), quality, best > 0 ? quality / best : 1});
  }
  return grips;
}

double jerkShare(const Stages& timed) {
  double share = 0;
  for (const TimedStage& stage : timed) {
    const TimedPath& path = stage.path;
    for (std::size_t j = 0; j < stage.dofs.size(); ++j) {
      const double limit = jointOf(stage, j).jerk;
      const auto at = static_cast<Eigen::Index>(j);
      const auto state = [&](std::size_t s) {
        return JointState{path.q[s][at], path.qd[s][at], path.qdd[s][at]};
      };
      for (std::size_t s = 0; s + 1 < path.t.size(); ++s) {
        const auto jerk = Quintic(state(s), state(s + 1), path.t[s + 1] - path.t[s]).jerkControls();
        const double hull = std::max({std::abs(jerk[0]), std::abs(jerk[1]), std::abs(jerk[2])});
        if (hull <= share * limit) continue;
        share = greatestMagnitude(jerk, share * limit, 1e-4 * limit) / limit;
      }
    }
  }
  return share;
}

}  // namespace

Quality motionQualityOf(const TransportProblem& problem, const TransportPath& path,
                        const std::vector<TimedStage>& timed,
                        const std::vector<ScheduledStage>& schedule) {
  const PlanClock clock(timed, schedule, path.holders.size());
  Quality quality;
  quality.duration_s = clock.end();
  quality.bound_s = LeastTime(timed).end();
  quality.object_s = clock.underWay();
  for (const HolderPath& holder : path.holders) {
    const std::string& robot = holder.manipulator->robotName();
    const bool told = std::any_of(quality.idle_s.begin(), quality.idle_s.end(),
                                  [&](const auto& it) { return it.first == robot; });
    if (!told) quality.idle_s.emplace_back(robot, clock.idle(path, holder.manipulator->robot));
  }
  measureTurning(problem, path, timed, quality);
  quality.limit_margin = limitMargin(timed);
  quality.grip = gripsOf(path);
  quality.jerk_share = jerkShare(timed);
  return quality;
}

Quality qualityOf(const TransportProblem& problem, const TransportPath& path,
                  const std::vector<TimedStage>& timed,
                  const std::vector<ScheduledStage>& schedule) {
  Quality quality = motionQualityOf(problem, path, timed, schedule);
  quality.clearance = clearanceOf(problem, path, timed, schedule);
  return quality;
}

}  // namespace handover
