// SPDX-License-Identifier: Apache-2.0
#include "core/planning/plan_quality.hpp"

#include "core/planning/plan_clearance.hpp"
#include "small_robots.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace handover::test {
namespace {

using enum StageAction;

constexpr double kDegree = M_PI / 180;
constexpr double kFinger = 0.02;  // where fingers stand [m]

/// Samples at rest, seconds apart.
TimedPath curveOf(const std::vector<Eigen::VectorXd>& q, double step) {
  TimedPath path;
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(q.front().size());
  for (const Eigen::VectorXd& it : q) {
    path.t.push_back(step * static_cast<double>(path.t.size()));
    path.q.push_back(it);
    path.qd.push_back(zero);
    path.qdd.push_back(zero);
  }
  return path;
}

/// Two-arm robots of which each brings the object with its left arm, whose joints have 1 rad/s and
/// 1 rad/s^2; every stage stands still for a second until a test says otherwise.
class PlanQuality : public testing::Test {
 protected:
  explicit PlanQuality(std::size_t holders = 1) {
    scene_ = std::make_shared<Scene>(twoArmScene());
    scene_->objects.push_back(boxObject("box", {0.02, 0.02, 0.02}, {3, 3, 3}));
    scene_->robots.resize(holders, scene_->robots.front());
    for (std::size_t k = 1; k < holders; ++k) {
      scene_->robots[k].name = "other";
      scene_->robots[k].X_WB.translation().y() = 5.0 * static_cast<double>(k);
    }
    Grasp weak, strong;
    weak.quality = 0.1;
    strong.quality = 0.4;
    grasps_.grasps = {strong, weak};
    use(holders);
  }

  /// Takes the scene as it is now.
  void use(std::size_t holders) {
    problem_.scene = scene_;
    problem_.collision = collisionForTask(*scene_, "box");
    problem_.task.object = "box";
    problem_.task.X_WO_start = problem_.task.X_WO_goal = Pose::Identity();
    const RobotModel& model = *scene_->robots.front().model;
    kinematics_.emplace(model, ArmId(0));
    arms_.resize(holders);
    path_.holders.clear();
    for (std::size_t k = 0; k < holders; ++k) {
      Manipulator& arm = arms_[k];
      arm.robot = RobotId(k);
      arm.arm = ArmId(0);
      arm.placed = &scene_->robots[k];
      arm.model = arm.placed->model.get();
      arm.arm_model = &arm.model->arms[0];
      arm.hand = &arm.model->hands[0];
      arm.kinematics = &*kinematics_;
      arm.grasps = &grasps_;
      arm.map.X_WA = arm.placed->X_WB;
      arm.hand_bodies = problem_.collision->linkBodies(arm.robot, arm.hand->links);
      path_.holders.push_back({&arm, 1, {}});
    }
    task_ = makeStages(transportOf(problem_.task, holders));
    path_.stages.assign(task_.size(), {});
    timed_.assign(task_.size(), {});
    schedule_.assign(task_.size(), {});
    for (const TaskStage& stage : task_) move(stage.holder, stage.action, {0, 0}, {0, 0});
  }

  std::size_t at(std::size_t holder, StageAction action) const {
    std::size_t i = 0;
    while (task_[i].holder != holder || task_[i].action != action) ++i;
    return i;
  }

  void setCurve(std::size_t holder, StageAction action, TimedPath curve) {
    const std::size_t i = at(holder, action);
    StagePath& stage = path_.stages[i];
    stage.stage = task_[i];
    stage.mover = &arms_[holder];
    const bool gripper = action == kGrasp || action == kRelease;
    stage.dofs = gripper ? stage.mover->hand->dofs : stage.mover->arm_model->dofs;
    timed_[i] = {&stage, stage.dofs, std::move(curve), 0, false};
  }

  /// A straight motion of a second; of grippers one that stands still.
  void move(std::size_t holder, StageAction action, const Eigen::Vector2d& from,
            const Eigen::Vector2d& to) {
    const bool gripper = action == kGrasp || action == kRelease;
    const Eigen::VectorXd rest = Eigen::VectorXd::Constant(1, kFinger);
    setCurve(holder, action, gripper ? curveOf({rest, rest}, 1) : curveOf({from, to}, 1));
  }

