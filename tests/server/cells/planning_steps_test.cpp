// SPDX-License-Identifier: Apache-2.0
// The planner's steps by themselves, on the butler cell: arms, scene, pruning, linear and free
// motions.
#include "butler_service.hpp"
#include "cells/request_task.hpp"
#include "core/planning/arm_selection.hpp"
#include "core/planning/explanation.hpp"
#include "core/planning/free_motion.hpp"
#include "core/planning/scene_validity.hpp"
#include "core/planning/transport_motions.hpp"

#include <gmock/gmock.h>

namespace handover::test {
namespace {

using testing::HasSubstr;

class PlanningStepsTest : public testing::Test {
 protected:
  static TransportProblem problemWith(std::vector<Override> overrides) {
    auto problem = butlerService().problemOf(butlerRequest(std::move(overrides)), Deadline());
    EXPECT_TRUE(std::holds_alternative<TransportProblem>(problem));
    return std::get<TransportProblem>(std::move(problem));
  }

  static std::optional<Failed> sceneFault(std::vector<Override> overrides) {
    TransportProblem problem = problemWith(std::move(overrides));
    CollisionWorld world(problem.collision);
    return checkScene(problem, world, problem.task);
  }

  static Override goal(double z) {
    return {"tasks.serve.goal.xyz", "[0, 0, " + std::to_string(z) + "]"};
  }

  static Override start(double z) {
    return {"objects.cup.pose.xyz", "[-0.20, -0.70, " + std::to_string(z) + "]"};
  }

