// SPDX-License-Identifier: Apache-2.0
// A small robot through the whole loader, and what is refused in SRDF and settings.
#include "core/model_io/robot_loader.hpp"

#include "core/model_io/file_fault.hpp"
#include "support/temporary_folder.hpp"

#include <gmock/gmock.h>

#include <clocale>
#include <locale>

namespace handover {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr const char* kUrdf = R"(<robot name="tiny">
  <link name="base"><collision><geometry><box size="0.1 0.2 0.3"/></geometry></collision></link>
  <link name="tool"/>
  <link name="upper"><collision><origin xyz="0 0 .5" rpy="0 0 1.57"/><geometry><cylinder radius="+0.05" length="1"/></geometry></collision></link>
  <link name="lower"/>
  <link name="palm"><collision><geometry><sphere radius="0.04"/></geometry></collision></link>
  <link name="finger_a"/> <link name="finger_b"/> <link name="tip_b"/> <link name="head"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 0.3"/><axis xyz="0 0 2"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/>
    <origin xyz="0 0 1"/><axis xyz="0 1 0"/><limit velocity="0.5" effort="1"/></joint>
  <joint name="wrist" type="fixed"><parent link="lower"/><child link="palm"/></joint>
  <joint name="grip" type="fixed"><parent link="palm"/><child link="tool"/><origin xyz="0 0 .1"/></joint>
  <joint name="a" type="revolute"><parent link="palm"/><child link="finger_a"/>
    <axis xyz="1 0 0"/><limit lower="0.1" upper="1.5" velocity="2" effort="1"/></joint>
  <joint name="b" type="revolute"><parent link="palm"/><child link="finger_b"/>
    <axis xyz="1 0 0"/><limit lower="-1.2" upper="0" velocity="1" effort="1"/><mimic joint="a" multiplier="-1" offset="0"/></joint>
  <joint name="tip" type="fixed"><parent link="finger_b"/><child link="tip_b"/></joint>
  <joint name="neck" type="prismatic"><parent link="base"/><child link="head"/>
    <limit lower="-.262" upper="1e-1" velocity="1" effort="1"/></joint>
</robot>)";

constexpr const char* kSrdf = R"(<robot name="tiny">
  <group name="arm"><chain base_link="base" tip_link="palm"/></group>
  <group name="hand"><joint name="a"/><link name="finger_b"/></group>
  <group name="all"><group name="arm"/><group name="hand"/></group>
  <end_effector name="gripper" parent_link="palm" group="hand" parent_group="arm"/>
  <group_state name="home" group="arm"><joint name="shoulder" value="0.5"/></group_state>
  <group_state name="home" group="hand"><joint name="a" value="0.7"/></group_state>
  <disable_collisions link1="upper" link2="base" reason="Adjacent"/>
  <disable_collisions link1="palm" link2="head" reason="Never"/>
</robot>)";

class LoadRobot : public ::testing::Test {
 protected:
  LoadRobot() {
    settings_.name = "tiny";
    settings_.root = folder_.path();
    settings_.urdf = "tiny.urdf";
    settings_.srdf = "tiny.srdf";
    settings_.settings_file = "tiny.yaml";
    ArmSettings arm;
    arm.name = "arm";
    arm.tool_link = "tool";
    arm.hand = "hand";
    arm.approach_axis = {0, 0, 2};
    arm.acceleration = 0.4;
    settings_.arms.push_back(arm);
    HandSettings hand;
    hand.name = "hand";
    hand.palm_link = "palm";
    hand.fingers = {{"a"}};
    hand.finger_links = {"finger_a", "finger_b"};
    hand.open = {{"a", 0.1}};
    hand.closed = {{"a", 1.0}};
    settings_.hands.push_back(hand);
  }

  RobotModel load() {
    folder_.write("tiny.urdf", urdf_);
    folder_.write("tiny.srdf", srdf_);
    return loadRobot(settings_);
  }

  std::string loadFault() {
    try {
      load();
    } catch (const FileError& error) {
      return error.what();
    }
    return "loaded";
  }

