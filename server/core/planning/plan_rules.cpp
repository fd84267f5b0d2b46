// SPDX-License-Identifier: Apache-2.0
#include "core/planning/plan_rules.hpp"

#include "core/motion/quintic.hpp"
#include "core/planning/collision_context.hpp"
#include "core/planning/manipulator.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

namespace handover {
namespace {

// Of the contract, design §5.
constexpr double kSameTime = 1e-9;
constexpr double kLeastGap = 1e-3;
constexpr double kSamePosition = 1e-9;
constexpr double kJoined = 1e-6;  // q, qd, qdd where stages pass into each other
constexpr double kPositionSlack = 1e-6;
constexpr double kSpeedSlack = 1.001, kJerkSlack = 1.01;
constexpr double kJump = 1e-4;
constexpr double kTurnJump = 0.01 * M_PI / 180;
constexpr double kGoalDistance = 1e-3;
constexpr double kGoalTurn = 0.5 * M_PI / 180;
constexpr double kStraight = 1e-3;
constexpr double kStraightTurn = 0.5 * M_PI / 180;
constexpr double kUpwards = 1 * M_PI / 180;
constexpr double kGripDistance = 2e-3;
const double kOpposed = std::cos(120 * M_PI / 180);
constexpr double kClaim = 0.01;  // dexterity
constexpr double kTiltTolerance = 0.01 * M_PI / 180;

double angleBetween(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return Eigen::AngleAxisd(a.transpose() * b).angle();
}

bool near(const Pose& a, const Pose& b, double distance, double angle) {
  return (a.translation() - b.translation()).norm() <= distance &&
         angleBetween(a.linear(), b.linear()) <= angle;
}

bool atRest(const StageTrajectory& stage, std::size_t sample) {
  const auto zero = [](double value) { return value == 0; };
  return std::all_of(stage.qd[sample].begin(), stage.qd[sample].end(), zero) &&
         std::all_of(stage.qdd[sample].begin(), stage.qdd[sample].end(), zero);
}

/// Goes through the stages in their order, as if done one after the other.
class PlanReplay {
 public:
  PlanReplay(const TransportProblem& problem, const TransportPlan& plan, CollisionWorld& world)
      : problem_(problem),
        plan_(plan),
        world_(world),
        stages_(makeStages(transportOf(problem.task, plan.solution.holders.size()))),
        tilt_(tiltLimitOf(problem.task)),
        X_WO_(problem.task.X_WO_start) {
    for (const SceneRobot& robot : problem.scene->robots) q_.push_back(robot.q_start);
  }

  std::vector<std::string> broken() {
    if (!findArms() || !checkStages()) return std::move(broken_);
    for (std::size_t i = 0; i < stages_.size(); ++i) {
      if (!checkSamples(i)) continue;
      checkJoints(i);
      checkStart(i);
      run(i);
    }
    if (!near(X_WO_, problem_.task.X_WO_goal, kGoalDistance, kGoalTurn)) {
      tell("the object does not end at its goal");
    }
    checkOrder();
    return std::move(broken_);
  }

 private:
  const StageTrajectory& at(std::size_t stage) const { return plan_.trajectories[stage]; }

  const Manipulator& armOf(std::size_t stage) const { return arms_[stages_[stage].holder]; }

  void tell(std::string what) {
    if (broken_.size() < 16) broken_.push_back(std::move(what));
  }

  void tell(std::size_t stage, const std::string& what) {
    tell("stage " + std::to_string(stage) + " (" + toString(stages_[stage].action) + "): " + what);
  }

  bool findArms() {
    for (const Holder& holder : plan_.solution.holders) {
      const RobotId robot = problem_.scene->findRobot(holder.arm.robot);
      const ArmId arm =
          robot.valid() ? problem_.scene->robots[robot].model->findArm(holder.arm.arm) : ArmId();
      if (!arm.valid()) {
        tell("unknown holder " + holder.arm.robot + "/" + holder.arm.arm);
        return false;
      }
      arms_.push_back(makeManipulator(problem_, robot, arm));
      X_TO_.push_back(toPose(holder.X_OT).inverse());
    }
    return true;
  }