  TransportProblem problem_ = problemWith({});
  RobotId crichton_ = problem_.scene->findRobot("crichton"),
          hubo_ = problem_.scene->findRobot("hubo");
};

TEST_F(PlanningStepsTest, SceneOfTheCellIsValidAndItsRestsAreFound) {
  CollisionWorld world(problem_.collision);
  problem_.task.start_rest = {};
  problem_.task.goal_rest = {};
  EXPECT_FALSE(checkScene(problem_, world, problem_.task));
  EXPECT_EQ(problem_.task.start_rest.objects, std::vector<std::string>{"cart_left"});
  EXPECT_EQ(problem_.task.goal_rest.objects, std::vector<std::string>{"tray"});
}

TEST_F(PlanningStepsTest, GoalInTheTrayOrAboveItIsTold) {
  const auto inside = sceneFault({goal(0.072)});
  ASSERT_TRUE(inside);
  EXPECT_EQ(inside->reason, FailureReason::kGoalInCollision);
  // Of its parts the bottom is 2 mm from the tray's underside, the walls are not.
  EXPECT_THAT(inside->explanation.text,
              HasSubstr("cup is inside tray by 5.0 mm; 5.0 mm higher it is free."));
  EXPECT_THAT(inside->explanation.text, HasSubstr("tray"));
  EXPECT_TRUE(inside->explanation.exhaustive);
  const auto above = sceneFault({goal(0.082)});
  ASSERT_TRUE(above);
  EXPECT_EQ(above->reason, FailureReason::kGoalUnsupported);
  EXPECT_EQ(above->explanation.causes.at(0).cause, Cause::kUnsupported);
  EXPECT_EQ(above->explanation.causes.at(0).pair, NamePair("cup", "tray"));
}

TEST_F(PlanningStepsTest, StartInTheCartOrAboveItIsTold) {
  const auto inside = sceneFault({start(0.890)});
  ASSERT_TRUE(inside);
  EXPECT_EQ(inside->reason, FailureReason::kStartInCollision);
  const auto above = sceneFault({start(0.950)});
  ASSERT_TRUE(above);
  EXPECT_EQ(above->reason, FailureReason::kStartUnsupported);
  EXPECT_THAT(above->explanation.text, HasSubstr("cart_left is 47"));
}

TEST_F(PlanningStepsTest, RestNoneWaivesTheGapButNotTheDepth) {
  TransportProblem problem = problemWith({goal(0.082)});
  problem.task.goal_rest = {true, std::nullopt};
  CollisionWorld world(problem.collision);
  EXPECT_FALSE(checkScene(problem, world, problem.task));
  EXPECT_THAT(*problem.task.goal_rest.objects, testing::IsEmpty());
  TransportProblem inside = problemWith({goal(0.072)});
  inside.task.goal_rest = {true, std::nullopt};
  EXPECT_TRUE(checkScene(inside, world, inside.task));
}

TEST_F(PlanningStepsTest, ArmThatHoldsTheTrayIsNamedSo) {
  const ArmRanking ranking =
      rankArms(problem_, ChainHolder{hubo_, {}}, 1, problem_.task.X_WO_goal, Deadline());
  ASSERT_EQ(ranking.scores.size(), 2u);
  ASSERT_EQ(ranking.arms.size(), 1u);
  EXPECT_EQ(ranking.scores[1].arm, (ArmName{"hubo", "right"}));
  EXPECT_EQ(ranking.scores[1].rejected, Cause::kHoldsObject);
  EXPECT_EQ(ranking.scores[1].object, "tray");
  EXPECT_EQ(ranking.scores[0].rejected, Cause::kUnspecified);
  EXPECT_GT(ranking.scores[0].manipulability, 0);
}

TEST_F(PlanningStepsTest, ArmsTheRequestLeavesOutAreExcludedOrNamedByWhatElseTheyLack) {
  const ArmRanking ranking =
      rankArms(problem_, ChainHolder{hubo_, ArmId(1)}, 1, problem_.task.X_WO_goal, Deadline());
  EXPECT_TRUE(ranking.arms.empty());
  EXPECT_EQ(ranking.scores[0].rejected, Cause::kExcluded);
  const Failed why = explainArms(problem_, PruningPlace::kGoal, ranking);
  EXPECT_EQ(why.reason, FailureReason::kNoGrasp);  // its hand is full, wherever the goal is
  EXPECT_THAT(why.explanation.text, HasSubstr("hubo/left is excluded by the request"));
  EXPECT_THAT(why.explanation.text, HasSubstr("hubo/right holds tray"));
}

TEST_F(PlanningStepsTest, HandsWithoutGraspsAreNoGraspNotUnreachable) {
  for (auto& robot : problem_.resources) {
    for (auto& grasps : robot.grasps) grasps = nullptr;
  }
  const ArmRanking ranking =
      rankArms(problem_, ChainHolder{crichton_, {}}, 0, problem_.task.X_WO_start, Deadline());
  EXPECT_EQ(explainArms(problem_, PruningPlace::kStart, ranking).reason, FailureReason::kNoGrasp);
}

TEST_F(PlanningStepsTest, NoArmOfTheRobotOnTheFarSideReaches) {
  const ArmRanking ranking =
      rankArms(problem_, ChainHolder{hubo_, {}}, 0, problem_.task.X_WO_start, Deadline());
  EXPECT_TRUE(ranking.arms.empty());
  EXPECT_EQ(ranking.scores[0].rejected, Cause::kNotInMap);
}

TEST_F(PlanningStepsTest, WhatIsBeyondAnArmsLengthIsProvenOutOfReach) {
  const Pose X_WO_far(Eigen::Translation3d(7, 0, 1));
  const ArmRanking ranking =
      rankArms(problem_, ChainHolder{crichton_, {}}, 0, X_WO_far, Deadline());
  EXPECT_TRUE(ranking.arms.empty());
  EXPECT_TRUE(ranking.proven);
}

/// The motions of Crichton's right arm alone.
class ArmMotionsTest : public PlanningStepsTest {
 protected:
  ArmMotionsTest() {
    CollisionWorld world(problem_.collision);
    EXPECT_FALSE(checkScene(problem_, world, problem_.task));
    const ArmId arm = problem_.scene->robots[crichton_].model->findArm("right");
    arm_ = makeManipulator(problem_, crichton_, arm);
    motions_.emplace(problem_, std::vector<const Manipulator*>{&arm_}, world_, spare_world_,
                     deadline_);
  }

  StateChecker checker() {
    return motions_->context().makeForArm(motions_->context().startState(), arm_, {});
  }

