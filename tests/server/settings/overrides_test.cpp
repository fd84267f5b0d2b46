// SPDX-License-Identifier: Apache-2.0
#include "tiny_root.hpp"

#include <gmock/gmock.h>

#include <thread>

namespace handover {
namespace {

using handover::testing::TinyRoot;
using ::testing::ElementsAre;

class Overrides : public ::testing::Test {
 protected:
  Cell::Instance apply(const std::vector<Override>& overrides) const {
    auto result = cell_.instantiate(overrides, 1);
    if (const auto* faults = std::get_if<std::vector<Fault>>(&result)) {
      throw std::runtime_error(faults->at(0).field + ": " + faults->at(0).message);
    }
    return std::get<Cell::Instance>(std::move(result));
  }

  std::vector<std::string> faultsOf(const std::vector<Override>& overrides) const {
    auto result = cell_.instantiate(overrides, 1);
    std::vector<std::string> shown;
    if (const auto* faults = std::get_if<std::vector<Fault>>(&result)) {
      for (const Fault& fault : *faults) shown.push_back(fault.field + ": " + fault.message);
    }
    return shown;
  }

  TinyRoot root_;
  Cell cell_ = root_.load();
};

TEST_F(Overrides, ChangeWhatTheyName) {
  const Cell::Instance instance =
      apply({{"robots.right.base.xyz", "[2.5, 0.1, 0]"}, {"tasks.serve.goal.xyz", "[0, 0, 0.04]"}});
  EXPECT_EQ(instance.scene->robots[1].X_WB.translation(), Eigen::Vector3d(2.5, 0.1, 0));
  EXPECT_TRUE(
      instance.tasks[0].X_WO_goal.translation().isApprox(Eigen::Vector3d(2.2, 0.1, 0.54), 1e-12));
  // The cell itself is as it was.
  EXPECT_EQ(std::get<Cell::Instance>(cell_.instantiate({}, 1)).scene->robots[1].X_WB.translation(),
            Eigen::Vector3d(2, 0, 0));
}

TEST_F(Overrides, MayAddKeysThatTheFileLeftOut) {
  const Cell::Instance instance = apply({{"robots.left.base.rpy_deg", "[0, 0, 90]"},
                                         {"robots.right.joints.swing", "0.25"},
                                         {"robots.right.posture", "home"},
                                         {"tasks.serve.start.xyz", "[1, 1, 1]"},
                                         {"tasks.fetch.upright.axis", "[1, 0, 0]"},
                                         {"tasks.fetch.upright.within_deg", "7"}});
  EXPECT_EQ(instance.scene->robots[0].X_WB.linear(),
            rotationFromRpy(0, 0, M_PI / 2).array().round().matrix());
  EXPECT_EQ(instance.scene->robots[1].q_start[0], 0.25);
  EXPECT_EQ(instance.tasks[0].X_WO_start.translation(), Eigen::Vector3d(1, 1, 1));
  EXPECT_EQ(instance.tasks[1].upright, (UprightSnapshot{{1, 0, 0}, 7}));
}

TEST_F(Overrides, MoveARobotWithWhatItStandsOn) {
  const Cell::Instance instance = apply({{"robots.right.base", "{frame: table, xyz: [0, 0.5, 0]}"},
                                         {"objects.table.pose.xyz", "[1, 2, 0.25]"}});
  // The table is turned by 90 degrees; the tray is in the robot's hand.
  EXPECT_TRUE(
      instance.scene->robots[1].X_WB.translation().isApprox(Eigen::Vector3d(0.5, 2, 0.25), 1e-12));
  const ObjectId tray = instance.scene->findObject("tray");
  EXPECT_TRUE(instance.scene->objects[static_cast<std::size_t>(tray)].X_WO.translation().isApprox(
      Eigen::Vector3d(0.5, 2.3, 0.75), 1e-12))
      << instance.scene->objects[static_cast<std::size_t>(tray)].X_WO.translation();
}

TEST_F(Overrides, ApplyInTheirOrder) {
  EXPECT_EQ(apply({{"robots.left.joints.reach", "0.2"}, {"robots.left.joints.reach", "0.3"}})
                .scene->robots[0]
                .q_start[1],
            0.3);
}

TEST_F(Overrides, OfOneKindOfRotationReplaceTheOther) {
  const Cell::Instance instance = apply({{"tasks.fetch.goal.rpy_deg", "[0, 0, 0]"},
                                         {"objects.table.pose.quat_wxyz", "[1, 0, 0, 0]"}});
  EXPECT_EQ(instance.scene->objects[1].X_WO.linear(), Eigen::Matrix3d::Identity());
}

TEST_F(Overrides, MayReplaceAWholeEntry) {
  EXPECT_EQ(apply({{"objects.cup.geometry", "{type: box, size: [0.1, 0.1, 0.1]}"}})
                .scene->objects[3]
                .geometry,
            Geometry(BoxGeometry{{0.1, 0.1, 0.1}}));
}

TEST_F(Overrides, ReachListEntriesByName) {
  using handover::testing::with;
  const std::string fixed = with(handover::testing::kTinyCell,
                                 "  objects.cup.geometry.radius: {choices: [0.03, 0.04]}\n", "");
  const Cell cell = root_.load(
      with(fixed, "{type: sphere, radius: 0.03}",
           "{type: compound, parts: [{name: ball, geometry: {type: sphere, radius: 0.03}}]}"));
  const auto result =
      cell.instantiate({{"objects.cup.geometry.parts.ball.geometry.radius", "0.05"}}, 1);
  const auto& cup = std::get<Cell::Instance>(result).scene->objects[3];
  EXPECT_EQ(std::get<SphereShape>(cup.shapes.at(0).geometry).radius, 0.05);
}

TEST_F(Overrides, AreRefusedWhenUnknown) {
  for (const char* path :
       {"robots.right.base.xzy", "robots.right.base.xyz.x", "robots.right.arm.arm.tool.xyz",
        "floor", "objects.cup.colour", "robots..base", "", ".", "objects.cup.geometry.size"}) {
    const auto faults = faultsOf({{path, "[0, 0, 0]"}});
    ASSERT_EQ(faults.size(), 1u) << path;
    EXPECT_THAT(faults[0], ::testing::StartsWith(std::string(path) + ": "));
    EXPECT_THAT(faults[0], ::testing::HasSubstr("unknown ")) << path;
  }
  EXPECT_THAT(
      faultsOf({{"robots.rigth.base.xyz", "[0, 0, 0]"}}),
      ElementsAre("robots.rigth.base.xyz: unknown path: no 'rigth' in robots; the nearest known "
                  "one is 'robots.right'"));
  EXPECT_THAT(faultsOf({{"robot.right.base.xyz", "[0, 0, 0]"}}),
              ElementsAre("robot.right.base.xyz: unknown path; the nearest known one is 'robots'"));
  EXPECT_THAT(faultsOf({{"version", "1"}}), ElementsAre("version: cannot be overridden"));
  EXPECT_THAT(faultsOf({{"robots", "{}"}}), ElementsAre("robots: names no entry of robots"));
}

TEST_F(Overrides, AreRefusedWhenOfWrongTypeOrNotFinite) {
  for (const char* value : {"[0, .nan, 0]", "[0, .inf, 0]", "[0, nan, 0]", "[0, 1e999, 0]",
                            "[0, 0]", "3", "text", "", "{x: 1}", "[0, [0], 0]", "[0, , 0]"}) {
    EXPECT_EQ(faultsOf({{"objects.table.pose.xyz", value}}).size(), 1u) << value;
  }
  EXPECT_THAT(
      faultsOf({{"objects.table.pose.xyz", "[0, .nan, 0]"}}),
      ElementsAre("objects.table.pose.xyz: objects.table.pose.xyz.1: must be a finite number, not "
                  "'.nan'"));
  EXPECT_THAT(faultsOf({{"objects.table.pose.xyz", "[0, 0"}})[0],
              ::testing::StartsWith("objects.table.pose.xyz: the value is not well-formed YAML: "));
  EXPECT_THAT(faultsOf({{"objects.table.pose.xyz", std::string(3000, '[')}}).size(), 1u);
}

TEST_F(Overrides, AreRefusedWithEveryFault) {
  EXPECT_THAT(
      faultsOf({{"robots.left.joints.reach", "9"}, {"robots.right.posture", "sleep"}}),
      ElementsAre("robots.left.joints.reach: is outside the joint's limits: 9 is not from 0 to 0.5",
                  "robots.right.posture: 'sleep' is no group state of robot 'tiny'; the nearest "
                  "known one is 'home'"));
  // Of different kinds too: an unknown path does not hide a wrong value.
  EXPECT_THAT(faultsOf({{"robots.left.base.xyz", "[0, .nan, 0]"}, {"objects.ghost.pose", "{}"}}),
              ::testing::UnorderedElementsAre(::testing::HasSubstr("objects.ghost"),
                                              ::testing::HasSubstr("robots.left.base.xyz")));
}

TEST_F(Overrides, CannotBringInAModelThatIsNotLoaded) {
  EXPECT_THAT(faultsOf({{"robots.right.model", "hubo"}}),
              ElementsAre("robots.right.model: model 'hubo' was not loaded with this cell"));
}

TEST_F(Overrides, CannotReadFilesOutsideTheRoot) {
  for (const char* path : {"/etc/passwd", "../x.obj", "robots/../../x.obj"}) {
    EXPECT_THAT(
        faultsOf({{"objects.cup.geometry", std::string("{type: mesh, path: ") + path + "}"}}),
        ElementsAre("objects.cup.geometry: objects.cup.geometry.path: must lie inside the root"));
  }
}

TEST_F(Overrides, AreSafeFromManyThreads) {
  std::vector<std::jthread> threads;
  std::vector<int> wrong(4, 0);
  for (std::size_t t = 0; t < wrong.size(); ++t) {
    threads.emplace_back([this, t, &wrong] {
      for (int i = 0; i < 50; ++i) {
        const double x = 2 + 0.001 * i;
        const auto instance =
            apply({{"robots.right.base.xyz", "[" + std::to_string(x) + ", 0, 0]"}});
        if (std::abs(instance.scene->robots[1].X_WB.translation().x() - x) > 1e-9) ++wrong[t];
      }
    });
  }
  threads.clear();
  EXPECT_THAT(wrong, ::testing::Each(0));
}

TEST_F(Overrides, SolveArmPosturesByToolPose) {
  // The palm 0.45 before the axis, 0.5 up.
  const std::vector<Override> overrides{{"robots.left.arms.arm.tool.xyz", "[0.45, 0, 0.5]"}};
  const RobotVector q = apply(overrides).scene->robots[0].q_start;
  EXPECT_NEAR(q[0], 0.0, 1e-6);
  EXPECT_NEAR(q[1], 0.25, 1e-6);
  EXPECT_EQ(apply(overrides).scene->robots[0].q_start, q);
  EXPECT_THAT(
      faultsOf({{"robots.left.arms.arm.tool.xyz", "[3, 0, 0.5]"}}),
      ElementsAre("robots.left.arms.arm.tool.xyz: robots.left.arms.arm.tool: arm 'arm' of robot "
                  "'left' cannot reach this pose within its limits"));
  EXPECT_THAT(faultsOf({{"robots.left.arms.leg.tool.xyz", "[3, 0, 0.5]"}}),
              ElementsAre("robots.left.arms.leg.tool.xyz: robots.left.arms.leg: robot 'tiny' has "
                          "no such arm; the nearest known one is 'arm'"));
}

}  // namespace
}  // namespace handover