  /// The stages of the chain, in their order, and what their joints are.
  bool checkStages() {
    if (plan_.trajectories.size() != stages_.size()) {
      tell(std::to_string(plan_.trajectories.size()) + " stages instead of " +
           std::to_string(stages_.size()));
      return false;
    }
    for (std::size_t i = 0; i < stages_.size(); ++i) {
      const StageTrajectory& stage = at(i);
      if (stage.index != i || stage.holder != stages_[i].holder ||
          stage.action != stages_[i].action || stage.robot != armOf(i).robotName()) {
        tell(i, "is not the stage that the chain has there");
        return false;
      }
      std::vector<DofId> dofs;
      for (const std::string& name : stage.joints) {
        const JointId joint = armOf(i).model->findJoint(name);
        if (!joint.valid() || armOf(i).model->joints[joint].mimic) {
          tell(i, "names joint " + name);
          return false;
        }
        dofs.push_back(armOf(i).model->joints[joint].dof);
      }
      dofs_.push_back(std::move(dofs));
    }
    return true;
  }

  bool checkSamples(std::size_t i) {
    const StageTrajectory& stage = at(i);
    const std::size_t size = stage.t.size();
    if (size < 2 || stage.q.size() != size || stage.qd.size() != size || stage.qdd.size() != size ||
        stage.t.front() != 0) {
      tell(i, "has no samples from 0 on");
      return false;
    }
    for (std::size_t s = 0; s < size; ++s) {
      if (s > 0 && stage.t[s] - stage.t[s - 1] < kLeastGap - kSameTime) tell(i, "has a short gap");
      const std::size_t joints = dofs_[i].size();
      if (stage.q[s].size() != joints || stage.qd[s].size() != joints ||
          stage.qdd[s].size() != joints) {
        tell(i, "has samples of another size");
        return false;
      }
    }
    return true;
  }

  void checkJoints(std::size_t i) {
    const StageTrajectory& stage = at(i);
    for (std::size_t j = 0; j < dofs_[i].size(); ++j) {
      const RobotModel& model = *armOf(i).model;
      const Joint& joint = model.joints[model.dof_joints[dofs_[i][j]]];
      for (std::size_t s = 1; s < stage.t.size(); ++s) {
        const auto state = [&](std::size_t k) {
          return JointState{stage.q[k][j], stage.qd[k][j], stage.qdd[k][j]};
        };
        const Quintic curve(state(s - 1), state(s), stage.t[s] - stage.t[s - 1]);
        if (!withinLimits(curve, joint)) {
          tell(i, joint.name + " leaves its limits after " + std::to_string(stage.t[s - 1]) + " s");
          break;
        }
      }
    }
  }

  static bool withinLimits(const Quintic& curve, const Joint& joint) {
    const auto most = [](const auto& controls, double limit) {
      return greatestMagnitude(controls, 0, 1e-4 * limit) <= limit;
    };
    if (!joint.continuous) {
      auto above = curve.controls(), below = above;
      for (double& it : above) it -= joint.upper;
      for (double& it : below) it = joint.lower - it;
      const double tolerance = 0.1 * kPositionSlack;
      if (greatestValue(above, -1, tolerance) > kPositionSlack ||
          greatestValue(below, -1, tolerance) > kPositionSlack) {
        return false;
      }
    }
    return most(curve.velocityControls(), kSpeedSlack * joint.velocity) &&
           most(curve.accelerationControls(), kSpeedSlack * joint.acceleration) &&
           most(curve.jerkControls(), kJerkSlack * joint.jerk);
  }

  /// Whether the stage goes on where another of its arm ends, without a stop.
  bool goesOn(std::size_t i) const {
    return i > 0 && at(i).holder == at(i - 1).holder && !atRest(at(i - 1), at(i - 1).t.size() - 1);
  }

