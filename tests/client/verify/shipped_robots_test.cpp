// SPDX-License-Identifier: Apache-2.0
// The verifier's own reading of the robots and things that we ship.
#include "verify/body.hpp"
#include "verify/kinematics.hpp"
#include "verify/mesh.hpp"
#include "verify/robot.hpp"
#include "verify/robot_settings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <random>
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

std::vector<std::string> jointsOfGroup(const Robot& robot, const std::string& name) {
  for (const Group& group : robot.groups) {
    if (group.name == name) return jointNames(robot, group.joints);
  }
  return {};
}

TEST(ShippedRobots, CrichtonHasTwoArmsOfSevenAndHandsOfSeven) {
  const Robot robot = shipped("crichton");
  for (const std::string side : {"left", "right"}) {
    EXPECT_THAT(jointsOfGroup(robot, side), SizeIs(7));
    EXPECT_EQ(jointsOfGroup(robot, side).front(), side + "_L1_joint");
    EXPECT_THAT(jointsOfGroup(robot, side + "_hand"), SizeIs(7));  // an eighth follows the knuckle
  }
}

TEST(ShippedRobots, HubosArmsAreThoseOfItsSrdf) {
  const Robot robot = shipped("hubo");
  EXPECT_THAT(jointsOfGroup(robot, "left"),
              ElementsAre("LSP", "LSR", "LSY", "LEP", "LWY", "LWP", "LWR"));
  EXPECT_THAT(jointsOfGroup(robot, "left_hand"), SizeIs(9));
  EXPECT_THAT(jointsOfGroup(robot, "right_hand"), SizeIs(12));
}

/// The yaml's bounds of every joint of a group.
void expectBounds(const std::string& name, const std::string& group, double acceleration) {
  const Robot robot = shipped(name);
  const RobotSettings settings = readRobotSettings(folder(name) / (name + ".yaml"), robot);
  const std::vector<std::string> joints = jointsOfGroup(robot, group);
  EXPECT_FALSE(joints.empty()) << group;
  for (const std::string& joint : joints) {
    const JointBounds& bounds = settings.bounds[static_cast<std::size_t>(robot.findJoint(joint))];
    ASSERT_TRUE(bounds.acceleration.has_value()) << joint;
    EXPECT_DOUBLE_EQ(*bounds.acceleration, acceleration) << joint;
  }
}

TEST(ShippedRobots, AreRunAsTheirYamlFilesSay) {
  for (const std::string side : {"left", "right"}) {
    expectBounds("crichton", side, 0.4);
    expectBounds("crichton", side + "_hand", 5);
    expectBounds("hubo", side, 0.8);
    expectBounds("hubo", side + "_hand", 5);
  }
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

/// The least distance from a vertex of one to a triangle of the other: never below the true one.
double vertexDistance(const std::vector<Mesh>& a, const std::vector<Mesh>& b, const Pose& X_BA) {
  double least = 1e9;
  for (const Mesh& mesh_a : a) {
    for (const Eigen::Vector3d& vertex : mesh_a.vertices) {
      const Eigen::Vector3d p = X_BA * vertex;
      for (const Mesh& mesh_b : b) {
        for (const Triangle& t : mesh_b.triangles) {
          const auto corner = [&](int k) { return mesh_b.vertices[static_cast<std::size_t>(k)]; };
          const Eigen::Vector3d foot =
              nearestOnTriangle(p, corner(t[0]), corner(t[1]), corner(t[2]));
          least = std::min(least, (p - foot).norm());
        }
      }
    }
  }
  return least;
}

// The advancement along a motion trusts these distances: one that is too large would hide a
// contact.
TEST(ShippedRobots, DistancesOfTheirMeshesAreNeverTooLarge) {
  const std::vector<std::string> files = {"crichton/meshes/sdh_tip.obj", "crichton/meshes/L4.obj",
                                          "hubo/meshes/Body_LWR.obj", "objects/cup/cup.obj",
                                          "objects/hammer/hammer.obj"};
  std::mt19937 random(9);
  std::uniform_real_distribution<double> value(-1, 1);
  int near = 0;
  for (const std::string& file_a : files) {
    for (const std::string& file_b : files) {
      const auto mesh_a = readMesh(folder(file_a), {1, 1, 1});
      const auto mesh_b = readMesh(folder(file_b), {1, 1, 1});
      const auto bodyOf = [](const std::vector<Mesh>& meshes) {
        return Body({{Pose::Identity(), MeshFile{"", {1, 1, 1}}}},
                    [&](const MeshFile&) { return meshes; });
      };
      const Body a = bodyOf(mesh_a), b = bodyOf(mesh_b);
      for (int i = 0; i < 40; ++i) {
        Pose X_BA = Pose::Identity();
        X_BA.linear() =
            Eigen::Quaterniond(value(random), value(random), value(random), value(random))
                .normalized()
                .toRotationMatrix();
        X_BA.translation() =
            (a.radius() + b.radius()) *
            Eigen::Vector3d(value(random), value(random), value(random)).normalized() *
            (0.5 + 0.5 * std::abs(value(random)));
        const Clearance gap = clearance(a, X_BA, b, Pose::Identity(), 0.2);
        if (gap.touching) continue;
        const double bound = std::min(vertexDistance(mesh_a, mesh_b, X_BA),
                                      vertexDistance(mesh_b, mesh_a, X_BA.inverse()));
        EXPECT_LE(gap.distance, bound + 1e-9) << file_a << " and " << file_b;
        if (gap.distance < 0.2) ++near;
      }
    }
  }
  EXPECT_GT(near, 300);
}

}  // namespace
}  // namespace handover::verify
