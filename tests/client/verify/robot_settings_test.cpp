// SPDX-License-Identifier: Apache-2.0
#include "verify/robot_settings.hpp"

#include "support/temporary_folder.hpp"
#include "verify/input_file.hpp"
#include "verify/unreadable.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

namespace handover::verify {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr const char* kUrdf = R"(<robot name="r">
  <link name="root"/><link name="torso"/><link name="arm"/><link name="palm"/><link name="finger"/>
  <joint name="waist" type="revolute"><parent link="root"/><child link="torso"/><limit lower="-1" upper="1" velocity="1"/></joint>
  <joint name="elbow" type="revolute"><parent link="torso"/><child link="arm"/><limit lower="-1" upper="1" velocity="1"/></joint>
  <joint name="wrist" type="revolute"><parent link="arm"/><child link="palm"/><limit lower="-1" upper="1" velocity="0"/></joint>
  <joint name="thumb" type="revolute"><parent link="palm"/><child link="finger"/><limit lower="-1" upper="1" velocity="1"/></joint>
</robot>)";
constexpr const char* kSrdf = R"(<robot name="r">
  <group name="the_arm"><chain base_link="torso" tip_link="palm"/></group>
</robot>)";

class SettingsFile : public testing::Test {
 protected:
  SettingsFile()
      : robot_(readRobot(folder_.write("r.urdf", kUrdf), folder_.write("r.srdf", kSrdf))) {}

  JointBounds bounds(const std::string& yaml, const char* joint) const {
    const RobotSettings settings = readRobotSettings(folder_.write("r.yaml", yaml), robot_);
    return settings.bounds[static_cast<std::size_t>(robot_.findJoint(joint))];
  }

  handover::test::TemporaryFolder folder_;
  Robot robot_;
};

TEST_F(SettingsFile, NearerEntriesGoBeforeFartherOnes) {
  const std::string yaml =
      "acceleration: 1\njerk: 7\n"
      "arms: {the_arm: {hand: h, acceleration: 2, velocity: {wrist: 3}}}\n"
      "hands: {h: {palm_link: palm, acceleration: 5, jerk: 60}}\n";
  EXPECT_EQ(bounds(yaml, "waist").acceleration, 1);
  EXPECT_EQ(bounds(yaml, "waist").jerk, 7);
  EXPECT_EQ(bounds(yaml, "elbow").acceleration, 2);
  EXPECT_EQ(bounds(yaml, "elbow").jerk, 7);
  EXPECT_EQ(bounds(yaml, "elbow").velocity, std::nullopt);
  EXPECT_EQ(bounds(yaml, "wrist").velocity, 3);
  EXPECT_EQ(bounds(yaml, "thumb").acceleration, 5);
  EXPECT_EQ(bounds(yaml, "thumb").jerk, 60);
}

TEST_F(SettingsFile, LimitsOfOneJointGoBeforeAll) {
  const std::string yaml =
      "acceleration: 1\nlimits: {waist: {acceleration: 0.5, upper: 0.2}}\n"
      "arms: {the_arm: {acceleration: 2, limits: {elbow: {jerk: 3}}}}\n";
  EXPECT_EQ(bounds(yaml, "waist").acceleration, 0.5);
  EXPECT_EQ(bounds(yaml, "waist").upper, 0.2);
  EXPECT_EQ(bounds(yaml, "elbow").acceleration, 2);
  EXPECT_EQ(bounds(yaml, "elbow").jerk, 3);
}

TEST_F(SettingsFile, AGripperIsKnownByItsJointsToo) {
  const std::string yaml =
      "grippers: {g: {open: {thumb: 0.1}, closed: {thumb: 0.9}, acceleration: 4}}\n";
  EXPECT_EQ(bounds(yaml, "thumb").acceleration, 4);
  EXPECT_EQ(bounds(yaml, "wrist").acceleration, std::nullopt);
}