  void checkStart(std::size_t i) {
    const StageTrajectory& stage = at(i);
    if (goesOn(i)) {
      const StageTrajectory& last = at(i - 1);
      if (std::abs(stage.start - last.start - last.t.back()) > kSameTime) {
        tell(i, "does not begin where the one it goes on from ends");
      }
      for (std::size_t j = 0; j < stage.joints.size(); ++j) {
        const auto k = static_cast<std::size_t>(
            std::find(last.joints.begin(), last.joints.end(), stage.joints[j]) -
            last.joints.begin());
        if (k == last.joints.size()) continue;
        const double off = std::max({std::abs(stage.q[0][j] - last.q.back()[k]),
                                     std::abs(stage.qd[0][j] - last.qd.back()[k]),
                                     std::abs(stage.qdd[0][j] - last.qdd.back()[k])});
        if (off > kJoined) tell(i, stage.joints[j] + " jumps at the start");
      }
    } else if (!atRest(stage, 0)) {
      tell(i, "does not start at rest");
    } else {
      const RobotVector& q = q_[armOf(i).robot];
      for (std::size_t j = 0; j < stage.joints.size(); ++j) {
        if (std::abs(stage.q[0][j] - q[dofs_[i][j].value()]) > kSamePosition) {
          tell(i, stage.joints[j] + " does not start where it stopped");
        }
      }
    }
    const bool ends = i + 1 == stages_.size() || !joinable(stages_[i], stages_[i + 1]);
    if (ends && !atRest(stage, stage.t.size() - 1)) tell(i, "does not come to rest");
  }

  void set(std::size_t i, const std::vector<double>& q) {
    RobotVector& all = q_[armOf(i).robot];
    for (std::size_t j = 0; j < q.size(); ++j) all[dofs_[i][j].value()] = q[j];
  }

  Pose toolPose(std::size_t i) const {
    const Manipulator& arm = armOf(i);
    return arm.toolPose(arm.armOf(q_[arm.robot]));
  }

  /// Where the stage's hand would have the object.
  Pose objectIn(std::size_t i) const { return toolPose(i) * X_TO_[stages_[i].holder]; }

  void run(std::size_t i) {
    set(i, at(i).q.front());
    const bool carried = carries(stages_[i]);
    const bool grips = stages_[i].action == StageAction::kGrasp;
    if (carried || grips || stages_[i].action == StageAction::kRelease) {
      if (!near(objectIn(i), X_WO_, kJump, kTurnJump)) tell(i, "the object jumps");
    }
    if (grips) checkOpening(i);
    if (typeOf(stages_[i].action) == StageType::kLinear) checkStraight(i);
    if (carried) checkTilt(i);
    set(i, at(i).q.back());
    if (carried) X_WO_ = objectIn(i);
    if (grips) checkGrip(i);
    if (grips) checkDexterity(i, plan_.solution.holders[stages_[i].holder].dexterity.take);
    const bool gives =
        stages_[i].action == StageAction::kRelease || (i + 1 == stages_.size() && carried);
    if (gives) checkDexterity(i, plan_.solution.holders[stages_[i].holder].dexterity.give);
    if (stages_[i].action == StageAction::kCarry && stages_[i].holder + 1 < arms_.size()) {
      const Pose X_WH = toPose(plan_.solution.X_WO_handovers[stages_[i].holder]);
      if (!near(X_WO_, X_WH, kJump, kTurnJump)) tell(i, "does not end at the handover");
    }
  }

  void checkOpening(std::size_t i) {
    const Manipulator& arm = armOf(i);
    const Holder& holder = plan_.solution.holders[stages_[i].holder];
    const Eigen::VectorXd fingers = arm.fingersOf(q_[arm.robot]);
    if (fingers.size() > 0 &&
        (fingers - arm.grasp(static_cast<int>(holder.grasp)).open).cwiseAbs().maxCoeff() >
            kJoined) {
      tell(i, "the gripper is not at the grasp's opening");
    }
  }