  static void replace(std::string& text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
  }

  test::TemporaryFolder folder_;
  RobotSettings settings_;
  std::string urdf_ = kUrdf, srdf_ = kSrdf;
};

TEST_F(LoadRobot, OrdersLinksFromTheRootAndJointsByChild) {
  const RobotModel model = load();
  std::vector<std::string> names;
  for (const Link& link : model.links) names.push_back(link.name);
  EXPECT_THAT(names, ElementsAre("base", "upper", "lower", "palm", "tool", "finger_a", "finger_b",
                                 "tip_b", "head"));
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    EXPECT_EQ(model.joints[i].child_link, LinkId(i + 1));
    EXPECT_LT(model.joints[i].parent_link, model.joints[i].child_link);
    EXPECT_EQ(model.links[i + 1].parent_joint, JointId(i));
  }
  EXPECT_EQ(model.dofs(), 4);  // shoulder, elbow, a, neck; b follows a
}

TEST_F(LoadRobot, ReadsLimitsAxesAndAccelerations) {
  settings_.acceleration = 0.7;
  settings_.hands[0].jerk = 60;
  const RobotModel model = load();
  const Joint& shoulder = model.joints[model.findJoint("shoulder")];
  EXPECT_EQ(shoulder.axis, Eigen::Vector3d::UnitZ());
  EXPECT_EQ(shoulder.lower, -2.0);
  EXPECT_EQ(shoulder.acceleration, 0.4);
  EXPECT_EQ(shoulder.jerk, 4.0);  // the default
  const Joint& elbow = model.joints[model.findJoint("elbow")];
  EXPECT_DOUBLE_EQ(elbow.lower, -M_PI);
  EXPECT_DOUBLE_EQ(elbow.upper, M_PI);
  EXPECT_EQ(elbow.velocity, 0.5);
  const Joint& neck = model.joints[model.findJoint("neck")];
  EXPECT_EQ(neck.type, JointType::kPrismatic);
  EXPECT_EQ(neck.lower, -0.262);
  EXPECT_EQ(neck.axis, Eigen::Vector3d::UnitX());
  EXPECT_EQ(neck.acceleration, 0.7);  // of no arm and no hand
  EXPECT_EQ(neck.jerk, 7.0);
  const Joint& b = model.joints[model.findJoint("b")];
  EXPECT_EQ(b.jerk, 60.0);  // as its master
}

TEST_F(LoadRobot, RefusesWhatIsTooSlowToBeMeant) {
  replace(urdf_, R"(upper="2" velocity="1")", R"(upper="2" velocity="0.000001")");
  EXPECT_THAT(loadFault(),
              HasSubstr("tiny.urdf:9: <joint> 'shoulder' has a velocity limit of 1e-06 "
                        "rad/s, below 0.001"));
  replace(urdf_, R"(velocity="0.000001")", R"(velocity="0.001")");
  EXPECT_EQ(loadFault(), "loaded");
  replace(urdf_, R"(upper="1.5" velocity="2")", R"(upper="1.5" velocity="0.0009")");
  EXPECT_THAT(loadFault(), HasSubstr("tiny.urdf:15: <joint> 'a' has a velocity limit of 0.0009"));
  replace(urdf_, R"(velocity="0.0009")", R"(velocity="2")");
  // Of no arm and no hand.
  replace(urdf_, R"(upper="1e-1" velocity="1")", R"(upper="1e-1" velocity="1e-9")");
  EXPECT_EQ(loadFault(), "loaded");
}

TEST_F(LoadRobot, NarrowsAMasterToWhatItsMimicAllows) {
  const RobotModel model = load();
  const Joint& a = model.joints[model.findJoint("a")];
  const Joint& b = model.joints[model.findJoint("b")];
  EXPECT_EQ(a.lower, 0.1);
  EXPECT_EQ(a.upper, 1.2);
  EXPECT_EQ(a.velocity, 1.0);
  EXPECT_EQ(a.acceleration, 5.0);
  EXPECT_TRUE(b.mimic);
  EXPECT_EQ(b.dof, a.dof);
  EXPECT_EQ(b.acceleration, 5.0);
  RobotVector q = RobotVector::Zero(model.dofs());
  q[a.dof.value()] = 0.6;
  EXPECT_EQ(model.jointPosition(model.findJoint("b"), q), -0.6);
}

