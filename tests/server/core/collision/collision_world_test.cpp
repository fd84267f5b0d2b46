// SPDX-License-Identifier: Apache-2.0
#include "core/collision/collision_scene.hpp"
#include "small_robots.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace handover::test {
namespace {

Pose at(double x, double y, double z) {
  Pose X = Pose::Identity();
  X.translation() = Eigen::Vector3d(x, y, z);
  return X;
}

class CollisionWorldTest : public testing::Test {
 protected:
  CollisionWorldTest() {
    Scene scene = twoArmScene();
    scene.objects.push_back(boxObject("cube", {0.1, 0.1, 0.1}, {2, 0, 0}));
    // Two parts with a gap of 0.2 between them.
    SceneObject fork = boxObject("fork", {0.1, 0.1, 0.1}, {2, 2, 0});
    fork.shapes[0].X_BS = at(-0.15, 0, 0);
    fork.shapes.push_back(fork.shapes[0]);
    fork.shapes[1].X_BS = at(0.15, 0, 0);
    scene.objects.push_back(fork);
    SceneObject tray = boxObject("tray", {0.1, 0.1, 0.02}, {0, 0, 0});
    tray.attached_to =
        Attachment{RobotId(0), scene.robots[0].model->findLink("right_palm"), at(0, 0, 0.2), {}};
    scene.objects.push_back(tray);
    model_ = scene.robots[0].model;
    scene_ = std::make_shared<const CollisionScene>(scene);
    world_ = std::make_unique<CollisionWorld>(scene_);
    cube_ = scene_->objectBody(ObjectId(0));
    fork_ = scene_->objectBody(ObjectId(1));
    tray_ = scene_->objectBody(ObjectId(2));
  }

  std::shared_ptr<const RobotModel> model_;
  std::shared_ptr<const CollisionScene> scene_;
  std::unique_ptr<CollisionWorld> world_;
  BodyId cube_, fork_, tray_;
};

TEST_F(CollisionWorldTest, ResetPutsEverythingInPlace) {
  const BodyId palm = scene_->linkBody(RobotId(0), model_->findLink("left_palm"));
  EXPECT_TRUE(world_->pose(palm).isApprox(at(0.85, 0, 0)));
  EXPECT_TRUE(world_->pose(tray_).translation().isApprox(Eigen::Vector3d(-0.85, 0, 0.2), 1e-9));
  world_->setPose(cube_, at(9, 9, 9));
  world_->reset();
  EXPECT_TRUE(world_->pose(cube_).isApprox(at(2, 0, 0)));
}

TEST_F(CollisionWorldTest, AttachedObjectsFollowTheirLink) {
  RobotVector q = RobotVector::Zero(model_->dofs());
  q[3] = std::acos(0.0);  // the right arm, which points along -x, turned to -y
  std::vector<Pose> X_WL;
  linkPoses(*model_, Pose::Identity(), q, X_WL);
  world_->setRobot(RobotId(0), X_WL);
  EXPECT_TRUE(world_->pose(tray_).translation().isApprox(Eigen::Vector3d(-0.15, -0.7, 0.2), 1e-9));
}

TEST_F(CollisionWorldTest, FindsTheTouchingPairAndItsDepth) {
  const BodyId palm = scene_->linkBody(RobotId(0), model_->findLink("left_palm"));
  const PairList pairs = world_->makePairs({cube_}, BodyPairs(scene_->bodies()));
  EXPECT_TRUE(world_->isFree(pairs));
  world_->setPose(cube_, at(0.85, 0.125, 0));  // 5 mm into the palm's side, none else
  BodyContact hit;
  EXPECT_FALSE(world_->isFree(pairs, &hit));
  EXPECT_EQ(hit.a, cube_);
  EXPECT_EQ(hit.b, palm);
  EXPECT_NEAR(hit.depth, 0.005, 1e-6);
  const std::vector<BodyContact> all = world_->contacts(pairs);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].b, palm);
  BodyPairs allowed(scene_->bodies());
  allowed.insert(palm, cube_);
  EXPECT_TRUE(world_->isFree(world_->makePairs({cube_}, allowed)));
}

TEST_F(CollisionWorldTest, ShapesOfOneBodyAreSeparate) {
  const PairList pairs = world_->makePairs({fork_}, BodyPairs(scene_->bodies()));
  world_->setPose(fork_, at(2, 0, 0));  // the cube stands in the gap
  EXPECT_TRUE(world_->isFree(pairs));
  const auto between = world_->distance(fork_, cube_, 0.5);
  ASSERT_TRUE(between);
  EXPECT_NEAR(between->distance, 0.05, 1e-7);
  world_->setPose(fork_, at(2.06, 0, 0));
  EXPECT_FALSE(world_->isFree(pairs));
}

TEST_F(CollisionWorldTest, DistanceGivesUpBeyondItsLimit) {
  world_->setPose(cube_, at(2, 0, 0));
  world_->setPose(fork_, at(2, 0.3, 0));
  EXPECT_FALSE(world_->distance(cube_, fork_, 0.1));
  const auto found = world_->distance(cube_, fork_, 0.3);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->distance, std::hypot(0.05, 0.2), 1e-7);
  EXPECT_LT(found->n_W.y(), 0);  // from the fork towards the cube
}

TEST_F(CollisionWorldTest, MakesEachPairOnceLessStandingAllowedAndRigidOnes) {
  const BodyId base = scene_->linkBody(RobotId(0), LinkId(0));
  const BodyId palm = scene_->linkBody(RobotId(0), model_->findLink("left_palm"));
  const BodyId finger_a = scene_->linkBody(RobotId(0), model_->findLink("left_finger_a"));
  const BodyId finger_b = scene_->linkBody(RobotId(0), model_->findLink("left_finger_b"));
  BodyPairs allowed(scene_->bodies());
  allowed.insert(finger_a, cube_);
  std::vector<int> rigid(static_cast<std::size_t>(scene_->bodies()), -1);
  const auto has = [](const PairList& list, BodyId a, BodyId b) {
    int count = 0;
    for (const auto& [x, y] : list.pairs()) count += (x == a && y == b) || (x == b && y == a);
    return count;
  };
  const PairList loose = world_->makePairs({finger_a, finger_b, finger_a}, allowed, rigid);
  EXPECT_EQ(has(loose, finger_a, finger_b), 1);
  EXPECT_EQ(has(loose, finger_a, cube_), 0);
  EXPECT_EQ(has(loose, finger_b, cube_), 1);
  EXPECT_EQ(has(loose, finger_a, palm), 0);
  EXPECT_EQ(has(loose, finger_a, base), 1);
  EXPECT_EQ(has(loose, finger_a, finger_a), 0);
  rigid[finger_a] = rigid[finger_b] = 4;
  EXPECT_EQ(has(world_->makePairs({finger_a, finger_b}, allowed, rigid), finger_a, finger_b), 0);
}

TEST_F(CollisionWorldTest, RefusesPosesThatAreNotFinite) {
  Pose broken = Pose::Identity();
  broken.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(world_->setPose(cube_, broken), std::invalid_argument);
  broken = Pose::Identity();
  broken.linear()(1, 2) = std::numeric_limits<double>::infinity();
  EXPECT_THROW(world_->setPose(cube_, broken), std::invalid_argument);
  EXPECT_TRUE(world_->pose(cube_).isApprox(at(2, 0, 0)));
}

}  // namespace
}  // namespace handover::test