  Deadline deadline_;
  CollisionWorld world_{problem_.collision}, spare_world_{problem_.collision};
  Manipulator arm_;
  std::optional<TransportMotions> motions_;
};

TEST_F(ArmMotionsTest, PrunedGraspsReachTheCupAndAreFree) {
  const PrunedGrasps pruned = motions_->pruneFirstAtStart(problem_.settings.pruning);
  EXPECT_EQ(pruned.tested, arm_.grasps->grasps.size());
  ASSERT_FALSE(pruned.kept.empty());
  EXPECT_EQ(pruned.kept.size() + pruned.rejects.total(), pruned.tested);
  for (const FeasibleGrasp& kept : pruned.kept) {
    const Pose X_WT = problem_.task.X_WO_start * arm_.grasp(kept.grasp).X_OT;
    EXPECT_TRUE(arm_.toolPose(kept.configurations.front()).isApprox(X_WT, 1e-6));
    CellState open = motions_->context().startState();
    open.of(arm_) = arm_.withFingers(open.of(arm_), arm_.grasp(kept.grasp).open);
    EXPECT_TRUE(motions_->context().makeForArm(open, arm_, {}).valid(kept.configurations.front()));
  }
}

TEST_F(ArmMotionsTest, RetreatsGoStraightBackAndAreFree) {
  const PrunedGrasps pruned = motions_->pruneFirstAtStart(problem_.settings.pruning);
  int found = 0;
  for (const FeasibleGrasp& kept : pruned.kept) {
    const ArmVector& q = kept.configurations.front();
    const Pose X_WT = arm_.toolPose(q);
    CellState open = motions_->context().startState();
    open.of(arm_) = arm_.withFingers(open.of(arm_), arm_.grasp(kept.grasp).open);
    StateChecker open_checker = motions_->context().makeForArm(open, arm_, {});
    const auto back = retreatPath(arm_, q, X_WT, open_checker, problem_.settings.linear_motion);
    if (!back) continue;
    ++found;
    const Eigen::Vector3d way =
        arm_.toolPose(back->waypoints.back()).translation() - X_WT.translation();
    EXPECT_GE(way.norm(), problem_.settings.linear_motion.retreat.back() - 1e-6);
    for (const ArmVector& at : back->waypoints) {
      const Eigen::Vector3d gone = arm_.toolPose(at).translation() - X_WT.translation();
      EXPECT_LT(gone.cross(way.normalized()).norm(), 1e-6);
      EXPECT_TRUE(open_checker.valid(at));
    }
  }
  EXPECT_GT(found, 0);
}

TEST_F(ArmMotionsTest, FreePathsJoinTheirEndsAndAreFreeAtAFinerStep) {
  const PrunedGrasps pruned = motions_->pruneFirstAtStart(problem_.settings.pruning);
  FreeMotionSolver solver(problem_.settings.free_motion, deadline_);
  StateChecker start_checker = checker();
  const ArmVector home = arm_.armOf(motions_->context().startState().of(arm_));
  int found = 0;
  for (const FeasibleGrasp& kept : pruned.kept) {
    const ArmVector& to = kept.configurations.front();
    if (!start_checker.valid(to) || ++found > 10) continue;
    const auto path = solver.solve(arm_, home, to, start_checker, 1);
    if (!path) continue;
    EXPECT_EQ(path->waypoints.front(), home);
    EXPECT_EQ(path->waypoints.back(), to);
    for (std::size_t i = 1; i < path->waypoints.size(); ++i) {
      const ArmVector step = path->waypoints[i] - path->waypoints[i - 1];
      const int parts = 1 + static_cast<int>(step.cwiseAbs().maxCoeff() / 0.01);
      for (int part = 0; part <= parts; ++part) {
        const ArmVector q = path->waypoints[i - 1] + step * (double(part) / parts);
        EXPECT_TRUE(start_checker.valid(q));
      }
    }
  }
  EXPECT_GT(found, 0);
}

TEST_F(ArmMotionsTest, FreePathsFromWhereTheArmTouchesAreRefused) {
  FreeMotionSolver solver(problem_.settings.free_motion, deadline_);
  StateChecker start_checker = checker();
  ArmVector q = arm_.armOf(motions_->context().startState().of(arm_));
  ArmVector folded = q;
  for (int i = 0; i < 400 && start_checker.valid(folded); ++i) {
    folded[1] = q[1] + 0.005 * i;
    folded[3] = q[3] + 0.01 * i;
    folded = folded.cwiseMin(arm_.kinematics->upper()).cwiseMax(arm_.kinematics->lower());
  }
  ASSERT_FALSE(start_checker.valid(folded));
  EXPECT_FALSE(solver.solve(arm_, folded, q, start_checker, 1));
}

TEST(RequestTask, RefusesWhatIsNotBuiltOrContradictsThePaper) {
  PlanRequest request = butlerRequest();
  SceneTask task;
  task.chain = {{RobotId(0), {}}, {RobotId(1), {}}, {RobotId(0), {}}};
  request.search = SearchWidth::kPaper;
  request.objective = Objective::kTime;
  request.slack_s = 0.1;
  std::vector<Fault> faults;
  checkSearch(request, task, faults);
  ASSERT_EQ(faults.size(), 3u);
  EXPECT_EQ(faults[0].field, "search");
  EXPECT_EQ(faults[1].field, "objective");
  EXPECT_EQ(faults[2].field, "slack_s");
}

}  // namespace
}  // namespace handover::test
