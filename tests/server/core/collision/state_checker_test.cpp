// SPDX-License-Identifier: Apache-2.0
#include "core/collision/state_checker.hpp"

#include "small_robots.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace handover::test {
namespace {

constexpr double kQuarter = 1.57079632679489661923;

Pose at(double x, double y, double z) {
  Pose X = Pose::Identity();
  X.translation() = Eigen::Vector3d(x, y, z);
  return X;
}

ArmVector arm(double first, double second) {
  ArmVector q(2);
  q << first, second;
  return q;
}

class StateCheckerTest : public testing::Test {
 protected:
  StateCheckerTest() {
    Scene scene = twoArmScene();
    model_ = scene.robots[0].model;
    scene.objects.push_back(boxObject("post", {0.1, 0.1, 0.1}, {0.15, 0.7, 0}));
    scene.objects.push_back(boxObject("ball", {0.02, 0.02, 0.02}, {3, 3, 3}));
    SceneObject tray = boxObject("tray", {0.1, 0.1, 0.02}, {0, 0, 0});
    tray.attached_to = Attachment{RobotId(0), model_->findLink("right_palm"), at(0, 0, 0.1), {}};
    scene.objects.push_back(tray);
    scene_ = std::make_shared<const CollisionScene>(scene);
    world_ = std::make_unique<CollisionWorld>(scene_);
  }

  const CollisionScene& scene() const { return world_->scene(); }

  StateCheckerSetup setup(int arm_index) const {
    return {scene(), RobotId(0), model_->arms[arm_index].dofs};
  }

  BodyId link(const char* name) const {
    return scene().linkBody(RobotId(0), model_->findLink(name));
  }

  std::shared_ptr<const RobotModel> model_;
  std::shared_ptr<const CollisionScene> scene_;
  std::unique_ptr<CollisionWorld> world_;
};

TEST_F(StateCheckerTest, FindsContactWithTheWorldAndWithTheRobot) {
  StateChecker left(*world_, setup(0));
  EXPECT_TRUE(left.valid(arm(0, 0)));
  const auto post = left.hit(arm(kQuarter, 0));  // straight along +y through the post
  ASSERT_TRUE(post);
  EXPECT_TRUE(post->a == scene().objectBody(ObjectId(0)) ||
              post->b == scene().objectBody(ObjectId(0)));
  // Folded back, its fingers reach into the base.
  const auto folded = left.contacts(arm(0, 3.05));
  bool base = false;
  for (const BodyContact& it : folded) base = base || it.a == link("base") || it.b == link("base");
  EXPECT_TRUE(base);
  EXPECT_FALSE(left.valid(arm(0, 3.05)));
}

TEST_F(StateCheckerTest, LinksThatMoveAsOneAreNotTested) {
  // Fingers shut into each other: no matter while only the arm moves, a hit when the fingers do.
  StateCheckerSetup shut = setup(0);
  shut.q[0][2] = -0.01;
  StateChecker left(*world_, shut);
  EXPECT_TRUE(left.valid(arm(0.3, 0)));
  StateChecker fingers(*world_, {scene(), RobotId(0), model_->hands[0].dofs});
  EXPECT_FALSE(fingers.valid(Eigen::VectorXd::Constant(1, -0.01)));
  EXPECT_TRUE(fingers.valid(Eigen::VectorXd::Constant(1, 0.01)));
}

TEST_F(StateCheckerTest, ItsPartsSayTogetherWhatTheWholeSays) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> angle(-3.1, 3.1), finger(-0.01, 0.03);
  StateCheckerSetup with_tool = setup(0);
  with_tool.tool_link = model_->findLink("left_palm");
  StateChecker parts(*world_, with_tool);
  CollisionWorld other_world(scene_);
  int free = 0, tool = 0, rest = 0;
  for (int round = 0; round < 2000; ++round) {
    RobotVector posture = RobotVector::Zero(model_->dofs());
    posture[2] = finger(random);  // a light change of posture: only fingers move
    parts.setPosture(RobotId(0), posture);
    StateCheckerSetup anew = setup(0);
    anew.q[0] = posture;
    StateChecker whole(other_world, anew);
    const ArmVector q = arm(angle(random), angle(random));
    std::vector<Pose> X_WL;
    RobotVector all = posture;
    all.head(2) = q;
    linkPoses(*model_, Pose::Identity(), all, X_WL);
    const bool tool_touches = parts.toolTouches(X_WL[with_tool.tool_link]).has_value();
    const bool arm_touches = parts.armTouches(q, StateChecker::ArmPart::kAll).has_value();
    EXPECT_EQ(whole.valid(q), !tool_touches && !arm_touches);
    EXPECT_EQ(parts.valid(q), whole.valid(q));
    free += !tool_touches && !arm_touches;
    tool += tool_touches;
    rest += arm_touches;
  }
  EXPECT_GT(free, 20);
  EXPECT_GT(tool, 20);
  EXPECT_GT(rest, 20);
}

