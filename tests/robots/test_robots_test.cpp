// SPDX-License-Identifier: Apache-2.0
// The test robots of tests/support and their cells: read like any other, and each arm gets the
// inverse kinematics that its axes allow.
#include "core/collision/collision_scene.hpp"
#include "core/kinematics/arm_kinematics.hpp"
#include "settings/cell_file.hpp"
#include "support/arm_models.hpp"

#include <gtest/gtest.h>

namespace handover {
namespace {

Cell::Instance instanceOf(const std::string& cell) {
  const std::filesystem::path root = HANDOVER_SOURCE_DIR "/tests/support";
  ModelCache models;
  return std::get<Cell::Instance>(
      Cell::load(root / "config/cells" / (cell + ".yaml"), root, models).instantiate({}, 1));
}

const SceneRobot& robotOf(const Scene& scene, const std::string& name) {
  return scene.robots.at(scene.findRobot(name));
}

class OtherArmsCell : public ::testing::TestWithParam<const char*> {
 protected:
  Cell::Instance instance_ = instanceOf(GetParam());
};

INSTANTIATE_TEST_SUITE_P(Support, OtherArmsCell, ::testing::Values("exchange", "offset"),
                         [](const auto& shown) { return std::string(shown.param); });

TEST_P(OtherArmsCell, NeedsBothRobotsForEveryTask) {
  const Scene& scene = *instance_.scene;
  ASSERT_EQ(instance_.tasks.size(), 2u);
  for (const SceneTask& task : instance_.tasks) {
    for (const auto& [robot, X_WO] : {std::pair(task.chain.at(0).robot, task.X_WO_goal),
                                      std::pair(task.chain.at(1).robot, task.X_WO_start)}) {
      const SceneRobot& other = scene.robots.at(robot);
      const double reach = ArmKinematics(*other.model, ArmId(0)).reach();
      EXPECT_GT((X_WO.translation() - other.X_WB.translation()).norm(), reach + 0.1) << other.name;
    }
  }
}

TEST_P(OtherArmsCell, StartsFreeOfContacts) {
  for (const SceneTask& task : instance_.tasks) {
    Scene start = *startOf(instance_.scene, task);
    SceneObject& object = start.objects.at(start.findObject(task.object));
    object.resting = task.start_rest.objects.value();
    CollisionWorld world(std::make_shared<const CollisionScene>(start));
    std::vector<BodyId> all;
    for (const BodyId body : IdRange<BodyId>(world.scene().bodies())) all.push_back(body);
    for (const BodyContact& contact :
         world.contacts(world.makePairs(all, BodyPairs(world.scene().bodies())))) {
      ADD_FAILURE() << world.scene().name(contact.a) << " and " << world.scene().name(contact.b);
    }
  }
}

TEST(OtherArms, HaveTheKinematicsOfTheirTables) {
  const Cell::Instance exchange = instanceOf("exchange"), offset = instanceOf("offset");

  struct Expected {
    const SceneRobot& robot;
    RobotModel arm;
    bool closed_form;
  };

  for (const Expected& expected :
       {Expected{robotOf(*exchange.scene, "ur"), test::ur5eArm(), false},
        Expected{robotOf(*exchange.scene, "iiwa"), test::iiwa14Arm(), true},
        Expected{robotOf(*offset.scene, "panda"), test::pandaArm(), false}}) {
    const ArmKinematics arm(*expected.robot.model, ArmId(0)), table(expected.arm, ArmId(0));
    EXPECT_EQ(arm.closedForm(), expected.closed_form) << expected.robot.name;
    ASSERT_EQ(arm.dofs(), table.dofs());
    EXPECT_LT((arm.lower() - table.lower()).norm() + (arm.upper() - table.upper()).norm(), 1e-5);
    for (const double part : {0.1, 0.35, 0.8}) {
      const ArmVector q = table.lower() + part * (table.upper() - table.lower());
      EXPECT_LT((arm.toolPose(q).matrix() - table.toolPose(q).matrix()).cwiseAbs().maxCoeff(), 1e-9)
          << expected.robot.name;
    }
  }
}

}  // namespace
}  // namespace handover
