// SPDX-License-Identifier: Apache-2.0
#include "core/planning/overlap.hpp"

#include "small_robots.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace handover::test {
namespace {

using enum StageKind;

constexpr double kStep = 0.002;  // [s] of our own look at the joint time line

Eigen::VectorXd arm(double first) { return Eigen::Vector2d(first, 0); }

/// Seen from above, two arms of 0.85 m reach for each other: the giver's from (0.15, 0) along +x,
/// the receiver's from (1.45, 0) along -x. Stretched out at angle 0 they would meet.
class OverlapTest : public testing::Test {
 protected:
  OverlapTest() {
    auto scene = std::make_shared<Scene>(twoArmScene());
    scene->robots.push_back(scene->robots.front());
    scene->robots[0].name = "g";
    scene->robots[1].name = "r";
    scene->robots[1].X_WB.translation().x() = 1.6;
    scene->objects.push_back(boxObject("box", {0.02, 0.02, 0.02}, {3, 3, 3}));
    problem_.scene = scene;
    problem_.collision = collisionForTask(*scene, "box");
    problem_.task.object = "box";
    problem_.task.giver = "g";
    problem_.task.receiver = "r";
    for (Manipulator* role : {&giver_, &receiver_}) {
      role->robot = role == &giver_ ? 0 : 1;
      role->arm = role == &giver_ ? 0 : 1;
      role->placed = &problem_.scene->robots[static_cast<std::size_t>(role->robot)];
      role->model = role->placed->model.get();
      role->arm_model = &role->model->arms[static_cast<std::size_t>(role->arm)];
    }
    world_.emplace(problem_.collision);
    checkers_.emplace(problem_, giver_, receiver_, *world_);
    paths_.resize(kStageCount);
    stages_.resize(kStageCount);
    for (int kind = 1; kind <= kStageCount; ++kind) move(static_cast<StageKind>(kind), 0, 0);
  }

  static bool givers(StageKind kind) {
    return kind <= kGiverTransfer || kind == kGiverRelease || kind == kGiverRetreat;
  }

  static std::size_t at(StageKind kind) { return static_cast<std::size_t>(kind) - 1; }

  /// A stage that turns the arm's first joint.
  void move(StageKind kind, double from, double to) {
    StagePath& stage = paths_[at(kind)];
    stage.kind = kind;
    stage.mover = givers(kind) ? &giver_ : &receiver_;
    stage.dofs = stage.mover->arm_model->dofs;
    stage.state = checkers_->startState();
    const Eigen::Vector2d most(3, 3), unit(1, 1);
    const auto path = parameterize({arm(from), arm(to)}, {-most, most, unit, unit, 10 * unit}, {});
    ASSERT_TRUE(path);
    stages_[at(kind)] = {&stage, *path, 0};
  }

  double duration(StageKind kind) const { return stages_[at(kind)].path.duration(); }

  /// Whether the arms touch while the giver's stage and the receiver's begin when they are said to.
  bool touch(StageKind of_giver, StageKind of_receiver, const std::vector<double>& starts) {
    const TimedStage& g = stages_[at(of_giver)];
    const TimedStage& r = stages_[at(of_receiver)];
    std::vector<int> links(giver_.model->links.size());
    for (std::size_t i = 0; i < links.size(); ++i) links[i] = static_cast<int>(i);
    const PairList pairs = world_->makePairs(problem_.collision->linkBodies(0, links),
                                             BodyPairs(problem_.collision->bodies()));
    const double end = std::max(starts[at(of_giver)] + g.path.duration(),
                                starts[at(of_receiver)] + r.path.duration());
    for (double t = 0; t <= end; t += kStep) {
      for (const TimedStage* it : {&g, &r}) {
        const Manipulator& role = *it->stage->mover;
        const RobotVector q =
            role.withArm(role.placed->q_start, evaluate(it->path, t - starts[at(it->stage->kind)]));
        std::vector<Pose> X_WL;
        linkPoses(*role.model, role.placed->X_WB, q, X_WL);
        world_->setRobot(role.robot, X_WL);
      }
      for (const BodyContact& contact : world_->contacts(pairs)) {
        const std::string& other = problem_.collision->name(contact.b);
        if (other.rfind("r/", 0) == 0) return true;
      }
    }
    return false;
  }