  void grip(std::size_t holder, StageAction action, double from, double to) {
    setCurve(holder, action,
             curveOf({Eigen::VectorXd::Constant(1, from), Eigen::VectorXd::Constant(1, to)}, 1));
  }

  /// One stage after the other.
  void runInTurn() {
    double start = 0;
    for (std::size_t i = 0; i < timed_.size(); ++i) {
      schedule_[i].start = start;
      start += timed_[i].path.duration();
    }
  }

  Quality quality() { return motionQualityOf(problem_, path_, timed_, schedule_); }

  ClearanceQuality clearance(const std::string& between) {
    for (const ClearanceQuality& it : clearanceOf(problem_, path_, timed_, schedule_)) {
      if (it.between == between) return it;
    }
    ADD_FAILURE() << "nothing of " << between;
    return {};
  }

  std::shared_ptr<Scene> scene_;
  GraspSet grasps_;
  TransportProblem problem_;
  std::optional<ArmKinematics> kinematics_;
  std::vector<Manipulator> arms_;
  std::vector<TaskStage> task_;
  TransportPath path_;
  std::vector<TimedStage> timed_;
  std::vector<ScheduledStage> schedule_;
};

class PlanQualityOfAHandover : public PlanQuality {
 protected:
  PlanQualityOfAHandover() : PlanQuality(2) {}
};

TEST_F(PlanQuality, BoundAddsTheMovementsOfOneArm) {
  move(0, kReach, {0, 0}, {0.9, 0});
  move(0, kApproach, {0.9, 0}, {1.1, 0.3});  // with the reach 1.1 rad: 1.1 / 1 + 1 / 1 = 2.1 s
  grip(0, kGrasp, 0.02, 0.01);               // 2 sqrt(0.01) = 0.2 s
  move(0, kLift, {1.1, 0.3}, {1.05, 0.3});
  move(0, kCarry, {1.05, 0.3}, {0.9, 0.3});
  move(0, kPlace, {0.9, 0.3}, {0.92, 0.3});  // lift, carry and place 0.22 rad: 2 sqrt(0.22)
  grip(0, kRelease, 0.01, 0.02);             // 0.2 s
  move(0, kRetreat, {0.92, 0.3}, {0.92, 0.3});
  move(0, kHome, {0.92, 0.3}, {0, 0});  // 2 sqrt(0.92)
  runInTurn();
  EXPECT_NEAR(quality().bound_s, 2.1 + 0.2 + 2 * std::sqrt(0.22) + 0.2 + 2 * std::sqrt(0.92), 1e-9);
  EXPECT_NEAR(quality().duration_s, 9, 1e-12);
}

TEST_F(PlanQualityOfAHandover, BoundLetsArmsMoveAtOnceAndScalesWhatTheyWaitFor) {
  move(0, kReach, {0, 0}, {1, 0});     // 2 s
  move(0, kCarry, {1, 0}, {2.25, 0});  // 1.25 + 1 = 2.25 s; grasps take no time here
  move(1, kReach, {0, 0}, {1, 0});     // 2 s, over before the carry is
  // The hand has left after a quarter of the retreat, which is half of retreat and home: 2 s for
  // both, so the next carry begins 0.25 s after the release. It takes 2.5 s.
  move(0, kRetreat, {2.25, 0}, {1.75, 0});
  move(0, kHome, {1.75, 0}, {1.25, 0});
  timed_[at(0, kRetreat)].clear = 0.25;
  move(1, kCarry, {1, 0}, {2.5, 0});
  runInTurn();
  EXPECT_NEAR(quality().bound_s, 2 + 2.25 + 0.25 + 2.5, 1e-9);
}

TEST_F(PlanQualityOfAHandover, ObjectIsUnderWayFromTheFirstGraspToTheLastRelease) {
  runInTurn();  // a second each: reach approach grasp lift carry, reach approach grasp, release ...
  const Quality found = quality();
  EXPECT_NEAR(found.object_s, 10, 1e-12);
  ASSERT_EQ(found.idle_s.size(), 2u);
  // The giver waits for the other's reach, approach and grasp; that one for release, retreat, home.
  EXPECT_EQ(found.idle_s[0].first, "two_arms");
  EXPECT_NEAR(found.idle_s[0].second, 3, 1e-12);
  EXPECT_EQ(found.idle_s[1].first, "other");
  EXPECT_NEAR(found.idle_s[1].second, 3, 1e-12);
}

TEST_F(PlanQuality, TiltAndTurnOfACarriedObject) {
  // Laid on its side the robot turns the object about a level axis.
  scene_->robots.front().X_WB.linear() =
      Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
  grasps_.grasps[1].X_OT.linear() =
      Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
  use(1);
  const auto turnedBy = [](double angle) {
    Pose X = Pose::Identity();
    X.linear() = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()).toRotationMatrix();
    return X;
  };
  problem_.task.X_WO_goal = turnedBy(0.1);
  move(0, kLift, {0, 0}, {0.2, 0});
  setCurve(
      0, kCarry,
      curveOf({Eigen::Vector2d(0.2, 0), Eigen::Vector2d(0.5, 0.5), Eigen::Vector2d(0.3, 0.1)}, 2));
  move(0, kPlace, {0.3, 0.1}, {0.1, 0});
  runInTurn();
  const Quality found = quality();
  EXPECT_NEAR(found.tilt_deg, 0.9 / kDegree, 0.01);
  EXPECT_NEAR(found.object_turn_deg[0], (0.2 + 0.8 + 0.6 + 0.3) / kDegree, 0.05);
  EXPECT_NEAR(found.object_turn_deg[1], 0.1 / kDegree, 1e-6);
}