  /// Two opposing contacts of the grasp at the object, of two links that are there.
  void checkGrip(std::size_t i) {
    const Manipulator& arm = armOf(i);
    if (arm.hand->suction) return;  // the tool's pose is all of it, see "the object jumps"
    const Holder& holder = plan_.solution.holders[stages_[i].holder];
    const Grasp& grasp = arm.grasp(static_cast<int>(holder.grasp));
    std::vector<Pose> X_WL;
    linkPoses(*arm.model, arm.placed->X_WB, q_[arm.robot], X_WL);
    world_.reset();
    world_.setRobot(arm.robot, X_WL);
    const BodyId object =
        problem_.collision->objectBody(problem_.scene->findObject(problem_.task.object));
    world_.setPose(object, X_WO_);
    const std::vector<GraspContact> held = contactsHeld(arm, grasp, object);
    const auto opposed = [](const GraspContact& one, const GraspContact& other) {
      return one.link != other.link && one.n_O.dot(other.n_O) < kOpposed;
    };
    for (const GraspContact& one : held) {
      for (const GraspContact& other : held) {
        if (opposed(one, other)) return;
      }
    }
    tell(i, "no two links hold the object from opposite sides");
  }

  /// The grasp's contacts whose links are at the object as the world stands; of a grasp that tells
  /// none, those of the hand's links.
  std::vector<GraspContact> contactsHeld(const Manipulator& arm, const Grasp& grasp,
                                         BodyId object) {
    std::vector<GraspContact> held;
    const auto at = [&](LinkId link) -> std::optional<BodyDistance> {
      const BodyId body = link.valid() ? problem_.collision->linkBody(arm.robot, link) : BodyId();
      return body.valid() ? world_.distance(body, object, kGripDistance) : std::nullopt;
    };
    for (const GraspContact& contact : grasp.contacts) {
      if (at(arm.model->findLink(contact.link))) held.push_back(contact);
    }
    if (!grasp.contacts.empty()) return held;
    for (const LinkId link : arm.hand->links) {
      const auto near = at(link);
      if (!near) continue;
      held.push_back({arm.model->links[link].name, X_WO_.inverse() * near->p_Wb,
                      X_WO_.linear().transpose() * near->n_W});
    }
    return held;
  }

  void checkDexterity(std::size_t i, double claimed) {
    const Manipulator& arm = armOf(i);
    if (arm.kinematics->dofs() < 6) return;
    const double is = arm.kinematics->manipulability(arm.armOf(q_[arm.robot]));
    if (std::abs(is - claimed) > kClaim * is) tell(i, "the dexterity is another one");
  }

  /// Calls visit(time, tool pose) at every sample and in the middle between samples.
  template <typename Visit>
  void alongTool(std::size_t i, const Visit& visit) {
    const StageTrajectory& stage = at(i);
    std::vector<double> q(stage.joints.size());
    for (std::size_t s = 0; s < stage.t.size(); ++s) {
      set(i, stage.q[s]);
      visit(stage.t[s], toolPose(i));
      if (s + 1 == stage.t.size()) break;
      const double h = stage.t[s + 1] - stage.t[s];
      for (std::size_t j = 0; j < q.size(); ++j) {
        q[j] = Quintic({stage.q[s][j], stage.qd[s][j], stage.qdd[s][j]},
                       {stage.q[s + 1][j], stage.qd[s + 1][j], stage.qdd[s + 1][j]}, h)
                   .at(0.5 * h)
                   .q;
      }
      set(i, q);
      visit(stage.t[s] + 0.5 * h, toolPose(i));
    }
  }

  void checkStraight(std::size_t i) {
    set(i, at(i).q.back());
    const Pose end = toolPose(i);
    set(i, at(i).q.front());
    const Pose begin = toolPose(i);
    const Eigen::Vector3d way = end.translation() - begin.translation();
    const double length = way.norm();
    const Eigen::Vector3d along = length > 0 ? Eigen::Vector3d(way / length) : way;
    double farthest = 0, turned = angleBetween(begin.linear(), end.linear());
    alongTool(i, [&](double, const Pose& X_WT) {
      const Eigen::Vector3d offset = X_WT.translation() - begin.translation();
      const double s = std::clamp(offset.dot(along), 0.0, length);
      farthest = std::max(farthest, (offset - s * along).norm());
      turned = std::max(turned, angleBetween(begin.linear(), X_WT.linear()));
    });
    if (farthest > kStraight || turned > kStraightTurn) tell(i, "is not straight");
    if (stages_[i].action == StageAction::kLift && along.z() < std::cos(kUpwards)) {
      tell(i, "does not go straight up");
    }
    if (stages_[i].action == StageAction::kRetreat && length < kClearDistance) {
      tell(i, "is too short to let go");
    }
  }