TEST_F(LoadRobot, ComposesAMimicOfAMimic) {
  replace(urdf_, "<link name=\"head\"/>", "<link name=\"head\"/><link name=\"extra\"/>");
  replace(
      urdf_, "</robot>",
      R"(<joint name="c" type="revolute"><parent link="palm"/><child link="extra"/><axis xyz="1 0 0"/>
          <limit lower="-9" upper="9" velocity="9" effort="1"/><mimic joint="b" multiplier="2" offset="0.5"/></joint></robot>)");
  const RobotModel model = load();
  const Joint& c = model.joints[model.findJoint("c")];
  EXPECT_EQ(c.mimic_multiplier, -2.0);
  EXPECT_EQ(c.mimic_offset, 0.5);
  EXPECT_EQ(c.dof, model.joints[model.findJoint("a")].dof);
}

TEST_F(LoadRobot, FillsArmAndHand) {
  const RobotModel model = load();
  ASSERT_EQ(model.arms.size(), 1u);
  const Arm& arm = model.arms[0];
  EXPECT_EQ(arm.base_link, model.findLink("base"));
  EXPECT_EQ(arm.tool_link, model.findLink("tool"));
  EXPECT_THAT(arm.dofs, ElementsAre(DofId(0), DofId(1)));
  EXPECT_EQ(arm.approach_axis, Eigen::Vector3d::UnitZ());
  EXPECT_EQ(arm.hand, HandId(0));
  const Hand& hand = model.hands[0];
  EXPECT_THAT(hand.dofs, ElementsAre(DofId(2)));
  EXPECT_EQ(hand.open[0], 0.1);
  EXPECT_EQ(hand.closed[0], 1.0);
  EXPECT_THAT(hand.links, ElementsAre(model.findLink("palm"), model.findLink("tool"),
                                      model.findLink("finger_a"), model.findLink("finger_b"),
                                      model.findLink("tip_b")));
}

TEST_F(LoadRobot, MergesNamedStatesAndClampsTheRest) {
  const RobotModel model = load();
  const RobotVector& home = model.named_states.at("home");
  EXPECT_EQ(home[0], 0.5);
  EXPECT_EQ(home[1], 0.0);
  EXPECT_EQ(home[2], 0.7);
  EXPECT_EQ(home[3], 0.0);
  replace(srdf_, R"(<joint name="a" value="0.7"/>)", "");
  EXPECT_EQ(load().named_states.at("home")[2], 0.1);
}

TEST_F(LoadRobot, KeepsDisabledPairsLowerLinkFirst) {
  const RobotModel model = load();
  ASSERT_EQ(model.disabled_pairs.size(), 2u);
  EXPECT_EQ(model.disabled_pairs.at({model.findLink("base"), model.findLink("upper")}), "Adjacent");
  EXPECT_EQ(model.disabled_pairs.at({model.findLink("palm"), model.findLink("head")}), "Never");
}

TEST_F(LoadRobot, PlacesShapesInTheirLink) {
  const RobotModel model = load();
  const Shape& upper = model.links[1].collision.at(0);
  EXPECT_EQ(std::get<CylinderShape>(upper.geometry).radius, 0.05);
  EXPECT_EQ(upper.X_BS.translation(), Eigen::Vector3d(0, 0, 0.5));
  EXPECT_TRUE(upper.X_BS.linear().isApprox(rotationFromRpy(0, 0, 1.57)));
}

TEST_F(LoadRobot, HashesTheUrdfFile) {
  folder_.write("tiny.urdf", "");
  const RobotModel model = load();
  EXPECT_EQ(model.urdf_sha256.size(), 64u);
  urdf_ += "\n";
  EXPECT_NE(load().urdf_sha256, model.urdf_sha256);
}

