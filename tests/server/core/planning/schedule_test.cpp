// SPDX-License-Identifier: Apache-2.0
#include "core/planning/schedule.hpp"

#include "small_robots.hpp"

#include <gmock/gmock.h>

#include <cmath>

namespace handover::test {
namespace {

using enum StageAction;

constexpr double kStep = 0.002;  // [s] of our own look at the joint time line

Eigen::VectorXd arm(double first) { return Eigen::Vector2d(first, 0); }

/// Seen from above, two arms of 0.85 m reach for each other: the giver's from (0.15, 0) along +x,
/// the receiver's from (1.45, 0) along -x. Stretched out at angle 0 they would meet.
class ScheduleTest : public testing::Test {
 protected:
  ScheduleTest() {
    auto scene = std::make_shared<Scene>(twoArmScene());
    scene->robots.push_back(scene->robots.front());
    scene->robots[0].name = "g";
    scene->robots[1].name = "r";
    scene->robots[1].X_WB.translation().x() = 1.6;
    scene->objects.push_back(boxObject("box", {0.02, 0.02, 0.02}, {3, 3, 3}));
    problem_.scene = scene;
    problem_.task.object = "box";
    problem_.task.chain = {{RobotId(0), ArmId(0)}, {RobotId(1), ArmId(1)}};
    for (const std::size_t robot : {0, 1}) {
      Manipulator& it = arms_[robot];
      it.robot = RobotId(robot);
      it.arm = ArmId(robot);
      it.placed = &problem_.scene->robots[robot];
      it.model = it.placed->model.get();
      it.arm_model = &it.model->arms[it.arm];
    }
    useScene(scene);
    task_ = makeStages(transportOf(problem_.task, 2));
    paths_.resize(task_.size());
    stages_.resize(task_.size());
    for (const TaskStage& stage : task_) move(stage.holder, stage.action, 0, 0);
  }

  void useScene(const std::shared_ptr<const Scene>& scene) {
    problem_.scene = scene;
    problem_.collision = collisionForTask(*scene, "box");
    context_.reset();
    world_.emplace(problem_.collision);
    context_.emplace(problem_, std::vector<const Manipulator*>{&arms_[0], &arms_[1]}, *world_);
  }

  std::size_t at(std::size_t holder, StageAction action) const {
    std::size_t i = 0;
    while (task_[i].holder != holder || task_[i].action != action) ++i;
    return i;
  }

  /// A stage that turns the arm's first joint.
  void move(std::size_t holder, StageAction action, double from, double to) {
    const std::size_t i = at(holder, action);
    StagePath& stage = paths_[i];
    stage.stage = task_[i];
    stage.mover = &arms_[holder];
    stage.dofs = stage.mover->arm_model->dofs;
    stage.state = context_->startState();
    const Eigen::Vector2d most(3, 3), unit(1, 1);
    const auto path = parameterize({arm(from), arm(to)}, {-most, most, unit, unit, 10 * unit}, {});
    ASSERT_TRUE(path);
    stages_[i] = {&stage, stage.dofs, *path, 0, false};
  }

  std::vector<ScheduledStage> schedule() { return scheduleStages(*context_, stages_, Deadline()); }

  double duration(std::size_t holder, StageAction action) const {
    return stages_[at(holder, action)].path.duration();
  }

  double start(const std::vector<ScheduledStage>& stages, std::size_t holder,
               StageAction action) const {
    return stages[at(holder, action)].start;
  }

  double end(const std::vector<ScheduledStage>& stages, std::size_t holder,
             StageAction action) const {
    return start(stages, holder, action) + duration(holder, action);
  }

  /// Whether the arms touch while a stage of each begins when it is said to.
  bool touch(std::size_t of_giver, std::size_t of_receiver,
             const std::vector<ScheduledStage>& stages) {
    std::vector<LinkId> links;
    for (const LinkId link : IdRange<LinkId>(arms_[0].model->links.size())) links.push_back(link);
    const PairList pairs = world_->makePairs(problem_.collision->linkBodies(RobotId(0), links),
                                             BodyPairs(problem_.collision->bodies()));
    const double last = std::max(stages[of_giver].start + stages_[of_giver].path.duration(),
                                 stages[of_receiver].start + stages_[of_receiver].path.duration());
    for (double t = 0; t <= last; t += kStep) {
      for (const std::size_t i : {of_giver, of_receiver}) {
        const Manipulator& it = *stages_[i].stage->mover;
        const RobotVector q =
            it.withArm(it.placed->q_start, evaluate(stages_[i].path, t - stages[i].start));
        std::vector<Pose> X_WL;
        linkPoses(*it.model, it.placed->X_WB, q, X_WL);
        world_->setRobot(it.robot, X_WL);
      }
      for (const BodyContact& contact : world_->contacts(pairs)) {
        if (problem_.collision->name(contact.b).rfind("r/", 0) == 0) return true;
      }
    }
    return false;
  }