  void checkTilt(std::size_t i) {
    if (!tilt_) return;
    double most = 0;
    alongTool(i, [&](double, const Pose& X_WT) {
      const Pose X_WO = X_WT * X_TO_[stages_[i].holder];
      most = std::max(most, tiltOf(X_WO.linear() * tilt_->axis_O));
    });
    if (most > tilt_->most + kTiltTolerance) tell(i, "the object leans too far");
  }

  /// When a retreat's tool is first so far that its hand is clear, at the latest.
  double clearAfter(std::size_t i) {
    set(i, at(i).q.front());
    const Eigen::Vector3d begin = toolPose(i).translation();
    std::optional<double> clear;
    alongTool(i, [&](double t, const Pose& X_WT) {
      if (!clear && (X_WT.translation() - begin).norm() >= kClearDistance) clear = t;
    });
    return clear.value_or(at(i).t.back());
  }

  /// The most that `stage` waits of `other`, by the edges listed; < 0: it does not wait for it.
  double waits(std::size_t stage, std::size_t other) {
    const auto [entry, fresh] = waits_.try_emplace({stage, other}, -1.0);
    if (!fresh) return entry->second;
    double most = -1;
    for (const StageProgress& edge : at(stage).after) {
      if (edge.stage == other) most = std::max(most, edge.progress);
      if (edge.stage >= stage) continue;
      const double before = waits(edge.stage, other);
      if (before >= 0) most = std::max(most, before + edge.progress);
    }
    waits_[{stage, other}] = most;
    return most;
  }

  void checkOrder() {
    std::vector<int> arms;
    for (const Manipulator& arm : arms_) arms.push_back(1024 * arm.robot.value() + arm.arm.value());
    for (std::size_t i = 0; i < stages_.size(); ++i) {
      for (const StageProgress& edge : at(i).after) {
        if (edge.stage >= stages_.size() ||
            at(i).start + kSameTime < at(edge.stage).start + edge.progress) {
          tell(i, "starts before what it waits for");
          return;
        }
      }
      for (const Precedence& before : precedenceOf(stages_, i, arms)) {
        const bool clear = before.progress == Progress::kClear;
        const double needed =
            clear ? clearTime(before.stage) - kLeastGap : at(before.stage).t.back();
        if (waits(i, before.stage) + kSameTime < needed) {
          tell(i, "does not wait for stage " + std::to_string(before.stage));
        }
      }
    }
  }

  /// When the hand is clear, as the half sample before it tells: the first 5 mm may end between.
  double clearTime(std::size_t retreat) {
    const double at_the_latest = clearAfter(retreat);
    double before = 0;
    for (const double t : at(retreat).t) {
      if (t < at_the_latest) before = t;
    }
    return before;
  }

  const TransportProblem& problem_;
  const TransportPlan& plan_;
  CollisionWorld& world_;
  std::vector<TaskStage> stages_;
  std::vector<Manipulator> arms_;         ///< by holder
  std::vector<Pose> X_TO_;                ///< by holder
  std::vector<std::vector<DofId>> dofs_;  ///< by stage
  std::vector<RobotVector> q_;            ///< by robot, where the replay is
  std::optional<TiltLimit> tilt_;
  Pose X_WO_;
  std::map<std::pair<std::size_t, std::size_t>, double> waits_;
  std::vector<std::string> broken_;
};

}  // namespace

std::vector<std::string> brokenRules(const TransportProblem& problem, const TransportPlan& plan,
                                     CollisionWorld& world) {
  return PlanReplay(problem, plan, world).broken();
}

}  // namespace handover