TEST_F(SettingsFile, AnArmsJointIsNoGrippersWhateverIsNamedLikeIt) {
  const std::string yaml =
      "arms: {the_arm: {acceleration: 2}}\n"
      "hands: {h: {palm_link: palm, mount: wrist, acceleration: 5}}\n";
  EXPECT_EQ(bounds(yaml, "wrist").acceleration, 2);
  EXPECT_EQ(bounds(yaml, "thumb").acceleration, 5);
}

TEST_F(SettingsFile, SaysNothingOfWhatItDoesNotName) {
  EXPECT_EQ(bounds("version: 1", "waist").acceleration, std::nullopt);
  EXPECT_EQ(bounds("version: 1", "waist").jerk, std::nullopt);
}

TEST_F(SettingsFile, NamesFileAndLineOfAFault) {
  try {
    bounds("version: 1\nacceleration: much\n", "waist");
    FAIL();
  } catch (const Unreadable& fault) {
    EXPECT_THAT(fault.what(), HasSubstr("r.yaml:2"));
  }
  EXPECT_THROW(bounds("- 1", "waist"), Unreadable);
  EXPECT_THROW(bounds("a: [", "waist"), Unreadable);
}

class MeshName : public testing::Test {
 protected:
  fs::path resolved(const std::string& name, const Packages& packages = {}) const {
    return resolveUrdfMesh(name, folder_.path() / "robots/a/urdf/a.urdf", folder_.path(), packages);
  }

  fs::path file(const std::string& name, const std::string& text = "x") const {
    return folder_.write(name, text);
  }

  handover::test::TemporaryFolder folder_;
};

TEST_F(MeshName, IsRelativeToTheUrdfOrInAPackage) {
  file("robots/a/urdf/a.urdf");
  const fs::path beside = file("robots/a/urdf/m.stl");
  const fs::path own = file("robots/a/meshes/m.stl");
  EXPECT_EQ(resolved("m.stl"), beside);
  EXPECT_EQ(fs::canonical(resolved("../meshes/m.stl")), fs::canonical(own));
  // A folder of that name above the URDF.
  EXPECT_EQ(resolved("package://a/meshes/m.stl"), own);
  // A sibling, known by its package.xml.
  file("robots/b/package.xml", "<package><name> art </name></package>");
  const fs::path sibling = file("robots/b/n.stl");
  EXPECT_EQ(resolved("package://art/n.stl"), sibling);
  // What the yaml names goes before all.
  const fs::path named = file("elsewhere/n.stl");
  EXPECT_EQ(resolved("package://art/n.stl", {{"art", folder_.path() / "elsewhere"}}), named);
}

TEST_F(MeshName, IsLookedForWhereRosSays) {
  file("robots/a/urdf/a.urdf");
  const fs::path one = file("ws/src/deep/c/m.stl");
  file("ws/src/deep/c/package.xml", "<package><name>c</name></package>");
  const fs::path two = file("opt/share/d/m.stl");
  setenv("ROS_PACKAGE_PATH", (folder_.path() / "ws/src").c_str(), 1);
  setenv("AMENT_PREFIX_PATH", (folder_.path() / "opt").c_str(), 1);
  EXPECT_EQ(resolved("package://c/m.stl"), one);
  EXPECT_EQ(resolved("package://d/m.stl"), two);
  unsetenv("ROS_PACKAGE_PATH");
  unsetenv("AMENT_PREFIX_PATH");
}

TEST_F(MeshName, ThatIsNowhereIsRefusedNamingThePlaces) {
  file("robots/a/urdf/a.urdf");
  try {
    resolved("package://art/n.stl");
    FAIL();
  } catch (const Unreadable& fault) {
    EXPECT_THAT(fault.what(), HasSubstr("looked at"));
    EXPECT_THAT(fault.what(), HasSubstr("art/n.stl"));
  }
  EXPECT_THROW(resolved("package://"), Unreadable);
}

}  // namespace
}  // namespace handover::verify
