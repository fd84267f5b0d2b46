// SPDX-License-Identifier: Apache-2.0
#include "core/planning/scene_validity.hpp"

#include "core/planning/collision_context.hpp"
#include "support/meshes.hpp"

#include <gmock/gmock.h>

namespace handover {
namespace {

using Eigen::Vector3d;

const Vector3d kHalf(0.02, 0.03, 0.06);

SceneObject box(const std::string& name, const Vector3d& size, double z) {
  SceneObject object;
  object.name = name;
  object.shapes = {Shape{Pose::Identity(), BoxShape{size}}};
  object.X_WO.translation().z() = z;
  return object;
}

/// A thing whose one part stands 5 mm off its surface, its bottom `gap` above a table.
std::optional<Failed> checkOf(double gap, SceneTask* checked = nullptr) {
  auto scene = std::make_shared<Scene>();
  scene->objects = {box("table", {1, 1, 0.1}, -0.05),
                    box("thing", 2 * (kHalf.array() + 0.005), kHalf.z() + gap)};
  scene->objects[1].divided = std::make_shared<const DividedBodies>(
      DividedBodies{{test::boxMesh(-kHalf, kHalf), 0, 1, 0, 1}});
  TransportProblem problem;
  problem.scene = scene;
  problem.collision = collisionForTask(*scene, "thing");
  problem.task.object = "thing";
  problem.task.X_WO_start = problem.task.X_WO_goal = scene->objects[1].X_WO;
  CollisionWorld world(problem.collision);
  SceneTask task = problem.task;
  auto failed = checkScene(problem, world, task);
  if (checked) *checked = task;
  return failed;
}

TEST(CheckScene, AThingRestsByItsSurfaceNotByItsParts) {
  SceneTask task;
  EXPECT_FALSE(checkOf(0, &task));
  EXPECT_EQ(task.start_rest.objects, (std::vector<std::string>{"table"}));
  EXPECT_FALSE(checkOf(0.0015));
  EXPECT_FALSE(checkOf(-0.0005));
}

TEST(CheckScene, AThingIsInSomethingByItsSurface) {
  const auto failed = checkOf(-0.001);
  ASSERT_TRUE(failed);
  EXPECT_EQ(failed->reason, FailureReason::kStartInCollision);
}

TEST(CheckScene, AThingAboveATableIsToldByHowMuch) {
  const auto failed = checkOf(0.003);  // its part is 2 mm in the table
  ASSERT_TRUE(failed);
  EXPECT_EQ(failed->reason, FailureReason::kStartUnsupported);
  EXPECT_THAT(failed->explanation.text, ::testing::HasSubstr("table is 3.0 mm away"));
}

/// A box of 20 cm over a table, to be held there in the end.
std::optional<Failed> heldOver(double gap) {
  auto scene = std::make_shared<Scene>();
  scene->objects = {box("table", {2, 1, 0.1}, -0.05), box("thing", {0.2, 0.2, 0.2}, 0.1)};
  TransportProblem problem;
  problem.scene = scene;
  problem.collision = collisionForTask(*scene, "thing");
  problem.task.object = "thing";
  problem.task.X_WO_start = problem.task.X_WO_goal = scene->objects[1].X_WO;
  problem.task.X_WO_goal.translation().z() += gap;
  problem.task.end = TransportEnd::kHold;
  CollisionWorld world(problem.collision);
  SceneTask task = problem.task;
  return checkScene(problem, world, task);
}

TEST(CheckScene, AGoalInAHandNearerThanMotionsComeIsNoCollision) {
  for (const double gap : {0.0, 0.001}) {
    const auto failed = heldOver(gap);
    ASSERT_TRUE(failed) << gap;
    EXPECT_EQ(failed->reason, FailureReason::kNoPath);
    EXPECT_FALSE(failed->explanation.exhaustive);
    ASSERT_EQ(failed->explanation.causes.size(), 1u);
    EXPECT_EQ(failed->explanation.causes[0].pair, NamePair("table", "thing"));
  }
  EXPECT_FALSE(heldOver(0.0025));
}

TEST(CheckScene, AGoalInAHandInsideATableIsACollision) {
  const auto failed = heldOver(-0.003);
  ASSERT_TRUE(failed);
  EXPECT_EQ(failed->reason, FailureReason::kGoalInCollision);
  EXPECT_TRUE(failed->explanation.exhaustive);
  EXPECT_THAT(failed->explanation.text, ::testing::HasSubstr("by 3.0 mm"));
}

TEST(CheckScene, TheDepthToldIsThatWhereTheThingIs) {
  const auto failed = checkOf(-0.004);
  ASSERT_TRUE(failed);
  EXPECT_THAT(failed->explanation.text, ::testing::HasSubstr("4.0 mm higher it is free"));
}

TEST(CheckScene, AThingInsideASolidIsInIt) {
  auto scene = std::make_shared<Scene>();
  SceneObject block = box("block", {0.51, 0.51, 0.51}, 0);
  block.divided = std::make_shared<const DividedBodies>(DividedBodies{
      {test::boxMesh(Vector3d::Constant(-0.25), Vector3d::Constant(0.25)), 0, 1, 0, 1}});
  scene->objects = {block, box("thing", 2 * kHalf, 0)};
  TransportProblem problem;
  problem.scene = scene;
  problem.collision = collisionForTask(*scene, "thing");
  problem.task.object = "thing";
  problem.task.X_WO_start = problem.task.X_WO_goal = Pose::Identity();
  CollisionWorld world(problem.collision);
  SceneTask task = problem.task;
  const auto failed = checkScene(problem, world, task);
  ASSERT_TRUE(failed);
  EXPECT_EQ(failed->reason, FailureReason::kStartInCollision);
}

}  // namespace
}  // namespace handover
