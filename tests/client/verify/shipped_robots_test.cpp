// SPDX-License-Identifier: Apache-2.0
// The verifier's own reading of the robots and things that we ship.
#include "verify/kinematics.hpp"
#include "verify/mesh.hpp"
#include "verify/robot.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <variant>
#include <vector>

namespace handover::verify {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::SizeIs;

fs::path folder(const std::string& name) { return fs::path(HANDOVER_SOURCE_DIR) / "robots" / name; }

Robot shipped(const std::string& name) {
  return readRobot(folder(name) / (name + ".urdf"), folder(name) / (name + ".srdf"));
}

std::string linkName(const Robot& robot, int link) {
  return robot.links[static_cast<std::size_t>(link)].name;
}

std::vector<std::string> jointNames(const Robot& robot, const std::vector<int>& joints) {
  std::vector<std::string> names;
  for (const int j : joints) names.push_back(robot.joints[static_cast<std::size_t>(j)].name);
  return names;
}

Pose linkPose(const Robot& robot, const std::string& link) {
  std::vector<Pose> X_WL;
  Kinematics(robot, Pose::Identity())
      .linkPoses(std::vector<double>(robot.joints.size(), 0.0), X_WL);
  return X_WL[static_cast<std::size_t>(robot.findLink(link))];
}

TEST(ShippedRobots, CrichtonHasTwoArmsOfSevenAndHandsOfSeven) {
  const Robot robot = shipped("crichton");
  for (const std::string side : {"left", "right"}) {
    const Arm arm = robot.arm(side + "_grasp_link");
    EXPECT_EQ(jointNames(robot, arm.joints).front(), side + "_L1_joint");
    EXPECT_THAT(arm.joints, SizeIs(7));
    EXPECT_THAT(arm.hand_joints, SizeIs(7));  // eight, of which one follows the knuckle
    EXPECT_EQ(linkName(robot, arm.palm_link), side + "_palm_link");
  }
}

TEST(ShippedRobots, HubosPalmIsItsLastArmLink) {
  const Robot robot = shipped("hubo");
  EXPECT_THAT(jointNames(robot, robot.arm("left_tool").joints),
              ElementsAre("LSP", "LSR", "LSY", "LEP", "LWY", "LWP", "LWR"));
  EXPECT_EQ(linkName(robot, robot.arm("left_tool").palm_link), "Body_LWR");
  EXPECT_THAT(robot.arm("left_tool").hand_joints, SizeIs(9));
  EXPECT_THAT(robot.arm("right_tool").hand_joints, SizeIs(12));
}

// Places published with the models (ana-GT/commonData @ 258f6e1), all joints at zero.
TEST(ShippedRobots, StandWhereTheirModelsSay) {
  const Robot crichton = shipped("crichton");
  EXPECT_TRUE(linkPose(crichton, "left_L7_link")
                  .translation()
                  .isApprox(Eigen::Vector3d(0, 1.026, 1.23), 1e-6));
  EXPECT_TRUE(linkPose(crichton, "right_L7_link")
                  .translation()
                  .isApprox(Eigen::Vector3d(0, -1.026, 1.23), 1e-6));
  EXPECT_TRUE(linkPose(crichton, "left_grasp_link")
                  .translation()
                  .isApprox(Eigen::Vector3d(0, 1.176, 1.23), 1e-6));
  const Robot hubo = shipped("hubo");
  EXPECT_TRUE(linkPose(hubo, "Body_LWR")
                  .translation()
                  .isApprox(Eigen::Vector3d(0.001, 0.2295, -0.4352), 1e-6));
  EXPECT_TRUE(linkPose(hubo, "right_tool")
                  .translation()
                  .isApprox(Eigen::Vector3d(0.001, -0.2295, -0.5652), 1e-6));
}

TEST(ShippedRobots, EveryMeshPartIsASolid) {
  std::size_t parts = 0;
  for (const char* where : {"crichton", "hubo", "objects"}) {
    for (const auto& entry : fs::recursive_directory_iterator(folder(where))) {
      if (entry.path().extension() != ".obj") continue;
      for (const Mesh& mesh : readMesh(entry.path(), {1, 1, 1})) {
        for (const Shell& shell : shellsOf(mesh)) {
          EXPECT_TRUE(shell.closed) << entry.path();
          ++parts;
        }
      }
    }
  }
  EXPECT_GT(parts, 100u);
}

}  // namespace
}  // namespace handover::verify