  TransportProblem problem_;
  std::array<Manipulator, 2> arms_;
  std::optional<CollisionWorld> world_;
  std::optional<CollisionContext> context_;
  std::vector<TaskStage> task_;
  std::vector<StagePath> paths_;
  std::vector<TimedStage> stages_;
};

TEST_F(ScheduleTest, KeepsEveryEdgeOfItsOwn) {
  move(0, kReach, -1.5, 1.2);
  move(0, kCarry, 1.2, -1.2);
  move(1, kReach, 1.2, 0);
  move(0, kHome, -1.2, -2.4);
  move(1, kCarry, 0, -1.5);
  const auto stages = schedule();
  for (std::size_t i = 0; i < stages.size(); ++i) {
    for (const StageProgress& edge : stages[i].after) {
      ASSERT_LT(edge.stage, i);
      EXPECT_GT(edge.progress, 0);
      EXPECT_LE(edge.progress, stages_[edge.stage].path.duration());
      EXPECT_LE(stages[edge.stage].start + edge.progress, stages[i].start + 1e-9) << i;
    }
  }
}

TEST_F(ScheduleTest, ReceiverComesAsEarlyAsItHasTheWayFree) {
  // The giver has passed the middle when the receiver arrives from the other side.
  move(0, kCarry, 1.2, -1.2);
  move(1, kReach, -1.2, 0);
  const auto stages = schedule();
  EXPECT_NEAR(start(stages, 1, kGrasp), end(stages, 0, kCarry), 1e-9);
  EXPECT_LT(start(stages, 1, kReach), end(stages, 0, kCarry) - 0.5);
  EXPECT_FALSE(touch(at(0, kCarry), at(1, kReach), stages));
}

TEST_F(ScheduleTest, NobodyComesBeforeTheObjectIsOnItsWay) {
  move(0, kReach, -1.5, 1.2);
  move(0, kLift, 1.2, 1.3);
  move(0, kCarry, 1.3, 1.5);
  move(1, kReach, 1.2, -0.5);
  const auto stages = schedule();
  EXPECT_GE(start(stages, 1, kReach), start(stages, 0, kCarry));
}

TEST_F(ScheduleTest, CrossingArmsWaitUntilTheWayIsFree) {
  // The receiver comes from the side to which the giver leaves.
  move(0, kCarry, 1.2, -1.2);
  move(1, kReach, 1.2, 0);
  auto stages = schedule();
  const double saved = end(stages, 0, kCarry) - start(stages, 1, kReach);
  EXPECT_GT(saved, 0);
  EXPECT_LT(saved, duration(1, kReach) - 0.01);
  EXPECT_FALSE(touch(at(0, kCarry), at(1, kReach), stages));
  // It says whom it waits for.
  EXPECT_THAT(stages[at(1, kReach)].after,
              testing::Contains(testing::Field(&StageProgress::stage, at(0, kCarry))));
  // Not that late for nothing.
  stages[at(1, kReach)].start -= duration(1, kReach) / 8;
  EXPECT_TRUE(touch(at(0, kCarry), at(1, kReach), stages));
}

TEST_F(ScheduleTest, ObjectIsTakenAwayOnceTheGiversHandIsOffIt) {
  move(0, kRetreat, -1.2, -1.4);
  move(0, kHome, -1.4, -2.4);
  move(1, kCarry, 0, -1.5);
  stages_[at(0, kRetreat)].clear = 0.25;
  const auto stages = schedule();
  EXPECT_NEAR(start(stages, 1, kCarry), start(stages, 0, kRetreat) + 0.25, 1e-9);
  EXPECT_THAT(stages[at(1, kCarry)].after,
              testing::Contains(StageProgress{static_cast<std::uint32_t>(at(0, kRetreat)), 0.25}));
}

TEST_F(ScheduleTest, LastReleaseDoesNotWaitForAnybodysWayHome) {
  move(0, kHome, -1.2, -2.9);
  move(1, kCarry, 0, -0.1);
  const auto stages = schedule();
  EXPECT_NEAR(start(stages, 1, kRelease), end(stages, 1, kPlace), 1e-9);
  EXPECT_LT(start(stages, 1, kRelease), end(stages, 0, kHome));
}

TEST_F(ScheduleTest, StagesThatGoOnStartWhereTheOthersEnd) {
  move(0, kReach, -1.5, 1.2);
  move(0, kApproach, 1.2, 1.3);
  stages_[at(0, kApproach)].goes_on = true;
  const auto stages = schedule();
  EXPECT_NEAR(start(stages, 0, kApproach), end(stages, 0, kReach), 1e-12);
  EXPECT_THAT(stages[at(0, kApproach)].after,
              testing::ElementsAre(StageProgress{0, duration(0, kReach)}));
}

TEST_F(ScheduleTest, CarriedObjectsCount) {
  move(0, kCarry, 1.2, -1.2);
  move(1, kReach, -1.2, 0);
  const double free_start = start(schedule(), 1, kReach);
  // A long rod across the giver's hand sweeps what the arm alone leaves free.
  auto scene = std::make_shared<Scene>(*problem_.scene);
  scene->objects[0] = boxObject("box", {0.04, 1.4, 0.04}, {3, 3, 3});
  useScene(scene);
  for (const StageAction action : {kLift, kCarry}) {
    CellState& state = paths_[at(0, action)].state;
    state.holder = &arms_[0];
    state.X_TO = Pose::Identity();
  }
  EXPECT_GT(start(schedule(), 1, kReach), free_start);
}

TEST_F(ScheduleTest, IsTheSameWhateverTheWorldWasUsedFor) {
  move(0, kCarry, 1.2, -1.2);
  move(1, kReach, 1.2, 0);
  const auto starts = [&] {
    std::vector<double> all;
    for (const ScheduledStage& stage : schedule()) all.push_back(stage.start);
    return all;
  };
  const std::vector<double> first = starts();
  touch(at(0, kCarry), at(1, kReach), schedule());
  EXPECT_EQ(starts(), first);
}

}  // namespace
}  // namespace handover::test
