// SPDX-License-Identifier: Apache-2.0
#include "tiny_root.hpp"

#include <gmock/gmock.h>

namespace handover {
namespace {

using handover::testing::kTinyYaml;
using handover::testing::TinyRoot;
using handover::testing::with;
using ::testing::ElementsAre;

RobotSettings read(const TinyRoot& root, const std::string& text) {
  return readRobotSettings(root.write("robots/tiny/tiny.yaml", text), root.path());
}

std::vector<std::string> faultsOf(const std::string& text) {
  const TinyRoot root;
  std::vector<std::string> shown;
  try {
    loadRobot(read(root, text));
  } catch (const FileError& error) {
    for (const FileFault& fault : error.faults()) {
      EXPECT_THAT(fault.file, ::testing::EndsWith("tiny.yaml"));
      shown.push_back(std::to_string(fault.line) + ": " + fault.message);
    }
  }
  return shown;
}

TEST(RobotSettings, AreReadWithPathsBelowTheRoot) {
  const TinyRoot root;
  const RobotSettings settings = read(root, kTinyYaml);
  EXPECT_EQ(settings.name, "tiny");
  EXPECT_EQ(settings.urdf, "robots/tiny/tiny.urdf");
  EXPECT_EQ(settings.srdf, "robots/tiny/tiny.srdf");
  ASSERT_EQ(settings.arms.size(), 1u);
  EXPECT_EQ(settings.arms[0].approach_axis, Eigen::Vector3d::UnitX());
  EXPECT_FALSE(settings.arms[0].p_AShoulder);
  EXPECT_EQ(settings.hands[0].closed.at("bend"), 1.0);
  const RobotModel model = loadRobot(settings);
  EXPECT_EQ(model.urdf_path, "robots/tiny/tiny.urdf");
  EXPECT_EQ(model.arms[0].dofs.size(), 2u);
}

TEST(RobotSettings, MayGiveTheOtherJointsAnAcceleration) {
  const TinyRoot root;
  EXPECT_EQ(read(root, kTinyYaml).acceleration, 1.0);
  EXPECT_EQ(read(root, with(kTinyYaml, "arms:", "acceleration: 0.8\narms:")).acceleration, 0.8);
}

TEST(RobotSettings, MayLimitJerk) {
  const TinyRoot root;
  EXPECT_FALSE(read(root, kTinyYaml).jerk);
  const RobotModel by_default = loadRobot(read(root, kTinyYaml));
  for (const Joint& joint : by_default.joints) {
    EXPECT_DOUBLE_EQ(joint.jerk, 10 * joint.acceleration) << joint.name;
  }
  std::string text = with(kTinyYaml, "acceleration: 0.5", "acceleration: 0.5, jerk: 7");
  text = with(text, "    acceleration: 5\n", "    acceleration: 5\n    jerk: 8\n");
  const RobotSettings settings = read(root, with(text, "arms:", "jerk: 9\narms:"));
  EXPECT_EQ(settings.jerk, 9);
  const RobotModel model = loadRobot(settings);
  for (const DofId dof : model.arms[0].dofs) {
    EXPECT_EQ(model.joints[model.dof_joints[dof]].jerk, 7);
  }
  for (const DofId dof : model.hands[0].dofs) {
    EXPECT_EQ(model.joints[model.dof_joints[dof]].jerk, 8);
  }
  EXPECT_NE(model.content_hash, by_default.content_hash);
}

/// The tiny robot's yaml with a cup for a hand; its `bend` moves something else then.
std::string withCup(const std::string& suction) {
  const std::string text = kTinyYaml;
  return text.substr(0, text.find("    palm_link")) + "    suction: {" + suction + "}\n";
}

TEST(RobotSettings, MayGiveAHandASuctionCup) {
  const TinyRoot root;
  const RobotModel model = loadRobot(
      read(root, withCup("cup_link: palm, axis: [1, 0, 0], radius: 0.02, engage_s: 0.3")));
  const Hand& hand = model.hands.at(0);
  ASSERT_TRUE(hand.suction);
  EXPECT_EQ(hand.suction->cup_link, model.findLink("palm"));
  EXPECT_EQ(hand.suction->axis, Eigen::Vector3d::UnitX());
  EXPECT_EQ(hand.suction->radius, 0.02);
  EXPECT_EQ(hand.suction->engage_s, 0.3);
  EXPECT_EQ(hand.links, std::vector<LinkId>{model.findLink("palm")});
  EXPECT_TRUE(hand.dofs.empty());
  const RobotModel wider = loadRobot(
      read(root, withCup("cup_link: palm, axis: [1, 0, 0], radius: 0.03, engage_s: 0.3")));
  EXPECT_NE(model.content_hash, wider.content_hash);
}

TEST(RobotSettings, FaultsOfASuctionCupAreReportedWithTheirLines) {
  const auto of = [](const std::string& suction) { return faultsOf(withCup(suction)); };
  EXPECT_THAT(of("cup_link: palm, axis: [2, 0, 0], radius: 0, engage_s: 0"),
              ElementsAre("9: hands.hand.suction.axis: must be of unit length",
                          "9: hands.hand.suction.radius: must be within 0.001 and 0.25, not '0'",
                          "9: hands.hand.suction.engage_s: must be within 0.01 and 60, not '0'"));
  EXPECT_THAT(of("cup_link: palm, axis: [1, 0, 0], radios: 0.02, engage_s: 100"),
              ElementsAre("9: hands.hand.suction: has no 'radius'",
                          "9: hands.hand.suction.engage_s: must be within 0.01 and 60, not '100'",
                          "9: hands.hand.suction.radios: unknown key; the nearest known one is "
                          "'radius'"));
  EXPECT_THAT(of("cup_link: cup, axis: [1, 0, 0], radius: 0.02, engage_s: 1"),
              ElementsAre("9: hands.hand.suction.cup_link: link 'cup' is not in the URDF"));
  for (const char* link : {"upper", "finger"}) {
    EXPECT_THAT(
        of(std::string("cup_link: ") + link + ", axis: [1, 0, 0], radius: 0.02, engage_s: 1"),
        ElementsAre("9: hands.hand.suction.cup_link: is not rigid with the tool link "
                    "'palm' of arm 'arm'"));
  }
  EXPECT_THAT(of("cup_link: palm, axis: [0, 0, 1], radius: 0.02, engage_s: 1"),
              ElementsAre("6: arms.arm.approach_axis: is not along the axis of the suction cup "
                          "'palm'"));
  const std::string both = with(
      kTinyYaml, "    palm_link: palm\n",
      "    palm_link: palm\n    suction: {cup_link: palm, axis: [1, 0, 0], radius: 0.02, engage_s: "
      "1}\n");
  EXPECT_THAT(
      faultsOf(both),
      ::testing::Contains(
          "9: hands.hand.palm_link: is for fingers: a gripper has these or suction, not both"));
  EXPECT_THAT(faultsOf(both), ::testing::SizeIs(6));
}

TEST(RobotSettings, FaultsAreReportedWithTheirLines) {
  EXPECT_THAT(faultsOf(with(kTinyYaml, "version: 1", "version: one")),
              ElementsAre("1: version: must be a whole number from 1 to 1, not 'one'"));
  EXPECT_THAT(faultsOf(with(kTinyYaml, "urdf: tiny.urdf\n", "")), ElementsAre("1: has no 'urdf'"));
  EXPECT_THAT(
      faultsOf(with(kTinyYaml, "tool_link: palm, ", "tol_link: palm, ")),
      ElementsAre("6: arms.arm: has no 'tool_link'",
                  "6: arms.arm.tol_link: unknown key; the nearest known one is 'tool_link'"));
  EXPECT_THAT(faultsOf(with(kTinyYaml, "[1, 0, 0]", "[1, 0, x]")),
              ElementsAre("6: arms.arm.approach_axis.2: must be a finite number, not 'x'"));
  EXPECT_THAT(faultsOf(with(kTinyYaml, "acceleration: 0.5", "acceleration: -1")),
              ElementsAre("6: arms.arm.acceleration: must be within 0.001 and 1e+06, not '-1'"));
  EXPECT_THAT(faultsOf(with(kTinyYaml, "arms:", "acceleration: 0\narms:")),
              ElementsAre("5: acceleration: must be within 0.001 and 1e+06, not '0'"));
  EXPECT_THAT(faultsOf(with(kTinyYaml, "acceleration: 0.5", "acceleration: 0.5, jerk: 0")),
              ElementsAre("6: arms.arm.jerk: must be within 0.001 and 1e+09, not '0'"));
  EXPECT_THAT(
      faultsOf(with(kTinyYaml, "    acceleration: 5\n", "    acceleration: 5\n    jerk: -8\n")),
      ElementsAre("15: hands.hand.jerk: must be within 0.001 and 1e+09, not '-8'"));
  EXPECT_THAT(faultsOf(with(kTinyYaml, "arms:", "jerk: 0\narms:")),
              ElementsAre("5: jerk: must be within 0.001 and 1e+09, not '0'"));
  EXPECT_THAT(faultsOf(with(kTinyYaml, "[[bend]]", "[bend]")),
              ElementsAre("10: hands.hand.fingers.0: must be a list, not 'bend'"));
  EXPECT_THAT(
      faultsOf(with(kTinyYaml, "tool_link: palm", "tool_link: finger")),
      ElementsAre("6: arms.arm.tool_link: the joints of group 'arm' are not those between its base "
                  "and link 'finger'"));
  EXPECT_THAT(faultsOf(with(kTinyYaml, "acceleration: 0.5", "acceleration: \"0.5\"")),
              ElementsAre("6: arms.arm.acceleration: must be a finite number, not the text '0.5'"));
  EXPECT_THAT(faultsOf(with(kTinyYaml, "  arm: {", "  ../arm: {")),
              ElementsAre("6: arms.../arm: '../arm' is not a name: up to 64 letters, digits, '_' "
                          "and '-'"));
  EXPECT_THAT(faultsOf(with(kTinyYaml, "  hand:\n", "  a b:\n")),
              ElementsAre("8: hands.a b: 'a b' is not a name: up to 64 letters, digits, '_' and "
                          "'-'"));
  EXPECT_THAT(faultsOf(with(kTinyYaml, "name: tiny", "name: ti/ny")),
              ElementsAre("2: name: 'ti/ny' is not a name: up to 64 letters, digits, '_' and '-'"));
  EXPECT_THAT(faultsOf(with(kTinyYaml, "srdf: tiny.srdf", "srdf: [tiny.srdf]")),
              ElementsAre("4: srdf: must be a text, not a list"));
  EXPECT_THAT(faultsOf(with(kTinyYaml, "hand: hand, ", "hand: hand, shoulder: [0, 0], ")),
              ElementsAre("6: arms.arm.shoulder: must be a list of three numbers"));
  EXPECT_THAT(faultsOf(with(kTinyYaml, "    palm_link: palm\n", "")),
              ElementsAre("8: hands.hand: has no 'palm_link'"));
  EXPECT_THAT(faultsOf(with(kTinyYaml, "finger_links: [finger]", "finger_links: finger")),
              ElementsAre("11: hands.hand.finger_links: must be a list, not 'finger'"));
  EXPECT_THAT(faultsOf(with(kTinyYaml, "open: {bend: 0}", "open: {bend: .nan}")),
              ElementsAre("12: hands.hand.open.bend: must be a finite number, not '.nan'"));
  EXPECT_THAT(
      faultsOf(with(kTinyYaml, "    acceleration: 5\n", "    acceleration: 5\n    speed: 1\n")),
      ElementsAre("15: hands.hand.speed: unknown key; the nearest known one is 'open'"));
  EXPECT_THAT(
      faultsOf(with(kTinyYaml, "closed: {bend: 1}", "closed: {bend: 2}")),
      ElementsAre(
          "13: hands.hand.closed: joint 'bend' is outside its limits: 2 is not from 0 to 1"));
}

}  // namespace
}  // namespace handover
