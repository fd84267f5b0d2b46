// SPDX-License-Identifier: Apache-2.0
// Everything in config/ and robots/ loads, and the overrides that the manual shows work on it.
#include "core/kinematics/arm_kinematics.hpp"
#include "settings/cell_file.hpp"
#include "settings/check.hpp"
#include "settings/roots.hpp"

#include <gmock/gmock.h>

#include <algorithm>

namespace handover {
namespace {

namespace fs = std::filesystem;

const fs::path kRoot = HANDOVER_SOURCE_DIR;

TEST(ShippedFiles, AllPassTheCheck) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(kRoot / "config" / "cells")) {
    files.push_back(entry.path());
  }
  for (const auto& folder : fs::directory_iterator(kRoot / "robots")) {
    const std::string name = folder.path().filename().string();
    for (const char* extension : {".yaml", ".urdf", ".srdf"}) {
      const fs::path file = folder.path() / (name + extension);
      if (fs::exists(file)) files.push_back(file);
    }
  }
  if (fs::exists(kRoot / "config" / "handoverd.yaml"))
    files.push_back(kRoot / "config" / "handoverd.yaml");
  ASSERT_GE(files.size(), 7u);
  for (const FileFault& fault : checkFiles(files, kRoot).faults) ADD_FAILURE() << fault.text();
}

class Butler : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    ModelCache models;
    cell_ = new Cell(Cell::load(cellFile("butler", kRoot), kRoot, models));
  }

  static void TearDownTestSuite() { delete cell_; }

  static Cell::Instance apply(const std::vector<Override>& overrides) {
    auto result = cell_->instantiate(overrides, 1);
    if (const auto* faults = std::get_if<std::vector<Fault>>(&result)) {
      throw std::runtime_error(faults->at(0).field + ": " + faults->at(0).message);
    }
    return std::get<Cell::Instance>(std::move(result));
  }

  /// Pose of a link in its robot's root frame.
  static Pose linkInRoot(const SceneRobot& robot, const std::string& link) {
    std::vector<Pose> X_BL;
    linkPoses(*robot.model, Pose::Identity(), robot.q_start, X_BL);
    return X_BL.at(robot.model->findLink(link));
  }

  static Cell* cell_;
};

Cell* Butler::cell_ = nullptr;

TEST_F(Butler, TakesTheManualsOverrides) {
  const Cell::Instance instance = apply({{"robots.hubo.base.xyz", "[1.18,-0.4,0.98]"},
                                         {"robots.hubo.base.rpy_deg", "[0,0,150]"},
                                         {"objects.milk_carton.pose.xyz", "[0.3,-0.8,0.8126]"},
                                         {"tasks.serve.goal.xyz", "[0,0,0.08]"}});
  EXPECT_EQ(instance.scene->robots[1].X_WB.translation(), Eigen::Vector3d(1.18, -0.4, 0.98));
}

TEST_F(Butler, HoldsTheTrayWhereTheToolPoseSays) {
  const SceneRobot hubo = apply({}).scene->robots[1];
  EXPECT_TRUE(linkInRoot(hubo, "right_tool")
                  .translation()
                  .isApprox(Eigen::Vector3d(0.30643, -0.31972, 0.05), 1e-6));
}

TEST_F(Butler, MovesTheTrayByToolPose) {
  const std::vector<Override> higher{
      {"robots.hubo.arms.right.tool.xyz", "[0.30643, -0.31972, 0.08]"}};
  const Cell::Instance before = apply({}), after = apply(higher), again = apply(higher);
  EXPECT_TRUE(linkInRoot(after.scene->robots[1], "right_tool")
                  .translation()
                  .isApprox(Eigen::Vector3d(0.30643, -0.31972, 0.08), 1e-6));
  EXPECT_EQ(after.scene->robots[1].q_start, again.scene->robots[1].q_start);
  EXPECT_NEAR(
      after.tasks[0].X_WO_goal.translation().z() - before.tasks[0].X_WO_goal.translation().z(),
      0.03, 1e-6);
  EXPECT_NE(sceneHash(*before.scene, before.tasks[0]), sceneHash(*after.scene, after.tasks[0]));
}

TEST_F(Butler, RobotsAccelerateAsTheyReallyDid) {
  const auto scene = apply({}).scene;
  for (const SceneRobot& robot : scene->robots) {
    const double body = robot.name == "hubo" ? 0.8 : 0.4;
    for (const DofId dof : IdRange<DofId>(robot.model->dofs())) {
      const bool finger = std::any_of(
          robot.model->hands.begin(), robot.model->hands.end(), [dof](const Hand& hand) {
            return std::find(hand.dofs.begin(), hand.dofs.end(), dof) != hand.dofs.end();
          });
      const Joint& joint = robot.model->joints[robot.model->dof_joints[dof]];
      EXPECT_EQ(joint.acceleration, finger ? 5.0 : body) << joint.name;
    }
  }
}

TEST_F(Butler, RefusesAToolPoseOutOfReachByNameOfTheArm) {
  const auto result = cell_->instantiate({{"robots.hubo.arms.right.tool.xyz", "[2, 0, 0]"}}, 1);
  const auto& faults = std::get<std::vector<Fault>>(result);
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_EQ(faults[0].field, "robots.hubo.arms.right.tool.xyz");
  EXPECT_THAT(faults[0].message, ::testing::HasSubstr("arm 'right' of robot 'hubo' cannot reach"));
}

TEST_F(Butler, ReachesEveryEndOfItsVariations) {
  for (const Variation& variation : cell_->variations()) {
    for (const auto& end : {variation.from, variation.to}) {
      std::string value;
      for (const double number : end)
        value += (value.empty() ? "[" : ", ") + std::to_string(number);
      EXPECT_NO_THROW(apply({{variation.path, value + "]"}})) << variation.path;
    }
  }
}

TEST_F(Butler, SnapshotsKeepJointsWithinTheirLimits) {
  const Cell::Instance instance = apply({});
  const SceneSnapshot shown = snapshot(*instance.scene, instance.tasks.at(0), 1);
  for (const RobotSnapshot& robot : shown.robots) {
    ASSERT_EQ(robot.q_start.size(), robot.limits.size());
    for (std::size_t i = 0; i < robot.q_start.size(); ++i) {
      EXPECT_EQ(robot.q_start[i].first, robot.limits[i].first);
      EXPECT_GE(robot.q_start[i].second, robot.limits[i].second.lower) << robot.q_start[i].first;
      EXPECT_LE(robot.q_start[i].second, robot.limits[i].second.upper) << robot.q_start[i].first;
      EXPECT_GT(robot.limits[i].second.acceleration, 0);
    }
  }
}

}  // namespace
}  // namespace handover