TEST_F(PlanQuality, TiltBetweenSamplesIsSeen) {
  scene_->robots.front().X_WB.linear() =
      Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
  grasps_.grasps[1].X_OT.linear() =
      Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
  use(1);
  // There and back in one curve without a sample at the top.
  TimedPath swing = curveOf({Eigen::Vector2d(0, 0), Eigen::Vector2d(0, 0)}, 1.37);
  swing.qd.front()[0] = 1;
  swing.qd.back()[0] = -1;
  double most = 0;
  for (double t = 0; t < 1.37; t += 1e-4) most = std::max(most, evaluate(swing, t)[0]);
  setCurve(0, kCarry, swing);
  runInTurn();
  EXPECT_NEAR(quality().tilt_deg, most / kDegree, 0.01);
  EXPECT_NEAR(quality().object_turn_deg[0], 2 * most / kDegree, 0.05);
}

TEST_F(PlanQuality, GripIsComparedWithTheBestOfItsSet) {
  const Quality found = quality();
  ASSERT_EQ(found.grip.size(), 1u);
  EXPECT_NEAR(found.grip[0].quality, 0.1, 1e-12);
  EXPECT_NEAR(found.grip[0].of_best, 0.25, 1e-12);
}

TEST_F(PlanQuality, LimitMarginIsThatOfTakingAndGivingAlone) {
  // Limits are +-2.9 and +-3.1; the reach passes nearer to one than where the object is taken.
  move(0, kReach, {2.8, 0}, {0, 0});
  move(0, kLift, {0, 0}, {2.85, 0});
  move(0, kCarry, {2.85, 0}, {1, 2.79});
  move(0, kPlace, {1, 2.79}, {1, 2.48});
  EXPECT_NEAR(quality().limit_margin, (3.1 - 2.48) / 6.2, 1e-12);
}

TEST_F(PlanQuality, JerkShareIsTheGreatestOfAllCurves) {
  move(0, kReach, {0, 0}, {0.1, 0});
  // The quintic from rest to rest has jerk 60 d / T^3 at its ends: 6 of 10.
  EXPECT_NEAR(quality().jerk_share, 0.6, 1e-3);
}

TEST_F(PlanQuality, ClearanceOfAnArmThatPassesAWall) {
  // Stretched out, the fingers' corners turn about (0.15, 0) with this radius; the wall's face is
  // flat and 12 mm beyond.
  const double radius = std::hypot(0.85, kFinger + 0.02 + 0.01);
  const double face = 0.15 + radius + 0.012;
  scene_->objects.push_back(boxObject("wall", {0.1, 4, 1}, {face + 0.05, 0, 0}));
  use(1);
  move(0, kReach, {-0.7, 0}, {0.9, 0});
  runInTurn();
  const ClearanceQuality found = clearance("furniture");
  EXPECT_LE(found.least_m, 0.012 + 1e-9);
  EXPECT_GE(found.least_m, 0.012 - kClearanceFineness - 1e-9);
  EXPECT_EQ(found.stage, at(0, kReach));
  EXPECT_EQ(found.pair.second, "wall");
  EXPECT_EQ(found.pair.first.rfind("two_arms/left_finger", 0), 0u) << found.pair.first;
  EXPECT_EQ(clearance("object").pair, NamePair());
}

