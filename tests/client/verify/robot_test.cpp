// SPDX-License-Identifier: Apache-2.0
#include "verify/robot.hpp"

#include "support/temporary_folder.hpp"
#include "verify/kinematics.hpp"
#include "verify/unreadable.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <clocale>
#include <string>
#include <vector>

namespace handover::verify {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class RobotFile : public testing::Test {
 protected:
  Robot read(const std::string& urdf, const std::string& srdf = "<robot name='r'/>") const {
    return readRobot(folder_.write("r.urdf", urdf), folder_.write("r.srdf", srdf));
  }

  std::string fault(const std::string& urdf, const std::string& srdf = "<robot name='r'/>") const {
    try {
      read(urdf, srdf);
    } catch (const Unreadable& error) {
      return error.what();
    }
    return "";
  }

  handover::test::TemporaryFolder folder_;
};

std::string joint(const std::string& name, const std::string& type, const std::string& parent,
                  const std::string& child, const std::string& rest = "") {
  return "<joint name='" + name + "' type='" + type + "'><parent link='" + parent +
         "'/><child link='" + child + "'/>" + rest + "</joint>\n";
}

constexpr const char* kLimit = "<limit lower='-1' upper='1' velocity='2'/>";

/// Torso, arm of two joints, flange, palm, tool; two fingers of which one follows the other.
std::string smallRobot() {
  std::string text = "<robot name='r'>\n";
  for (const char* link :
       {"tool", "palm", "flange", "upper", "lower", "torso", "root", "f1", "f2"}) {
    text += std::string("<link name='") + link + "'/>\n";
  }
  text += joint("waist", "revolute", "root", "torso", kLimit);
  text +=
      joint("shoulder", "revolute", "torso", "upper",
            std::string("<origin xyz='0 0 1' rpy='0 0 1.5707963267948966'/><axis xyz='0 2 0'/>") +
                kLimit);
  text +=
      joint("elbow", "prismatic", "upper", "lower", std::string("<axis xyz='0 0 1'/>") + kLimit);
  text += joint("j_flange", "fixed", "lower", "flange", "<origin xyz='0.5 0 0'/>");
  text += joint("j_palm", "fixed", "flange", "palm");
  text += joint("j_tool", "fixed", "palm", "tool");
  text += joint("finger_2", "revolute", "palm", "f2",
                std::string(kLimit) + "<mimic joint='finger_1' multiplier='-0.5' offset='.1'/>");
  text += joint("finger_1", "revolute", "palm", "f1", kLimit);
  return text + "</robot>";
}

std::vector<std::string> jointsOfGroup(const Robot& robot, const std::string& name) {
  std::vector<std::string> joints;
  for (const Group& group : robot.groups) {
    if (group.name != name) continue;
    for (const int j : group.joints) {
      joints.push_back(robot.joints[static_cast<std::size_t>(j)].name);
    }
  }
  return joints;
}

TEST_F(RobotFile, GroupsAreReadAsMoveItDoes) {
  const Robot robot =
      read(smallRobot(),
           "<robot name='r'><group name='arm'><chain base_link='torso' tip_link='tool'/></group>"
           "<group name='hand'><joint name='finger_1'/><joint name='finger_2'/><joint "
           "name='gone'/></group>"
           "<group name='body'><link name='torso'/><link name='gone'/></group>"
           "<group name='all'><group name='arm'/><group name='hand'/><group name='gone'/></group>"
           "<group name='far'><chain base_link='gone' tip_link='tool'/></group></robot>");
  EXPECT_THAT(jointsOfGroup(robot, "arm"), ElementsAre("shoulder", "elbow"));
  EXPECT_THAT(jointsOfGroup(robot, "hand"), ElementsAre("finger_1"));  // the other follows it
  EXPECT_THAT(jointsOfGroup(robot, "body"), ElementsAre("waist"));
  EXPECT_THAT(jointsOfGroup(robot, "all"), ElementsAre("shoulder", "elbow", "finger_1"));
  EXPECT_THAT(jointsOfGroup(robot, "far"), testing::IsEmpty());
}

TEST_F(RobotFile, TakesPairsOfEveryReasonAndOfLinksThatAreThere) {
  const Robot robot =
      read(smallRobot(),
           "<robot name='r'><disable_collisions link1='torso' link2='palm' reason='Always'/>"
           "<disable_collisions link1='root' link2='palm' reason='Never'/>"
           "<disable_collisions link1='root' link2='tool'/>"
           "<disable_collisions link1='root' link2='gone' reason='Default'/></robot>");
  EXPECT_EQ(robot.touching.size(), 6u);
  EXPECT_TRUE(robot.touching.count({robot.findLink("palm"), robot.findLink("torso")}));
  EXPECT_TRUE(robot.touching.count({robot.findLink("palm"), robot.findLink("root")}));
}

TEST_F(RobotFile, AJointWithoutEndNeedsNoLimit) {
  const Robot robot = read("<robot name='r'><link name='a'/><link name='b'/>" +
                           joint("j", "continuous", "a", "b") + "</robot>");
  EXPECT_EQ(robot.joints.front().type, JointType::kContinuous);
  EXPECT_EQ(robot.joints.front().velocity, 0);
}

TEST_F(RobotFile, MimicsFollowTheirLaw) {
  const Robot robot = read(smallRobot());
  std::vector<double> q(robot.joints.size(), 0.0);
  q[static_cast<std::size_t>(robot.findJoint("finger_1"))] = 0.8;
  robot.followMimics(q);
  EXPECT_DOUBLE_EQ(q[static_cast<std::size_t>(robot.findJoint("finger_2"))], -0.3);
}

TEST_F(RobotFile, KinematicsFollowOriginsAndAxes) {
  const Robot robot = read(smallRobot());
  Pose X_WB = Pose::Identity();
  X_WB.translation().x() = 10;
  const Kinematics kinematics(robot, X_WB);
  std::vector<double> q(robot.joints.size(), 0.0);
  q[static_cast<std::size_t>(robot.findJoint("shoulder"))] = M_PI / 2;
  q[static_cast<std::size_t>(robot.findJoint("elbow"))] = 0.25;
  std::vector<Pose> X_WL;
  kinematics.linkPoses(q, X_WL);
  // Frame at (10, 0, 1) turned +90° about z, then +90° about its y: x points down, z to the world's
  // y.
  const Pose& tool = X_WL[static_cast<std::size_t>(robot.findLink("tool"))];
  EXPECT_TRUE(tool.translation().isApprox(Eigen::Vector3d(10, 0.25, 0.5), 1e-12))
      << tool.translation().transpose();
}

TEST_F(RobotFile, NamesTheLineOfEachFault) {
  const std::string two = "<robot name='r'>\n<link name='a'/>\n<link name='b'/>\n";
  EXPECT_THAT(fault(two + joint("j", "fixed", "a", "c") + "</robot>"), HasSubstr("r.urdf:4"));
  EXPECT_THAT(fault(two + "</robot>"), HasSubstr("2 root links"));
  EXPECT_THAT(fault(two + joint("j", "floating", "a", "b") + "</robot>"), HasSubstr("floating"));
  EXPECT_THAT(fault(two + joint("j", "revolute", "a", "b") + "</robot>"), HasSubstr("limit"));
  EXPECT_THAT(fault(two + joint("j", "revolute", "a", "b", "<axis xyz='0 0 0'/>") + "</robot>"),
              HasSubstr("axis"));
  EXPECT_THAT(
      fault(two + joint("j", "revolute", "a", "b", "<limit lower='1' upper='-1' velocity='1'/>") +
            "</robot>"),
      HasSubstr("lower above upper"));
  EXPECT_THAT(
      fault(two + joint("j", "revolute", "a", "b", std::string(kLimit) + "<mimic joint='j'/>") +
            "</robot>"),
      HasSubstr("mimics itself"));
  EXPECT_THAT(
      fault(two + joint("j", "revolute", "a", "b", std::string(kLimit) + "<mimic joint='k'/>") +
            "</robot>"),
      HasSubstr("unknown joint"));
  EXPECT_THAT(fault(two + joint("j", "fixed", "a", "b", "<origin xyz='1 2'/>") + "</robot>"),
              HasSubstr("needs 3 number"));
  EXPECT_THAT(fault(two + joint("j", "fixed", "a", "b", "<origin xyz='1 2 nan'/>") + "</robot>"),
              HasSubstr("not a number"));
  EXPECT_THAT(fault("<robot name='r'><link name='a'/>"), HasSubstr("r.urdf"));
  EXPECT_THAT(fault("<sdf/>"), HasSubstr("no <robot>"));
  EXPECT_THAT(
      fault(two + joint("j", "fixed", "a", "b") + joint("k", "fixed", "b", "a") + "</robot>"),
      HasSubstr("root"));
  EXPECT_THAT(fault("<robot name='r'><link name='a'><collision><geometry><box size='1 -1 1'/>"
                    "</geometry></collision></link></robot>"),
              HasSubstr("positive"));
  EXPECT_THAT(fault(smallRobot(),
                    "<robot name='r'><group name='g'><chain base_link='f1' tip_link='tool'/>"
                    "</group></robot>"),
              HasSubstr("no chain"));
}

TEST_F(RobotFile, OneLinksPoseIsThatOfAllLinks) {
  const Robot robot = read(smallRobot());
  const Kinematics kinematics(robot, Pose::Identity());
  std::vector<double> q(robot.joints.size(), 0.3);
  std::vector<Pose> X_WL;
  kinematics.linkPoses(q, X_WL);
  for (std::size_t link = 0; link < robot.links.size(); ++link) {
    EXPECT_TRUE(kinematics.linkPose(static_cast<int>(link), q).isApprox(X_WL[link], 1e-12));
  }
}

TEST_F(RobotFile, ManipulabilityMatchesAPlanarFormulaInSpace) {
  // Three orthogonal prismatic joints and three orthogonal axes through one point, the second
  // turned by b: det J = cos b.
  std::string text = "<robot name='r'>\n";
  for (const char* link : {"0", "1", "2", "3", "4", "5", "6"})
    text += std::string("<link name='") + link + "'/>\n";
  const char* axes[] = {"1 0 0", "0 1 0", "0 0 1", "0 0 1", "0 1 0", "1 0 0"};
  for (int i = 0; i < 6; ++i) {
    text += joint("j" + std::to_string(i), i < 3 ? "prismatic" : "revolute", std::to_string(i),
                  std::to_string(i + 1), std::string("<axis xyz='") + axes[i] + "'/>" + kLimit);
  }
  const Robot robot = read(text + "</robot>");
  const Kinematics kinematics(robot, Pose::Identity());
  const std::vector<double> q = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6};
  const std::vector<int> joints = {0, 1, 2, 3, 4, 5};
  EXPECT_NEAR(kinematics.manipulability(6, joints, q), std::cos(0.5), 1e-12);
  EXPECT_EQ(kinematics.manipulability(6, {0, 1, 2, 3, 4}, q), 0);  // six directions need six
  // The link's origin stands on the wrist's axes, so those before it move it alone.
  EXPECT_NEAR(kinematics.manipulability(3, joints, q), 0, 1e-12);
}

}  // namespace
}  // namespace handover::verify
