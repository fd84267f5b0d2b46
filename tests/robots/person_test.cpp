// SPDX-License-Identifier: Apache-2.0
// The seated person: segments as published, arms with the closed form, hands that hold a cup and a
// box.
#include "core/grasp/grasp_set.hpp"
#include "core/kinematics/arm_kinematics.hpp"
#include "core/model_io/mesh_reader.hpp"
#include "robot_files.hpp"
#include "settings/cell_file.hpp"

#include <gtest/gtest.h>

namespace handover {
namespace {

constexpr double kStature = 1.69;

std::shared_ptr<const RobotModel> person() {
  const auto folder = testing::robotsFolder();
  static const auto model = std::make_shared<const RobotModel>(
      loadRobot(readRobotSettings(folder / "person/person.yaml", folder.parent_path())));
  return model;
}

std::vector<Pose> linksAt(const RobotVector& q) {
  std::vector<Pose> X_BL;
  linkPoses(*person(), Pose::Identity(), q, X_BL);
  return X_BL;
}

Eigen::Vector3d originOf(const std::vector<Pose>& X_BL, const std::string& link) {
  return X_BL.at(person()->findLink(link)).translation();
}

TEST(Person, HasSegmentsInTheRatiosOfDrillisAndContini) {
  const auto X_BL = linksAt(RobotVector::Zero(person()->dofs()));
  for (const std::string side : {"left_", "right_"}) {
    const Eigen::Vector3d shoulder = originOf(X_BL, side + "UpperArm");
    const Eigen::Vector3d elbow = originOf(X_BL, side + "Forearm");
    const Eigen::Vector3d wrist = originOf(X_BL, side + "Palm");
    EXPECT_NEAR(shoulder.z() / kStature, 0.288, 1e-3);
    EXPECT_NEAR((elbow - shoulder).norm() / kStature, 0.186, 1e-3);
    EXPECT_NEAR((wrist - elbow).norm() / kStature, 0.146, 1e-3);
    // From the wrist to the tip of straight fingers.
    const double tip = 0.106 + 0.043 + 0.034;
    EXPECT_NEAR(tip / kStature, 0.108, 1e-3);
    EXPECT_NEAR((originOf(X_BL, side + "middle_2") - wrist).norm(), tip - 0.034, 1e-3);
  }
  // The soles are under the knees, thighs level: hip to floor is shank and foot.
  double lowest = 0;
  for (const Shape& shape : person()->links[static_cast<std::size_t>(0)].collision) {
    for (const auto& v : std::get<ConvexShape>(shape.geometry).vertices) {
      lowest = std::min(lowest, (shape.X_BS * v).z());
    }
  }
  EXPECT_NEAR(-lowest / kStature, 0.285, 1e-3);
}

TEST(Person, BendsItsJointsAsAnatomyCountsThem) {
  const auto moved = [](const std::string& joint, double angle, const std::string& link,
                        const Eigen::Vector3d& p_L) {
    RobotVector q = RobotVector::Zero(person()->dofs());
    const auto at = [&](const RobotVector& posture) {
      return Eigen::Vector3d(linksAt(posture).at(person()->findLink(link)) * p_L);
    };
    const Eigen::Vector3d before = at(q);
    const JointId index = person()->findJoint(joint);
    q[person()->joints.at(index).dof.value()] = angle;
    return Eigen::Vector3d(at(q) - before);
  };
  for (const auto& [side, outwards] : {std::pair<std::string, double>{"left", 1}, {"right", -1}}) {
    const Eigen::Vector3d end(0, 0, -0.1), palm(0, -outwards * 0.1, 0);
    EXPECT_GT(moved(side + "_shoulder_flexion", 0.5, side + "_Forearm", end).x(), 0.1);
    EXPECT_GT(moved(side + "_shoulder_abduction", 0.5, side + "_Forearm", end).y() * outwards, 0.1);
    EXPECT_GT(moved(side + "_elbow", 0.5, side + "_Forearm", end).x(), 0.04);
    // Turning in and pronation take a thumb that points ahead towards the middle.
    for (const char* turn : {"_shoulder_rotation", "_forearm"}) {
      const Eigen::Vector3d thumb(0.1, 0, 0);
      EXPECT_LT(moved(side + turn, 0.5, side + "_Palm", thumb).y() * outwards, -0.04);
    }
    EXPECT_LT(moved(side + "_wrist_flexion", 0.5, side + "_Palm", end).y() * outwards, -0.04);
    EXPECT_GT(moved(side + "_wrist_deviation", 0.3, side + "_Palm", end).x(), 0.02);
    // Fingers and thumb come together before the palm.
    EXPECT_LT(moved(side + "_middle_1_joint", 0.5, side + "_middle_2", end).y() * outwards, -0.02);
    EXPECT_LT(moved(side + "_thumb_1_joint", 0.5, side + "_thumb_2", palm).z(), -0.02);
  }
}

TEST(Person, HasArmsWithTheClosedFormOfInverseKinematics) {
  std::mt19937_64 generator(5);
  for (int arm = 0; arm < 2; ++arm) {
    const ArmKinematics kinematics(*person(), ArmId(arm));
    EXPECT_TRUE(kinematics.closedForm());
    EXPECT_EQ(kinematics.dofs(), 7);
    for (int n = 0; n < 100; ++n) {
      ArmVector q(7);
      for (int i = 0; i < 7; ++i) {
        q[i] = std::uniform_real_distribution<double>(kinematics.lower()[i],
                                                      kinematics.upper()[i])(generator);
      }
      const Pose X_AT = kinematics.toolPose(q);
      IkQuery query;
      query.q_near = q;
      query.swivel_samples = 512;
      std::vector<ArmVector> found;
      kinematics.solve(X_AT, query, found);
      for (const ArmVector& it : found) {
        EXPECT_LT((kinematics.toolPose(it).matrix() - X_AT.matrix()).norm(), 1e-6);
      }
      EXPECT_FALSE(found.empty()) << arm << " " << n;
    }
  }
}

/// Either hand, around a cup and around boxes of 4 and 6 cm.
TEST(Person, HoldsACupAndSmallBoxes) {
  SceneObject cup;
  cup.name = "cup";
  cup.shapes =
      readConvexMesh(testing::robotsFolder() / "objects/cup/cup.obj", Eigen::Vector3d::Ones());
  std::vector<SceneObject> objects{cup};
  for (const double edge : {0.04, 0.06}) {
    SceneObject box;
    box.name = "box";
    box.shapes = {{Pose::Identity(), BoxShape{{edge, edge, edge}}}};
    objects.push_back(box);
  }
  GraspParams params;
  params.wanted = 20;
  for (const SceneObject& object : objects) {
    for (int arm = 0; arm < 2; ++arm) {
      const auto set = generateGrasps(object, *person(), ArmId(arm), params, {}, Deadline{});
      ASSERT_TRUE(set.has_value()) << object.name << ": " << set.error().detail;
      EXPECT_EQ(set->grasps.size(), 20u);
      EXPECT_GT(set->grasps.front().quality, 0.05) << object.name;
    }
  }
}

}  // namespace
}  // namespace handover
