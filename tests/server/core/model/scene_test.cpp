// SPDX-License-Identifier: Apache-2.0
#include "core/model/scene.hpp"

#include <gmock/gmock.h>

#include <functional>
#include <set>

namespace handover {
namespace {

RobotModel smallModel() {
  RobotModel model;
  model.name = "small";
  model.urdf_path = "robots/small/small.urdf";
  model.srdf_path = "robots/small/small.srdf";
  model.urdf_sha256 = std::string(64, 'a');
  model.links.push_back(Link{"base", {}, {Shape{Pose::Identity(), BoxShape{{1, 2, 3}}}}});
  for (int i = 0; i < 3; ++i) {
    Joint joint;
    joint.name = "j" + std::to_string(i);
    joint.type = i == 1 ? JointType::kFixed : JointType::kRevolute;
    joint.parent_link = LinkId(i);
    joint.child_link = LinkId(i + 1);
    joint.lower = -1;
    joint.upper = 1;
    joint.velocity = 2;
    joint.acceleration = 3;
    joint.jerk = 30;
    if (i == 0) {
      joint.dof = DofId(0);
      model.dof_joints.push_back(JointId(0));
    }
    if (i == 2) {
      joint.dof = DofId(0);
      joint.mimic = true;
      joint.mimic_multiplier = -0.5;
    }
    model.joints.push_back(joint);
    model.links.push_back(Link{"l" + std::to_string(i), JointId(i), {}});
  }
  return model;
}

struct Case {
  Scene scene;
  SceneTask task;
  RobotModel model = smallModel();  ///< put into the scene by hashOf

  Case() {
    scene.cell = "cell";
    SceneRobot robot;
    robot.name = "r";
    robot.q_start = RobotVector::Constant(1, 0.4);
    robot.resting = {{LinkId(0), "floor"}};
    scene.robots.push_back(robot);
    SceneObject floor;
    floor.name = "floor";
    floor.geometry = BoxGeometry{{6, 6, 0.04}};
    floor.shapes = {Shape{Pose::Identity(), BoxShape{{6, 6, 0.04}}}};
    SceneObject cup = floor;
    cup.name = "cup";
    cup.X_WO.translation() << 1, 0, 0;
    cup.resting = {"floor"};
    SceneObject tray = floor;
    tray.name = "tray";
    tray.attached_to = Attachment{RobotId(0), LinkId(1), Pose::Identity(), {LinkId(1), LinkId(2)}};
    scene.objects = {floor, cup, tray};
    task.name = "serve";
    task.object = "cup";
    task.chain = {{RobotId(0), {}}, {RobotId(0), {}}};
    task.X_WO_start = scene.objects[1].X_WO;
    task.X_WO_goal.translation() << 2, 0, 0;
    task.goal_rest.objects = {"tray"};
  }

  void placeModel() { scene.robots[0].model = std::make_shared<const RobotModel>(model); }