  HandoverProblem problem_;
  Manipulator giver_, receiver_;
  std::optional<CollisionWorld> world_;
  std::optional<CollisionContext> checkers_;
  std::vector<StagePath> paths_;
  std::vector<TimedStage> stages_;
};

TEST_F(OverlapTest, ReceiverComesAsEarlyAsItHasTheWayFree) {
  // The giver has passed the middle when the receiver arrives from the other side.
  move(kGiverTransfer, 1.2, -1.2);
  move(kReceiverReach, -1.2, 0);
  const std::vector<double> starts = startTimes(*checkers_, stages_);
  const double carried = starts[at(kGiverTransfer)] + duration(kGiverTransfer);
  EXPECT_NEAR(starts[at(kReceiverGrasp)], carried, 1e-9);
  EXPECT_NEAR(starts[at(kReceiverReach)] + duration(kReceiverReach) + duration(kReceiverApproach),
              carried, 1e-9);
  EXPECT_FALSE(touch(kGiverTransfer, kReceiverReach, starts));
}

TEST_F(OverlapTest, ReceiverNeverComesBeforeTheLift) {
  move(kGiverReach, -1.5, 1.2);
  move(kGiverLift, 1.2, 1.3);
  move(kGiverTransfer, 1.3, 1.5);
  move(kReceiverReach, 1.2, -0.5);
  const std::vector<double> starts = startTimes(*checkers_, stages_);
  EXPECT_NEAR(starts[at(kReceiverReach)], starts[at(kGiverLift)], 1e-12);
  EXPECT_GE(starts[at(kReceiverReach)], starts[at(kGiverLift)]);
  EXPECT_GT(starts[at(kReceiverGrasp)], starts[at(kGiverTransfer)] + duration(kGiverTransfer));
}

TEST_F(OverlapTest, CrossingArmsWaitUntilTheWayIsFree) {
  // The receiver comes from the side to which the giver leaves.
  move(kGiverTransfer, 1.2, -1.2);
  move(kReceiverReach, 1.2, 0);
  const std::vector<double> starts = startTimes(*checkers_, stages_);
  const double carried = starts[at(kGiverTransfer)] + duration(kGiverTransfer);
  const double saved = carried - starts[at(kReceiverReach)];
  EXPECT_GT(saved, 0);
  EXPECT_LT(saved, duration(kReceiverReach) - 0.01);
  EXPECT_FALSE(touch(kGiverTransfer, kReceiverReach, starts));
  // Not that late for nothing.
  std::vector<double> earlier = starts;
  earlier[at(kReceiverReach)] -= duration(kReceiverReach) / 8;
  EXPECT_TRUE(touch(kGiverTransfer, kReceiverReach, earlier));
}

TEST_F(OverlapTest, ObjectIsTakenAwayOnceTheGiversHandIsOffIt) {
  move(kGiverRetreat, -1.2, -2.4);
  move(kReceiverTransfer, 0, -1.5);
  stages_[at(kGiverRetreat)].early = 0.5;
  const std::vector<double> starts = startTimes(*checkers_, stages_);
  EXPECT_NEAR(starts[at(kReceiverTransfer)], starts[at(kGiverRetreat)] + 0.5, 1e-12);
  EXPECT_GE(starts[at(kReceiverTransfer)], starts[at(kGiverRetreat)] + 0.5);
  EXPECT_GE(starts[at(kReceiverRelease)], starts[at(kGiverRetreat)] + duration(kGiverRetreat));
}

TEST_F(OverlapTest, CarriedObjectsCount) {
  move(kGiverTransfer, 1.2, -1.2);
  move(kReceiverReach, -1.2, 0);
  const double free_start = startTimes(*checkers_, stages_)[at(kReceiverReach)];
  // A long rod across the giver's hand sweeps what the arm alone leaves free.
  auto scene = std::make_shared<Scene>(*problem_.scene);
  scene->objects[0] = boxObject("box", {0.04, 1.4, 0.04}, {3, 3, 3});
  problem_.scene = scene;
  problem_.collision = collisionForTask(*scene, "box");
  world_.emplace(problem_.collision);
  checkers_.emplace(problem_, giver_, receiver_, *world_);
  for (const StageKind kind : {kGiverLift, kGiverTransfer}) {
    CellState& state = paths_[at(kind)].state;
    state.holder = &giver_;
    state.X_TO = Pose::Identity();
  }
  EXPECT_GT(startTimes(*checkers_, stages_)[at(kReceiverReach)], free_start);
}

TEST_F(OverlapTest, IsTheSameWhateverTheWorldWasUsedFor) {
  move(kGiverTransfer, 1.2, -1.2);
  move(kReceiverReach, 1.2, 0);
  const std::vector<double> starts = startTimes(*checkers_, stages_);
  touch(kGiverTransfer, kReceiverReach, starts);
  EXPECT_EQ(startTimes(*checkers_, stages_), starts);
}

}  // namespace
}  // namespace handover::test
