// SPDX-License-Identifier: Apache-2.0
#include "core/collision/collision_scene.hpp"

#include "small_robots.hpp"

#include <gtest/gtest.h>

namespace handover::test {
namespace {

// Pairs by name, so that the tests read like the design.
class Standing {
 public:
  explicit Standing(const Scene& scene) : scene_(scene) {}

  bool operator()(const std::string& a, const std::string& b) const {
    return scene_.standingPairs().contains(body(a), body(b));
  }

 private:
  BodyId body(const std::string& name) const {
    for (const BodyId id : IdRange<BodyId>(scene_.bodies())) {
      if (scene_.name(id) == name) return id;
    }
    throw std::invalid_argument(name);
  }

  CollisionScene scene_;
};

TEST(CollisionScene, EveryLinkWithShapesAndEveryObjectIsABody) {
  Scene scene = twoArmScene();
  auto model = std::make_shared<RobotModel>(*scene.robots[0].model);
  model->links[model->findLink("head")].collision.clear();
  scene.robots[0].model = model;
  scene.objects.push_back(boxObject("cup", {0.1, 0.1, 0.1}, {2, 0, 0}));
  const CollisionScene world(scene);
  EXPECT_EQ(world.bodies(), static_cast<int>(model->links.size()));
  EXPECT_FALSE(world.linkBody(RobotId(0), model->findLink("head")).valid());
  EXPECT_EQ(world.name(world.linkBody(RobotId(0), model->findLink("left_palm"))),
            "two_arms/left_palm");
  EXPECT_EQ(world.name(world.objectBody(ObjectId(0))), "cup");
}

TEST(CollisionScene, LinksJoinedByAJointStand) {
  const Standing standing(twoArmScene());
  EXPECT_TRUE(standing("two_arms/base", "two_arms/left_upper"));
  EXPECT_TRUE(standing("two_arms/left_upper", "two_arms/left_lower"));
  EXPECT_TRUE(standing("two_arms/base", "two_arms/head"));
  EXPECT_TRUE(standing("two_arms/left_palm", "two_arms/left_finger_a"));
  // Through the fixed palm joint: lower arm and fingers.
  EXPECT_TRUE(standing("two_arms/left_lower", "two_arms/left_finger_a"));
  EXPECT_TRUE(standing("two_arms/left_upper", "two_arms/left_palm"));
  EXPECT_FALSE(standing("two_arms/left_finger_a", "two_arms/left_finger_b"));
  EXPECT_FALSE(standing("two_arms/base", "two_arms/left_lower"));
  EXPECT_FALSE(standing("two_arms/left_upper", "two_arms/right_upper"));
}

TEST(CollisionScene, DisabledPairsStandByReason) {
  Scene scene = twoArmScene();
  auto model = std::make_shared<RobotModel>(*scene.robots[0].model);
  const auto disable = [&](const char* a, const char* b, const char* reason) {
    model->disabled_pairs[{model->findLink(a), model->findLink(b)}] = reason;
  };
  disable("base", "left_lower", "Always");
  disable("base", "left_palm", "Adjacent");
  disable("base", "right_lower", "Never");
  scene.robots[0].model = model;
  const Standing standing(scene);
  EXPECT_TRUE(standing("two_arms/base", "two_arms/left_lower"));
  EXPECT_TRUE(standing("two_arms/base", "two_arms/left_palm"));
  EXPECT_FALSE(standing("two_arms/base", "two_arms/right_lower"));
}

TEST(CollisionScene, AttachmentsAndRestingPairsStand) {
  Scene scene = twoArmScene();
  const RobotModel& model = *scene.robots[0].model;
  scene.objects.push_back(boxObject("floor", {4, 4, 0.1}, {0, 0, -1}));
  scene.objects.push_back(boxObject("table", {0.5, 0.5, 0.1}, {0, 2, -0.9}));
  scene.objects[1].resting = {"floor"};
  scene.objects.push_back(boxObject("tray", {0.1, 0.1, 0.1}, {0, 0, 0}));
  scene.objects[2].attached_to = Attachment{
      RobotId(0), model.findLink("left_palm"), Pose::Identity(), {model.findLink("left_finger_a")}};
  scene.robots[0].resting = {{model.findLink("base"), "floor"}};
  const Standing standing(scene);
  EXPECT_TRUE(standing("table", "floor"));
  EXPECT_TRUE(standing("two_arms/base", "floor"));
  EXPECT_TRUE(standing("tray", "two_arms/left_palm"));
  EXPECT_TRUE(standing("tray", "two_arms/left_finger_a"));
  EXPECT_FALSE(standing("tray", "two_arms/left_finger_b"));
  EXPECT_FALSE(standing("tray", "floor"));
}

TEST(CollisionScene, RefusesRestingOnWhatIsNotThere) {
  Scene scene = twoArmScene();
  scene.robots[0].resting = {{LinkId(0), "moon"}};
  EXPECT_THROW(CollisionScene{scene}, std::invalid_argument);
}

}  // namespace
}  // namespace handover::test
