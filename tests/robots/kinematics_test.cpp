// SPDX-License-Identifier: Apache-2.0
// Forward kinematics of the robots: against orocos_kdl on random postures, and against poses
// computed from the published models.
#include "kdl_robot.hpp"
#include "robot_files.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace handover {
namespace {

using testing::angleOf;

class RobotKinematics : public ::testing::TestWithParam<const char*> {};

TEST_P(RobotKinematics, AgreesWithKdlOnRandomPostures) {
  const std::string name = GetParam();
  const RobotModel model = testing::loadBody(name);
  const testing::KdlRobot kdl(testing::robotsFolder() / name / (name + ".urdf"));
  std::mt19937_64 generator(20141118);
  std::vector<Pose> X_RL;
  double worst = 0;
  for (int n = 0; n < 1000; ++n) {
    const RobotVector q = testing::randomPosture(model, generator);
    std::map<std::string, double> by_name;
    for (const DofId dof : IdRange<DofId>(model.dofs())) {
      by_name[model.joints[model.dof_joints[dof]].name] = q[dof.value()];
    }
    linkPoses(model, Pose::Identity(), q, X_RL);
    for (std::size_t link = 1; link < model.links.size(); ++link) {
      const KDL::Frame theirs = kdl.pose(model.links[link].name, by_name);
      for (int row = 0; row < 3; ++row) {
        worst = std::max(worst, std::abs(X_RL[link].translation()[row] - theirs.p(row)));
        for (int column = 0; column < 3; ++column) {
          worst =
              std::max(worst, std::abs(X_RL[link].linear()(row, column) - theirs.M(row, column)));
        }
      }
    }
  }
  EXPECT_LT(worst, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Robots, RobotKinematics, ::testing::Values("crichton", "hubo", "person"));

/// The LWA 4D as its maker's partner publishes it (ipa320/schunk_modular_robotics @ b2d73bd,
/// schunk_lwa4d.urdf): another zero posture and other axes than our model's.
RobotModel ipaArm() {
  struct Row {
    const char *joint, *child;
    double z, roll, pitch, yaw;
  };

  constexpr double kRight = std::numbers::pi / 2;
  const Row rows[] = {{"arm_1_joint", "arm_1_link", 0.026 + 0.14, 0, 0, 0},
                      {"arm_2_joint", "arm_2_link", 0.24, -kRight, -kRight, 0},
                      {"arm_3_joint", "arm_3_link", 0, kRight, 0, kRight},
                      {"arm_4_joint", "arm_4_link", 0.328, -kRight, -kRight, 0},
                      {"arm_5_joint", "arm_5_link", 0, kRight, 0, kRight},
                      {"arm_6_joint", "arm_6_link", 0.323, -kRight, -kRight, 0},
                      {"arm_7_joint", "arm_7_link", 0, kRight, 0, kRight},
                      {"", "arm_ee_link", 0.0824, 0, 0, 0}};
  RobotModel model;
  model.links.push_back({"base", {}, {}});
  for (const Row& row : rows) {
    Joint joint;
    joint.name = row.joint;
    joint.type = joint.name.empty() ? JointType::kFixed : JointType::kRevolute;
    joint.parent_link = LinkId(model.links.size() - 1);
    joint.child_link = LinkId(model.links.size());
    joint.X_PJ.translation().z() = row.z;
    joint.X_PJ.linear() = (Eigen::AngleAxisd(row.yaw, Eigen::Vector3d::UnitZ()) *
                           Eigen::AngleAxisd(row.pitch, Eigen::Vector3d::UnitY()) *
                           Eigen::AngleAxisd(row.roll, Eigen::Vector3d::UnitX()))
                              .toRotationMatrix();
    if (joint.type == JointType::kRevolute) {
      joint.dof = DofId(model.dof_joints.size());
      model.dof_joints.push_back(JointId(model.joints.size()));
    }
    model.links.push_back({row.child, JointId(model.joints.size()), {}});
    model.joints.push_back(joint);
  }
  return model;
}

TEST(PublishedPoses, AreOurModelsPoses) {
  std::map<std::string, RobotModel> models;
  models.emplace("crichton", testing::loadBody("crichton"));
  models.emplace("hubo", testing::loadBody("hubo"));
  models.emplace("ipa_lwa4d", ipaArm());
  const RobotModel* model = nullptr;
  std::string set;
  double metres = 0, radians = 0;
  int compared = 0;
  for (const auto& row : testing::readTable(std::filesystem::path(HANDOVER_SOURCE_DIR) /
                                            "tests/robots/published_poses.txt")) {
    if (row[0] == "set") {
      set = row.at(1);
      model = &models.at(row.at(2));
      metres = std::stod(row.at(3));
      radians = std::stod(row.at(4)) * std::numbers::pi / 180;
      continue;
    }
    RobotVector q = RobotVector::Zero(model->dofs());
    for (std::size_t i = 9; i < row.size(); ++i) {
      const auto equals = row[i].find('=');
      const JointId joint = model->findJoint(row[i].substr(0, equals));
      ASSERT_TRUE(joint.valid()) << set << ": " << row[i];
      q[model->joints[joint].dof.value()] = std::stod(row[i].substr(equals + 1));
    }
    const LinkId from = model->findLink(row.at(0)), to = model->findLink(row.at(1));
    ASSERT_TRUE(from.valid() && to.valid()) << set << ": " << row[0] << " " << row[1];
    std::vector<Pose> X_WL;
    linkPoses(*model, Pose::Identity(), q, X_WL);
    const Pose X_ours = X_WL[from].inverse() * X_WL[to];
    const auto number = [&row](std::size_t i) { return std::stod(row.at(i)); };
    const Eigen::Vector3d p_theirs(number(2), number(3), number(4));
    const Eigen::Quaterniond quat_theirs(number(5), number(6), number(7), number(8));
    EXPECT_LT((X_ours.translation() - p_theirs).norm(), metres) << set << " " << row[1];
    EXPECT_LT(angleOf(X_ours.linear().transpose() * quat_theirs.normalized().toRotationMatrix()),
              radians)
        << set << " " << row[1];
    ++compared;
  }
  EXPECT_GE(compared, 140);
}

/// Where the arms' axes meet, and how long their parts are.
TEST(Crichton, ShouldersAndWristsAreWhereThePublishedScenesPutThem) {
  const RobotModel model = testing::loadBody("crichton");
  const auto at = [&](const char* state, const char* link) {
    std::vector<Pose> X_WL;
    linkPoses(model, Pose::Identity(), model.named_states.at(state), X_WL);
    return X_WL[model.findLink(link)];
  };
  const auto near = [](const Eigen::Vector3d& p, double x, double y, double z) {
    return (p - Eigen::Vector3d(x, y, z)).norm() < 1e-3;
  };
  EXPECT_TRUE(near(at("home", "left_L2_link").translation(), 0, 0.3, 1.23));
  EXPECT_TRUE(near(at("home", "right_L2_link").translation(), 0, -0.3, 1.23));
  EXPECT_TRUE(near(at("home", "left_L6_link").translation(), 0.476, 0.668, 1.23));
  EXPECT_TRUE(near(at("home", "right_L6_link").translation(), 0.476, -0.668, 1.23));
  EXPECT_TRUE(near(at("frontal_fist", "left_L6_link").translation(), 0.516, 0.326, 1.23));
  EXPECT_TRUE(near(at("hug", "left_L6_link").translation(), 0.564, 0.303, 1.23));
  EXPECT_TRUE(near(at("arc_up", "left_L6_link").translation(), 0, 0.584, 1.717));
  EXPECT_LT((at("hug", "left_palm_link").linear().col(2) - Eigen::Vector3d(0.5, -0.87, 0)).norm(),
            0.01);
}

TEST(Hubo, StandsAndKneelsAtThePublishedHeights) {
  const RobotModel model = testing::loadBody("hubo");
  std::vector<Pose> X_BL;
  linkPoses(model, Pose::Identity(), model.named_states.at("standing"), X_BL);
  for (const char* foot : {"leftFoot", "rightFoot"}) {
    EXPECT_NEAR(X_BL[model.findLink(foot)].translation().z(), -0.961, 1e-9);
  }
  linkPoses(model, Pose::Identity(), model.named_states.at("kneeling"), X_BL);
  for (const char* shin : {"Body_LKP", "Body_RKP"}) {
    const Pose& X_BS = X_BL[model.findLink(shin)];
    EXPECT_NEAR(X_BS.translation().z(), 0.065 - 0.559, 1e-3);
    // The shin lies on the floor and points back.
    EXPECT_GT(X_BS.linear().col(2).x(), 0.99);
  }
}

}  // namespace
}  // namespace handover