/// As in much of Europe: a comma before the decimals.
class CommaNumbers : public std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
};

TEST_F(LoadRobot, ReadsTheSameUnderACommaLocale) {
  const RobotModel before = load();
  const std::locale old = std::locale::global(std::locale(std::locale(), new CommaNumbers));
  const std::string c_locale = std::setlocale(LC_ALL, nullptr);
  std::setlocale(LC_ALL, "de_DE.UTF-8");  // where it is installed
  const RobotModel after = load();
  std::setlocale(LC_ALL, c_locale.c_str());
  std::locale::global(old);
  EXPECT_EQ(after.content_hash, before.content_hash);
}

TEST_F(LoadRobot, FindsMeshesByPackageAndRelativePath) {
  const char* tetrahedron =
      "o t\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
  folder_.write("meshes/t.obj", tetrahedron);
  for (const char* uri : {"meshes/t.obj", "package://tiny/meshes/t.obj"}) {
    urdf_ = kUrdf;
    replace(urdf_, R"(<box size="0.1 0.2 0.3"/>)",
            std::string(R"(<mesh filename=")") + uri + R"(" scale="1 1 2"/>)");
    const RobotModel model = load();
    ASSERT_EQ(model.links[0].collision.size(), 1u);
    EXPECT_EQ(std::get<ConvexShape>(model.links[0].collision[0].geometry).vertices.size(), 4u);
  }
}

struct BadCase {
  const char* from;
  const char* to;
  const char* message;
};

TEST_F(LoadRobot, RefusesFaultsOfTheSrdfByLine) {
  const BadCase cases[] = {
      {R"(tip_link="palm")", R"(tip_link="hand")",
       "tiny.srdf:2: <chain>: link 'hand' is not in the URDF"},
      {R"(base_link="base" tip_link="palm")", R"(base_link="head" tip_link="palm")",
       "tiny.srdf:2: <chain>: no joints lead from 'head' to 'palm'"},
      {R"(<joint name="a"/>)", R"(<joint name="x"/>)",
       "tiny.srdf:3: <joint>: joint 'x' is not in the URDF"},
      {R"(<group name="hand"/></group>)", R"(<group name="all"/></group>)",
       "tiny.srdf:4: <group>: group 'all' contains itself"},
      {R"(<group name="hand"/></group>)", R"(<group name="legs"/></group>)",
       "tiny.srdf:4: <group>: group 'legs' is not defined"},
      {R"(parent_group="arm")", R"(parent_group="leg")",
       "tiny.srdf:5: <end_effector> 'gripper': group 'leg' is not defined"},
      {R"(value="0.5")", R"(value="2.5")",
       "tiny.srdf:6: <group_state> 'home': joint 'shoulder' is outside its limits: 2.5 is not "
       "from -2 to 2"},
      {R"(value="0.5")", R"(value="nan")",
       "tiny.srdf:6: <joint> 'shoulder': value is not a finite number: 'nan'"},
      {R"(value="0.7")", "", "tiny.srdf:7: <joint> 'a' has no value"},
      {R"(link2="base")", R"(link2="basis")",
       "tiny.srdf:8: <disable_collisions>: link 'basis' is not in the URDF"},
      {R"(link2="base")", R"(link2="upper")",
       "tiny.srdf:8: <disable_collisions>: a link with itself"},
      {R"(<robot name="tiny">)", R"(<robot name="huge">)",
       "tiny.srdf:1: robot 'huge' is called 'tiny' in the URDF"},
      {R"(link2="head" reason="Never")", R"(link2="head" reason="never")",
       "tiny.srdf:9: <disable_collisions>: unknown reason 'never': Adjacent, Always, Never, "
       "Default or User"},
      {R"(link2="head" reason="Never")", R"(link2="head")",
       "tiny.srdf:9: <disable_collisions> has no reason"},
      {R"(link1="palm" link2="head" reason="Never")",
       R"(link1="base" link2="upper" reason="Never")",
       "tiny.srdf:9: <disable_collisions>: 'base' and 'upper' have two reasons"},
      {"<disable_collisions link1=\"palm\"", "<disable_collision link1=\"palm\"",
       "tiny.srdf:9: <robot> 'tiny' has the unknown element <disable_collision>"},
      {R"(<link name="finger_b"/></group>)", R"(<links name="finger_b"/></group>)",
       "tiny.srdf:3: <group> 'hand' has the unknown element <links>"},
      {R"(<group name="hand"><joint name="a"/>)", R"(<group name="arm"><joint name="a"/>)",
       "tiny.srdf:3: <group> 'arm' is defined twice"},
      {R"(parent_link="palm")", R"(parent_link="fist")",
       "tiny.srdf:5: <end_effector>: link 'fist' is not in the URDF"},
      {"</robot>", R"(<end_effector name="gripper" parent_link="palm" group="hand"/></robot>)",
       "tiny.srdf:10: <end_effector> 'gripper' is defined twice"},
      {"</robot>", R"(<passive_joint name="x"/></robot>)",
       "tiny.srdf:10: <passive_joint>: joint 'x' is not in the URDF"},
      {"</robot>", R"(<virtual_joint name="v" child_link="x"/></robot>)",
       "tiny.srdf:10: <virtual_joint>: link 'x' is not in the URDF"},
      {R"(name="home" group="hand")", R"(name="home" group="leg")",
       "tiny.srdf:7: <group_state> 'home': group 'leg' is not defined"},
      {R"(name="home" group="hand")", R"(name="home" group="arm")",
       "tiny.srdf:7: <group_state> 'home': joint 'a' is not in group 'arm'"},
      {R"(<joint name="a" value="0.7"/>)", R"(<joint name="wrist" value="0"/>)",
       "tiny.srdf:7: <group_state> 'home': joint 'wrist' is fixed"},
      {R"(<joint name="a" value="0.7"/>)",
       R"(<joint name="a" value="0.7"/><joint name="a" value="0.8"/>)",
       "tiny.srdf:7: <group_state> 'home': joint 'a' has two values"},
      {"</robot>", "", "tiny.srdf:1: is not well-formed XML"},
  };
  for (const BadCase& bad : cases) {
    srdf_ = kSrdf;
    replace(srdf_, bad.from, bad.to);
    EXPECT_THAT(loadFault(), HasSubstr(bad.message));
  }
}

TEST_F(LoadRobot, RefusesAnSrdfOfTooManyGroups) {
  std::string groups;
  for (int i = 0; i < 50'000; ++i) {  // each within the one before
    groups += "<group name='g" + std::to_string(i) + "'><group name='g" + std::to_string(i + 1) +
              "'/></group>";
  }
  srdf_ = "<robot name='tiny'>" + groups + "</robot>";
  EXPECT_THAT(loadFault(), HasSubstr("tiny.srdf:1: has 50000 groups with 0 chains, more than 256"));
}

TEST_F(LoadRobot, TellsOfSettingsBesidesTheSrdf) {
  replace(srdf_, "\"Never\"", "\"never\"");
  settings_.hands[0].palm_link = "x";
  const std::string faults = loadFault();
  EXPECT_THAT(faults, HasSubstr("tiny.srdf:9: "));
  EXPECT_THAT(faults, HasSubstr("hands.hand.palm_link: link 'x' is not in the URDF"));
}

TEST_F(LoadRobot, RefusesSettingsThatDoNotFit) {
  const RobotSettings good = settings_;
  const auto faultOf = [&](auto change) {
    settings_ = good;
    change(settings_);
    return loadFault();
  };
  EXPECT_THAT(faultOf([](auto& s) { s.arms[0].tool_link = "x"; }),
              HasSubstr("tiny.yaml: arms.arm.tool_link: link 'x' is not in the URDF"));
  EXPECT_THAT(
      faultOf([](auto& s) { s.arms[0].tool_link = "finger_a"; }),
      HasSubstr("the joints of group 'arm' are not those between its base and link 'finger_a'"));
  EXPECT_THAT(faultOf([](auto& s) { s.arms[0].name = "legs"; }),
              HasSubstr("arms.legs: an arm is named as its group of the SRDF, which has all, arm"));
  EXPECT_THAT(faultOf([](auto& s) { s.arms[0].name = "all"; }),
              HasSubstr("has the mimic joint 'b'"));
  EXPECT_THAT(faultOf([](auto& s) { s.arms[0].hand = "foot"; }),
              HasSubstr("arms.arm.hand: hand 'foot' is not defined"));
  EXPECT_THAT(faultOf([](auto& s) { s.arms[0].approach_axis.setZero(); }),
              HasSubstr("arms.arm.approach_axis: is zero"));
  EXPECT_THAT(faultOf([](auto& s) { s.hands[0].palm_link = "x"; }),
              HasSubstr("hands.hand.palm_link: link 'x' is not in the URDF"));
  EXPECT_THAT(faultOf([](auto& s) { s.hands[0].finger_links = {"x"}; }),
              HasSubstr("hands.hand.finger_links: link 'x' is not in the URDF"));
  EXPECT_THAT(faultOf([](auto& s) { s.hands[0].fingers = {{"b"}}; }),
              HasSubstr("hands.hand.fingers: joint 'b' mimics another"));
  EXPECT_THAT(faultOf([](auto& s) { s.hands[0].fingers = {{"neck"}}; }),
              HasSubstr("joint 'neck' is not among those of open"));
  EXPECT_THAT(faultOf([](auto& s) { s.hands[0].palm_link = "head"; }),
              HasSubstr("arms.arm.hand: the palm of hand 'hand' does not hang on this arm"));
  EXPECT_THAT(faultOf([](auto& s) { s.hands[0].finger_links = {"head"}; }),
              HasSubstr("hands.hand.finger_links: link 'head' is no part of the hand"));
  EXPECT_THAT(faultOf([](auto& s) {
                s.hands[0].finger_links = {"finger_a", "finger_a"};
              }),
              HasSubstr("hands.hand.finger_links: link 'finger_a' is there twice"));
  EXPECT_THAT(faultOf([](auto& s) {
                s.hands[0].fingers = {{"a"}, {}};
              }),
              HasSubstr("hands.hand.fingers: a finger has no joint"));
  EXPECT_THAT(faultOf([](auto& s) {
                s.hands[0].fingers = {{"a"}, {"a"}};
              }),
              HasSubstr("hands.hand.fingers: joint 'a' is there twice"));
  EXPECT_THAT(
      faultOf([](auto& s) {
        s.hands[0].open = {{"a", 1.3}};
      }),
      HasSubstr("hands.hand.open: joint 'a' is outside its limits: 1.3 is not from 0.1 to 1.2"));
  EXPECT_THAT(faultOf([](auto& s) { s.hands[0].closed.clear(); }),
              HasSubstr("hands.hand.closed: joint 'a' is missing"));
  EXPECT_THAT(faultOf([](auto& s) {
                s.hands[0].open = {{"shoulder", 0}};
                s.hands[0].closed = {{"shoulder", 0}};
                s.hands[0].fingers.clear();
              }),
              HasSubstr("joint 'shoulder' belongs to another arm or hand already"));
  EXPECT_THAT(faultOf([](auto& s) {
                s.lines["arms.arm.hand"] = 12;
                s.arms[0].hand = "";
              }),
              HasSubstr("tiny.yaml:12: arms.arm.hand"));
}

TEST_F(LoadRobot, ListsEveryFaultAtOnce) {
  settings_.arms[0].hand = "foot";
  settings_.arms[0].tool_link = "x";
  settings_.hands[0].open = {{"a", 9.0}};
  try {
    load();
    FAIL();
  } catch (const FileError& error) {
    EXPECT_EQ(error.faults().size(), 3u);
  }
}

}  // namespace
}  // namespace handover