  std::string hash() {
    placeModel();
    return sceneHash(scene, task);
  }
};

using Change = std::function<void(Case&)>;

std::string hashAfter(const Change& change) {
  Case changed;
  change(changed);
  return changed.hash();
}

TEST(SceneHash, ChangesWithEverythingThatCanChangeAPlan) {
  const std::vector<Change> changes = {
      [](Case& c) { c.scene.robots[0].X_WB.translation().x() = 0.1; },
      [](Case& c) { c.scene.robots[0].q_start[0] = 0.41; },
      [](Case& c) { c.scene.robots[0].resting.clear(); },
      [](Case& c) { c.scene.robots[0].name = "s"; },
      [](Case& c) { c.model.urdf_sha256[0] = 'b'; },
      [](Case& c) { c.model.joints[0].upper = 1.1; },
      [](Case& c) { c.model.joints[0].velocity = 1; },
      [](Case& c) { c.model.joints[0].acceleration = 1; },
      [](Case& c) { c.model.joints[0].jerk = 1; },
      [](Case& c) { c.model.joints[2].mimic_multiplier = 0.5; },
      [](Case& c) { c.model.joints[0].X_PJ.translation().z() = 1; },
      [](Case& c) { c.model.links[0].collision.clear(); },
      [](Case& c) { std::get<BoxShape>(c.model.links[0].collision[0].geometry).size.x() = 2; },
      [](Case& c) { c.model.arms.emplace_back(); },
      [](Case& c) { c.model.hands.emplace_back(); },
      [](Case& c) {
        c.model.disabled_pairs[{LinkId(0), LinkId(1)}] = "Never";
      },
      [](Case& c) {
        c.scene.objects[1].name = "mug";
        c.task.object = "mug";
      },
      [](Case& c) { c.scene.objects[0].X_WO.translation().z() = 0.1; },
      [](Case& c) { c.scene.objects[0].shapes[0].X_BS.translation().z() = 0.1; },
      [](Case& c) { c.scene.objects[0].shapes[0].geometry = SphereShape{1}; },
      [](Case& c) {
        c.scene.objects[0].shapes[0].geometry = ConvexShape{{{0, 0, 0}}, {{0, 0, 0}}};
      },
      [](Case& c) { c.scene.objects[1].resting.clear(); },
      [](Case& c) { c.scene.objects[2].attached_to.reset(); },
      [](Case& c) { c.scene.objects[2].attached_to->touch_links = {LinkId(1)}; },
      [](Case& c) { c.scene.objects[2].attached_to->X_LO.translation().x() = 1; },
      [](Case& c) { std::swap(c.scene.objects[0], c.scene.objects[2]); },
      [](Case& c) { c.task.X_WO_start.translation().x() = 1.1; },
      [](Case& c) { c.task.X_WO_goal.translation().x() = 1.1; },
      [](Case& c) { c.task.goal_rest.objects = {"floor"}; },
      [](Case& c) { c.task.goal_rest.none = true; },
      [](Case& c) { c.task.start_rest.objects = {"floor"}; },
      [](Case& c) { c.task.chain[0].arm = ArmId(1); },
      [](Case& c) { c.task.chain.pop_back(); },
      [](Case& c) { c.task.end = TransportEnd::kHold; },
      [](Case& c) {
        c.task.held_by = ChainHolder{RobotId(0), ArmId(0)};
      },
      [](Case& c) { c.model.joints[0].jerk = 31; },
  };
  std::set<std::string> hashes{Case().hash()};
  for (std::size_t i = 0; i < changes.size(); ++i) {
    EXPECT_TRUE(hashes.insert(hashAfter(changes[i])).second) << "change " << i;
  }
}

TEST(SceneHash, LeavesOutWhatCannotChangeAPlan) {
  const std::vector<Change> changes = {
      [](Case& c) { c.scene.revision = 7; },
      [](Case& c) { c.scene.cell = "other"; },
      [](Case& c) { c.task.name = "other"; },
      [](Case& c) { c.scene.objects[1].grasp_counts["r"]["hand"] = 5; },
      [](Case& c) { c.scene.robots[0].X_WB.translation().y() = -0.0; },
      // The task says where its object starts.
      [](Case& c) { c.scene.objects[1].X_WO.translation().x() = 9; },
      [](Case& c) { c.model.content_hash = modelHash(c.model); },
  };
  const std::string hash = Case().hash();
  EXPECT_EQ(hash.size(), 32u);
  for (std::size_t i = 0; i < changes.size(); ++i) {
    EXPECT_EQ(hashAfter(changes[i]), hash) << "change " << i;
  }
}

TEST(Snapshot, ShowsEveryMovableJointWithItsLimits) {
  Case given;
  given.placeModel();
  const SceneSnapshot shown = snapshot(given.scene, given.task, 5);
  EXPECT_EQ(shown.cell, "cell");
  EXPECT_EQ(shown.task, "serve");
  EXPECT_EQ(shown.seed, 5u);
  EXPECT_EQ(shown.scene_hash, sceneHash(given.scene, given.task));
  ASSERT_EQ(shown.robots.size(), 1u);
  const RobotSnapshot& robot = shown.robots[0];
  EXPECT_EQ(robot.urdf, "robots/small/small.urdf");
  EXPECT_THAT(robot.q_start,
              ::testing::ElementsAre(::testing::Pair("j0", 0.4), ::testing::Pair("j2", -0.2)));
  EXPECT_THAT(robot.limits,
              ::testing::ElementsAre(::testing::Pair("j0", JointLimits{-1, 1, 2, 3, 30}),
                                     ::testing::Pair("j2", JointLimits{-1, 1, 2, 3, 30})));
  EXPECT_THAT(robot.resting, ::testing::ElementsAre(::testing::Pair("base", "floor")));
}

TEST(Snapshot, ShowsTheTasksObjectAtItsStart) {
  Case given;
  given.placeModel();
  given.task.X_WO_start.translation() << 3, 2, 1;
  const SceneSnapshot shown = snapshot(given.scene, given.task, 1);
  EXPECT_EQ(shown.objects[1].X_WO, toValue(given.task.X_WO_start));
  EXPECT_EQ(shown.start.X_WO, toValue(given.task.X_WO_start));
  EXPECT_EQ(shown.goal.X_WO, toValue(given.task.X_WO_goal));
  EXPECT_THAT(shown.goal.rest.objects, ::testing::ElementsAre("tray"));
  EXPECT_THAT(shown.objects[1].resting, ::testing::IsEmpty());
  ASSERT_TRUE(shown.objects[2].attached_to);
  EXPECT_EQ(shown.objects[2].attached_to->link, "l0");
  EXPECT_THAT(shown.objects[2].attached_to->touch_links, ::testing::ElementsAre("l0", "l1"));
}

TEST(StartOf, MovesTheObjectOnlyWhenItStandsElsewhere) {
  Case given;
  given.placeModel();
  const auto scene = std::make_shared<const Scene>(given.scene);
  EXPECT_EQ(startOf(scene, given.task), scene);
  given.task.X_WO_start.translation() << 3, 2, 1;
  const auto moved = startOf(scene, given.task);
  EXPECT_EQ(moved->objects[1].X_WO.translation(), Eigen::Vector3d(3, 2, 1));
  EXPECT_EQ(scene->objects[1].X_WO.translation(), Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(moved->objects[1].resting, scene->objects[1].resting);
  given.task.start_rest.objects = {"shelf"};
  EXPECT_EQ(startOf(scene, given.task)->objects[1].resting, std::vector<std::string>{"shelf"});
}

}  // namespace
}  // namespace handover