TEST_F(StateCheckerTest, CarriesTheHeldObject) {
  StateCheckerSetup holding = setup(0);
  holding.held = HeldObject{ObjectId(1), model_->findLink("left_palm"), at(0.1, 0, 0.12)};
  StateChecker left(*world_, holding);
  EXPECT_TRUE(left.valid(arm(0.5, 0)));
  const Pose X_WO = world_->pose(scene().objectBody(ObjectId(1)));
  const Pose X_WPalm = world_->pose(link("left_palm"));
  EXPECT_TRUE(X_WO.isApprox(X_WPalm * at(0.1, 0, 0.12)));
  left.setHold(at(0, 0, 0.02));  // into the palm, with which it moves
  EXPECT_TRUE(left.valid(arm(0.5, 0)));
  EXPECT_TRUE(world_->pose(scene().objectBody(ObjectId(1)))
                  .isApprox(world_->pose(link("left_palm")) * at(0, 0, 0.02)));
  // Held far out, only the object reaches the post.
  left.setHold(at(0, 0.08, 0.5));
  left.setObject(ObjectId(0), at(0.85, 0.08, 0.5));
  const auto hit = left.hit(arm(0, 0));
  ASSERT_TRUE(hit);
  EXPECT_EQ(std::min(hit->a, hit->b), scene().objectBody(ObjectId(0)));
  EXPECT_EQ(std::max(hit->a, hit->b), scene().objectBody(ObjectId(1)));
}

TEST_F(StateCheckerTest, CarriesWhatTheSceneAttaches) {
  StateChecker right(*world_, setup(1));
  ASSERT_TRUE(right.valid(arm(0.4, 0.2)));
  EXPECT_TRUE(world_->pose(scene().objectBody(ObjectId(2)))
                  .isApprox(world_->pose(link("right_palm")) * at(0, 0, 0.1)));
  right.setObject(ObjectId(0), at(-0.85, 0, 0.1));  // the post where the tray is at q = 0
  const auto hit = right.hit(arm(0, 0));
  ASSERT_TRUE(hit);
  EXPECT_TRUE(hit->a == scene().objectBody(ObjectId(2)) ||
              hit->b == scene().objectBody(ObjectId(2)));
}

TEST_F(StateCheckerTest, AllowedPairsAreLeftOut) {
  StateCheckerSetup touching = setup(0);
  const std::vector<BodyId> post{scene().objectBody(ObjectId(0))};
  touching.allowed.insert(
      scene().linkBodies(RobotId(0), model_->linksMovedBy({DofId(0), DofId(1)})), post);
  StateChecker left(*world_, touching);
  EXPECT_TRUE(left.valid(arm(kQuarter, 0)));
}

TEST_F(StateCheckerTest, SharesItsWorldWithOthers) {
  StateChecker left(*world_, setup(0));
  StateCheckerSetup elsewhere = setup(1);
  elsewhere.q[0][0] = kQuarter;  // the left arm in the post
  elsewhere.X_WO[0] = at(0.85, 0, 0);
  StateChecker right(*world_, elsewhere);
  EXPECT_TRUE(left.valid(arm(0, 0)));
  EXPECT_TRUE(right.valid(arm(0, 0)));
  EXPECT_TRUE(world_->pose(scene().objectBody(ObjectId(0))).isApprox(at(0.85, 0, 0)));
  EXPECT_TRUE(left.valid(arm(0, 0)));  // the post is back, the right arm as well
  EXPECT_FALSE(left.valid(arm(kQuarter, 0)));
  world_->setPose(scene().objectBody(ObjectId(0)), at(0.85, 0, 0));
  EXPECT_TRUE(left.valid(arm(0, 0)));
}

TEST_F(StateCheckerTest, AgreesWithAWorldSetFromOutside) {
  StateChecker left(*world_, setup(0));
  CollisionWorld other(std::make_shared<const CollisionScene>([&] {
    Scene scene = twoArmScene();
    scene.objects.push_back(boxObject("post", {0.1, 0.1, 0.1}, {0.15, 0.7, 0}));
    return scene;
  }()));
  const PairList pairs = other.makePairs(
      other.scene().linkBodies(RobotId(0), model_->linksMovedBy({DofId(0), DofId(1)})),
      BodyPairs(other.scene().bodies()));
  std::mt19937 random(3);
  std::vector<Pose> X_WL;
  int hits = 0;
  for (int i = 0; i < 2000; ++i) {
    RobotVector q = RobotVector::Zero(model_->dofs());
    q[2] = q[5] = 0.02;
    q[0] = 2.9 * (static_cast<double>(random()) / 2147483648.0 - 1);
    q[1] = 3.1 * (static_cast<double>(random()) / 2147483648.0 - 1);
    linkPoses(*model_, Pose::Identity(), q, X_WL);
    other.setRobot(RobotId(0), X_WL);
    const bool free = other.isFree(pairs);
    EXPECT_EQ(left.valid(q.head(2)), free);
    hits += free ? 0 : 1;
  }
  EXPECT_GT(hits, 100);
  EXPECT_LT(hits, 1900);
}

TEST_F(StateCheckerTest, RefusesWhatDoesNotFit) {
  EXPECT_THROW(StateChecker(*world_, {scene(), RobotId(0), {DofId(99)}}), std::invalid_argument);
  StateCheckerSetup holding = setup(0);
  holding.held = HeldObject{ObjectId(7), LinkId(0), Pose::Identity()};
  EXPECT_THROW(StateChecker(*world_, holding), std::invalid_argument);
  StateChecker left(*world_, setup(0));
  EXPECT_THROW(left.valid(Eigen::VectorXd::Zero(3)), std::invalid_argument);
  EXPECT_THROW(left.valid(arm(std::numeric_limits<double>::quiet_NaN(), 0)), std::invalid_argument);
  EXPECT_THROW(left.setHold(Pose::Identity()), std::invalid_argument);
}

}  // namespace
}  // namespace handover::test