TEST_F(PlanQuality, ClearanceOfStraightPartsDoesNotCount) {
  scene_->objects.push_back(boxObject("wall", {0.1, 4, 1}, {1.1, 0, 0}));
  use(1);
  move(0, kApproach, {-0.7, 0}, {0.9, 0});
  runInTurn();
  EXPECT_EQ(clearance("furniture").least_m, kMostClearance);
  EXPECT_EQ(clearance("furniture").pair, NamePair());
}

TEST_F(PlanQuality, ClearanceAlongAWallIsProvenInFewLooks) {
  // A carry that keeps 8 mm all the way is no harder than one that comes there once.
  const double radius = std::hypot(0.85, kFinger + 0.02 + 0.01);
  SceneObject ring = boxObject("ring", {0.1, 0.3, 0.1}, {0, 0, 0});
  const Shape one = ring.shapes.front();
  ring.shapes.clear();
  for (double angle = -1.2; angle < 1.25; angle += 0.2) {
    Shape part = one;
    const Eigen::AngleAxisd R(angle, Eigen::Vector3d::UnitZ());
    part.X_BS.linear() = R.toRotationMatrix();
    part.X_BS.translation() =
        Eigen::Vector3d(0.15, 0, 0) + R * Eigen::Vector3d(radius + 0.008 + 0.05, 0, 0);
    ring.shapes.push_back(part);
  }
  scene_->objects.push_back(ring);
  use(1);
  move(0, kCarry, {-0.9, 0}, {0.9, 0});
  runInTurn();
  EXPECT_NEAR(clearance("furniture").least_m, 0.008, kClearanceFineness + 1e-4);
}

TEST_F(PlanQuality, ClearanceOfTheObjectInHand) {
  // The box stands out of the hand by 0.2 m: its far face at x = 1.06, corners 0.01 aside.
  grasps_.grasps[1].X_OT.translation() = Eigen::Vector3d(-0.2, 0, 0);
  const double face = 0.15 + std::hypot(0.91, 0.01) + 0.02;
  scene_->objects.push_back(boxObject("wall", {0.1, 4, 1}, {face + 0.05, 0, 0}));
  use(1);
  move(0, kCarry, {-0.7, 0}, {0.9, 0});
  runInTurn();
  EXPECT_NEAR(clearance("object").least_m, 0.02, kClearanceFineness + 1e-9);
  EXPECT_EQ(clearance("object").pair, NamePair("box", "wall"));
  EXPECT_EQ(clearance("object").stage, at(0, kCarry));
}

TEST_F(PlanQualityOfAHandover, ClearanceIsMeasuredWhereBothMoversAreAtThatTime) {
  // The other robot stands 1.75 m ahead and faces this one. Both swing through the middle: at once
  // they meet, one after the other they have much room.
  scene_->robots[1].X_WB.translation() = Eigen::Vector3d(1.75, 0, 0);
  scene_->robots[1].X_WB.linear() =
      Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  scene_->robots[0].q_start[0] = -1.2;
  scene_->robots[1].q_start[0] = 1.2;
  use(2);
  for (const TaskStage& stage : task_) {
    const double after = stage.holder == 0 ? 1.2 : -1.2;
    move(stage.holder, stage.action, {after, 0}, {after, 0});
  }
  move(0, kReach, {-1.2, 0}, {1.2, 0});
  move(1, kReach, {1.2, 0}, {-1.2, 0});
  runInTurn();
  EXPECT_EQ(clearance("robots").least_m, kMostClearance);
  EXPECT_EQ(clearance("robots").pair, NamePair());
  schedule_[at(1, kReach)].start = 0;
  EXPECT_EQ(clearance("robots").least_m, 0);
  EXPECT_EQ(clearance("robots").stage, at(1, kReach));
}

}  // namespace
}  // namespace handover::test
