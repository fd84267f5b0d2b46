// SPDX-License-Identifier: Apache-2.0
// One bad URDF per rule: the fault and its line.
#include "core/model_io/urdf_reader.hpp"
#include "support/temporary_folder.hpp"

#include <gmock/gmock.h>

namespace handover {
namespace {

struct BadUrdf {
  const char* name;
  const char* body;     ///< from line 2 on, after <robot name="r">
  const char* message;  ///< "line: message", the only fault
};

std::ostream& operator<<(std::ostream& out, const BadUrdf& bad) { return out << bad.name; }

std::vector<std::string> faultsOf(const std::string& text) {
  const test::TemporaryFolder folder;
  std::vector<FileFault> faults;
  readUrdf(folder.write("r.urdf", text), "r.urdf", faults);
  std::vector<std::string> shown;
  for (const FileFault& fault : faults) {
    EXPECT_EQ(fault.file, "r.urdf");
    shown.push_back(std::to_string(fault.line) + ": " + fault.message);
  }
  return shown;
}

class UrdfFault : public ::testing::TestWithParam<BadUrdf> {};

TEST_P(UrdfFault, IsReportedWithItsLine) {
  const std::string text = std::string("<robot name=\"r\">\n") + GetParam().body + "\n</robot>";
  EXPECT_THAT(faultsOf(text), ::testing::ElementsAre(GetParam().message));
}

#define LINKS "<link name='a'/><link name='b'/>\n"
#define ENDS "<parent link='a'/><child link='b'/>"
#define X64 "xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx"
#define LIMIT "<limit lower='-1' upper='1' velocity='1' effort='1'/>"

INSTANTIATE_TEST_SUITE_P(
    All, UrdfFault,
    ::testing::Values(
        BadUrdf{"zero_axis",
                LINKS "<joint name='j' type='revolute'>" ENDS LIMIT "\n<axis xyz='0 0 0'/></joint>",
                "4: <joint> 'j': axis is zero"},
        BadUrdf{"axis_without_xyz",
                LINKS "<joint name='j' type='revolute'>" ENDS LIMIT "<axis/></joint>",
                "3: <joint> 'j': <axis> has no xyz"},
        BadUrdf{"lower_above_upper",
                LINKS "<joint name='j' type='revolute'>" ENDS
                      "\n\n<limit lower='1' upper='-1' velocity='1' effort='1'/></joint>",
                "5: <joint> 'j': lower limit is above the upper one"},
        BadUrdf{"no_limit", LINKS "<joint name='j' type='prismatic'>" ENDS "</joint>",
                "3: <joint> 'j' has no <limit>"},
        BadUrdf{"no_velocity",
                LINKS "<joint name='j' type='revolute'>" ENDS
                      "<limit lower='-1' upper='1' effort='1'/></joint>",
                "3: <limit> has no velocity"},
        BadUrdf{"no_effort",
                LINKS "<joint name='j' type='continuous'>" ENDS "<limit velocity='1'/></joint>",
                "3: <limit> has no effort"},
        BadUrdf{"limit_of_a_fixed_joint",
                LINKS "<joint name='j' type='fixed'>" ENDS "<limit effort='1'/></joint>",
                "3: <limit> has no velocity"},
        BadUrdf{"tab_in_a_vector",
                LINKS "<joint name='j' type='fixed'>" ENDS "<origin xyz='0\t0 0'/></joint>",
                "3: <origin>: xyz is not three finite numbers: '0?0 0'"},
        BadUrdf{"space_after_a_number",
                LINKS "<joint name='j' type='continuous'>" ENDS
                      "<limit velocity='1 ' effort='1'/></joint>",
                "3: <limit>: velocity is not a finite number: '1 '"},
        BadUrdf{"negative_velocity",
                LINKS "<joint name='j' type='revolute'>" ENDS
                      "<limit lower='-1' upper='1' velocity='-1' effort='1'/></joint>",
                "3: <joint> 'j': velocity limit is negative"},
        BadUrdf{"nan_limit",
                LINKS "<joint name='j' type='revolute'>" ENDS
                      "<limit lower='nan' upper='1' velocity='1' effort='1'/></joint>",
                "3: <limit>: lower is not a finite number: 'nan'"},
        BadUrdf{"huge_limit",
                LINKS "<joint name='j' type='revolute'>" ENDS
                      "<limit lower='-1' upper='1e999' velocity='1' effort='1'/></joint>",
                "3: <limit>: upper is not a finite number: '1e999'"},
        BadUrdf{"comma_number",
                LINKS "<joint name='j' type='revolute'>" ENDS
                      "<limit lower='-1' upper='1,5' velocity='1' effort='1'/></joint>",
                "3: <limit>: upper is not a finite number: '1,5'"},
        BadUrdf{"infinite_origin",
                LINKS "<joint name='j' type='fixed'>" ENDS "\n<origin xyz='0 inf 0'/></joint>",
                "4: <origin>: xyz is not three finite numbers: '0 inf 0'"},
        BadUrdf{"two_numbers",
                LINKS "<joint name='j' type='fixed'>" ENDS "<origin rpy='0 0'/></joint>",
                "3: <origin>: rpy is not three finite numbers: '0 0'"},
        BadUrdf{"unknown_master",
                LINKS "<joint name='j' type='revolute'>" ENDS LIMIT "\n<mimic joint='k'/></joint>",
                "4: <joint> 'j': mimic master 'k' is not defined"},
        BadUrdf{"own_master",
                LINKS "<joint name='j' type='revolute'>" ENDS LIMIT "<mimic joint='j'/></joint>",
                "3: <joint> 'j' mimics itself in the end"},
        BadUrdf{"fixed_master",
                LINKS "<link name='c'/><joint name='k' type='fixed'><parent link='a'/><child "
                      "link='c'/></joint>\n"
                      "<joint name='j' type='revolute'>" ENDS LIMIT "<mimic joint='k'/></joint>",
                "4: <joint> 'j': mimic master 'k' is a fixed joint"},
        BadUrdf{"mimic_out_of_limits",
                LINKS "<link name='c'/><joint name='k' type='revolute'><parent link='a'/><child "
                      "link='c'/>" LIMIT "</joint>\n<joint name='j' type='revolute'>" ENDS LIMIT
                      "<mimic joint='k' offset='3'/></joint>",
                "4: <joint> 'j': no position of its master 'k' keeps both within their limits"},
        BadUrdf{"negative_box",
                "<link name='a'><collision><geometry>\n<box size='1 -1 "
                "1'/></geometry></collision></link>",
                "3: <collision> of link 'a': size of <box> must be positive"},
        BadUrdf{"negative_radius",
                "<link name='a'><collision><geometry><sphere "
                "radius='-1'/></geometry></collision></link>",
                "2: <collision> of link 'a': radius of <sphere> must be positive"},
        BadUrdf{"zero_length",
                "<link name='a'><visual><geometry><cylinder radius='1' "
                "length='0'/></geometry></visual></link>",
                "2: <visual> of link 'a': length of <cylinder> must be positive"},
        BadUrdf{"unknown_geometry",
                "<link name='a'><collision><geometry><cone/></geometry></collision></link>",
                "2: <collision> of link 'a' has unknown geometry <cone>"},
        BadUrdf{"no_geometry", "<link name='a'><collision/></link>",
                "2: <collision> of link 'a' has no geometry"},
        BadUrdf{"mesh_format",
                "<link name='a'><collision><geometry><mesh "
                "filename='a.ply'/></geometry></collision></link>",
                "2: <collision> of link 'a': mesh 'a.ply' is not STL, OBJ or DAE"},
        BadUrdf{"mesh_missing",
                "<link name='a'><collision><geometry><mesh "
                "filename='a.stl'/></geometry></collision></link>",
                "2: <collision> of link 'a': mesh 'a.stl': no such file"},
        BadUrdf{"mesh_scale",
                "<link name='a'><visual><geometry><mesh filename='a.stl' scale='1 0 "
                "1'/></geometry></visual></link>",
                "2: <visual> of link 'a': scale of <mesh> must not be zero"},
        BadUrdf{"missing_child",
                "<link name='a'/>\n<joint name='j' type='fixed'><parent link='a'/><child "
                "link='x'/></joint>",
                "3: <joint> 'j': child link 'x' is not defined"},
        BadUrdf{"no_parent", LINKS "<joint name='j' type='fixed'><child link='b'/></joint>",
                "3: <joint> 'j' has no <parent>"},
        BadUrdf{"loop",
                "<link name='r'/>" LINKS "<joint name='j' type='fixed'>" ENDS
                "</joint><joint name='k' type='fixed'><parent link='b'/><child link='a'/></joint>\n"
                "<joint name='l' type='fixed'><parent link='b'/><child link='r'/></joint>",
                "1: no link is the root: the joints form a loop"},
        BadUrdf{"two_parents",
                LINKS "<joint name='j' type='fixed'>" ENDS "</joint>\n"
                      "<joint name='k' type='fixed'>" ENDS "</joint>",
                "4: link 'b' is the child of two joints: 'j' and 'k'"},
        BadUrdf{"two_roots", "<link name='a'/>\n<link name='b'/>",
                "3: link 'b' is a second root beside 'a'"},
        BadUrdf{"no_link", "", "1: <robot> 'r' has no link"},
        BadUrdf{"twice_link", "<link name='a'/>\n<link name='a'/>",
                "3: <link> 'a' is defined twice, first on line 2"},
        BadUrdf{
            "twice_joint",
            LINKS
            "<link name='c'/><joint name='j' type='fixed'>" ENDS
            "</joint>\n<joint name='j' type='fixed'><parent link='a'/><child link='c'/></joint>",
            "4: <joint> 'j' is defined twice, first on line 3"},
        BadUrdf{"unknown_type", LINKS "<joint name='j' type='ball'>" ENDS LIMIT "</joint>",
                "3: <joint> 'j': unknown type 'ball'"},
        BadUrdf{"floating", LINKS "<joint name='j' type='floating'>" ENDS "</joint>",
                "3: <joint> 'j': type 'floating' is not supported: a robot's base is fixed by the "
                "cell"},
        BadUrdf{"no_type", LINKS "<joint name='j'>" ENDS "</joint>", "3: <joint> 'j' has no type"},
        BadUrdf{"joins_itself",
                LINKS "<joint name='j' type='fixed'>" ENDS
                      "</joint>\n<link name='c'/><joint name='k' "
                      "type='fixed'><parent link='c'/><child link='c'/></joint>",
                "4: <joint> 'k' joins link 'c' to itself"},
        BadUrdf{"misspelt_element",
                LINKS "<joint name='j' type='revolute'>" ENDS LIMIT "\n<axes xyz='0 0 1'/></joint>",
                "4: <joint> 'j' has the unknown element <axes>"},
        BadUrdf{"misspelt_collision", "<link name='a'><colision/></link>",
                "2: <link> 'a' has the unknown element <colision>"},
        BadUrdf{"misspelt_attribute",
                LINKS "<joint name='j' type='revolute'>" ENDS LIMIT
                      "<axis xzy='1 0 0' xyz='0 0 1'/></joint>",
                "3: <axis> has the unknown attribute xzy"},
        BadUrdf{"misspelt_multiplier",
                LINKS "<link name='c'/><joint name='k' type='revolute'><parent link='a'/><child "
                      "link='c'/>" LIMIT "</joint>\n<joint name='j' type='revolute'>" ENDS LIMIT
                      "<mimic joint='k' multipler='2'/></joint>",
                "4: <mimic> has the unknown attribute multipler"},
        BadUrdf{"two_limits",
                LINKS "<joint name='j' type='revolute'>" ENDS LIMIT
                      "\n<limit velocity='1' effort='1'/></joint>",
                "4: <joint> 'j' has two <limit>s"},
        BadUrdf{"two_origins",
                LINKS "<joint name='j' type='fixed'>" ENDS "<origin/>\n<origin/></joint>",
                "4: <joint> 'j' has two <origin>s"},
        BadUrdf{"two_shapes",
                "<link name='a'><collision><geometry><sphere radius='1'/>\n<sphere "
                "radius='1'/></geometry></collision></link>",
                "3: <collision> of link 'a' has two shapes"},
        BadUrdf{"fixed_mimic",
                LINKS "<link name='c'/><joint name='k' type='continuous'><parent link='a'/><child "
                      "link='c'/></joint>\n<joint name='j' type='fixed'>" ENDS
                      "<mimic joint='k'/></joint>",
                "4: <joint> 'j' is fixed and mimics"},
        BadUrdf{"far_origin",
                LINKS "<joint name='j' type='fixed'>" ENDS "<origin xyz='0 1e300 0'/></joint>",
                "3: <origin>: xyz is beyond 1000: '0 1e300 0'"},
        BadUrdf{"far_limit",
                LINKS "<joint name='j' type='revolute'>" ENDS "<limit lower='-1e12' upper='1' "
                      "velocity='1' effort='1'/></joint>",
                "3: <limit>: lower is beyond 1e+09: '-1e12'"},
        BadUrdf{"hex_number",
                LINKS "<joint name='j' type='fixed'>" ENDS "<origin xyz='0x1 0 0'/></joint>",
                "3: <origin>: xyz is not three finite numbers: '0x1 0 0'"},
        BadUrdf{"nan_multiplier",
                LINKS "<link name='c'/><joint name='k' type='continuous'><parent link='a'/><child "
                      "link='c'/></joint>\n<joint name='j' type='continuous'>" ENDS
                      "<mimic joint='k' multiplier='nan'/></joint>",
                "4: <mimic>: multiplier is not a finite number: 'nan'"},
        BadUrdf{"huge_sphere",
                "<link name='a'><collision><geometry><sphere "
                "radius='1e9'/></geometry></collision></link>",
                "2: <sphere>: radius is beyond 1000: '1e9'"},
        BadUrdf{"tiny_scale",
                "<link name='a'><collision><geometry><mesh filename='a.stl' scale='1 1e-9 "
                "1'/></geometry></collision></link>",
                "2: <collision> of link 'a': scale of <mesh> must not be zero"},
        BadUrdf{"no_mass",
                "<link name='a'>\n<inertial><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' "
                "izz='1'/></inertial></link>",
                "3: <inertial> of link 'a' has no <mass>"},
        BadUrdf{"negative_mass",
                "<link name='a'><inertial>\n<mass value='-1'/><inertia ixx='1' ixy='0' ixz='0' "
                "iyy='1' iyz='0' izz='1'/></inertial></link>",
                "3: <inertial> of link 'a': mass is negative"},
        BadUrdf{"no_moment",
                "<link name='a'><inertial><mass value='1'/>\n<inertia ixx='1' ixy='0' ixz='0' "
                "iyy='1' izz='1'/></inertial></link>",
                "3: <inertia> has no iyz"},
        BadUrdf{"dynamics",
                LINKS "<joint name='j' type='revolute'>" ENDS LIMIT "\n<dynamics/></joint>",
                "4: <joint> 'j': <dynamics> has no damping and no friction"},
        BadUrdf{"damping",
                LINKS "<joint name='j' type='revolute'>" ENDS LIMIT
                      "\n<dynamics damping='x'/></joint>",
                "4: <dynamics>: damping is not a finite number: 'x'"},
        BadUrdf{"calibration",
                LINKS "<joint name='j' type='revolute'>" ENDS LIMIT
                      "\n<calibration rising='x'/></joint>",
                "4: <calibration>: rising is not a finite number: 'x'"},
        BadUrdf{"safety",
                LINKS "<joint name='j' type='revolute'>" ENDS LIMIT
                      "\n<safety_controller/></joint>",
                "4: <safety_controller> has no k_velocity"},
        BadUrdf{"colour", "<link name='a'/>\n<material name='m'><color rgba='1 1 1'/></material>",
                "3: <color>: rgba is not 4 finite numbers: '1 1 1'"},
        BadUrdf{"no_colour", "<link name='a'/>\n<material name='m'/>",
                "3: <material> 'm' has neither color nor texture"},
        BadUrdf{
            "twice_material",
            "<link name='a'/>\n<material name='m'><color rgba='1 1 1 1'/></material>\n<material "
            "name='m'><color rgba='1 1 1 1'/></material>",
            "4: <material> 'm' is defined twice"},
        BadUrdf{"unknown_material",
                "<link name='a'><visual><geometry><sphere radius='1'/></geometry>\n<material "
                "name='m'/></visual></link>",
                "3: <material> 'm' is not defined"},
        BadUrdf{"long_name", "<link name='" X64 X64 X64 X64 "x'/>",
                "2: <link> has a name of 257 bytes, more than 256"},
        BadUrdf{"attribute_twice", "<link name='a' name='b'/>",
                "2: is not well-formed XML: XML_ERROR_PARSING_ATTRIBUTE"},
        BadUrdf{"no_name", LINKS "<joint type='fixed'>" ENDS "</joint>", "3: <joint> has no name"}),
    [](const auto& bad) { return std::string(bad.param.name); });

TEST(Urdf, OfAnotherVersionIsRefused) {
  EXPECT_THAT(faultsOf("<robot name='r' version='2.0'>\n<link name='a'/></robot>"),
              ::testing::ElementsAre("1: <robot> 'r': version is not 1.0: '2.0'"));
}

TEST(Urdf, SaysOnStandardErrorNothingOfItsOwn) {
  ::testing::internal::CaptureStderr();
  EXPECT_FALSE(faultsOf("<robot name='r'><link name='a'><inertial/></link></robot>").empty());
  EXPECT_TRUE(faultsOf("<robot name='r'><link name='a'/></robot>").empty());
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

TEST(Urdf, MayHaveWhatOthersAddToIt) {
  EXPECT_THAT(
      faultsOf("<?xml version='1.0'?><!-- = = --><robot name='r' xmlns:x='y'>"
               "<gazebo/><transmission name='t'/><material name='m'><color rgba='1 0 0 "
               "1'/></material>" LINKS "<joint name='j' type='revolute'>" ENDS
               "<limit lower='-1' upper='1' velocity='1' effort='1' x:acceleration='2'/>"
               "<x:extra/><dynamics damping='1'/><calibration rising='0'/>"
               "<safety_controller k_velocity='1'/></joint>"
               "<link name='c'><inertial><mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' "
               "iyz='0' izz='1'/></inertial><visual><geometry><box size='1 1 1'/></geometry>"
               "<material name='m'/></visual></link>"
               "<joint name='k' type='fixed'><parent link='a'/><child link='c'/></joint></robot>"),
      ::testing::ElementsAre());
}

TEST(Urdf, IslandOfALoopIsReportedPerLink) {
  EXPECT_THAT(
      faultsOf("<robot name='r'><link name='root'/>\n<link name='a'/>\n<link name='b'/>"
               "<joint name='j' type='fixed'>" ENDS "</joint>"
               "<joint name='k' type='fixed'><parent link='b'/><child link='a'/></joint></robot>"),
      ::testing::ElementsAre(
          "2: link 'a' cannot be reached from the root: the joints form a loop",
          "3: link 'b' cannot be reached from the root: the joints form a loop"));
}

TEST(Urdf, ListsEveryFault) {
  EXPECT_THAT(
      faultsOf(
          "<robot name='r'>\n<link name='a'><collision><geometry><box size='0 1 1'/></geometry>"
          "</collision></link>\n<joint name='j' type='ball'/>\n</robot>"),
      ::testing::ElementsAre("2: <collision> of link 'a': size of <box> must be positive",
                             "3: <joint> 'j' has no <parent>", "3: <joint> 'j' has no <child>",
                             "3: <joint> 'j': unknown type 'ball'"));
}

TEST(Urdf, RefusesWhatIsNoUrdf) {
  EXPECT_THAT(faultsOf(""),
              ::testing::ElementsAre("0: is not well-formed XML: XML_ERROR_EMPTY_DOCUMENT"));
  EXPECT_THAT(faultsOf("<robot name='r'>\n<link>\n</robot>"),
              ::testing::ElementsAre(::testing::HasSubstr("is not well-formed XML")));
  EXPECT_THAT(faultsOf("<sdf/>"), ::testing::ElementsAre("1: has no <robot> as its root element"));
  std::vector<FileFault> faults;
  readUrdf("/nonexistent/x.urdf", "x.urdf", faults);
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_EQ(faults[0].text(), "x.urdf: no such file");
}

TEST(Urdf, OfAnySizeIsRefusedSoon) {
  std::string links, joints, attributes, deep;
  for (int i = 0; i < 100'000; ++i) {
    links += "<link name='l" + std::to_string(i) + "'/>\n";
    attributes += " a" + std::to_string(i) + "='='";
    deep += "<a>";
  }
  for (int i = 0; i < 600; ++i) {
    joints += "<joint name='j" + std::to_string(i) + "' type='continuous'/>\n";
  }
  EXPECT_THAT(faultsOf("<robot name='r'>\n" + links + "</robot>"),
              ::testing::ElementsAre("1: <robot> 'r' has 100000 links, more than 4096"));
  EXPECT_THAT(faultsOf("<robot name='r'>" + joints + "</robot>"),
              ::testing::ElementsAre("1: <robot> 'r' has 600 joints that move, more than 512"));
  EXPECT_THAT(faultsOf("<robot name='r'>\n<link" + attributes + "/></robot>"),
              ::testing::ElementsAre("2: has an element with more than 256 attributes"));
  EXPECT_THAT(faultsOf("<robot name='r'>" + deep),
              ::testing::ElementsAre("1: is not well-formed XML: XML_ELEMENT_DEPTH_EXCEEDED"));
  const test::TemporaryFolder folder;
  const auto sparse = folder.write("r.urdf", "");
  std::filesystem::resize_file(sparse, std::uintmax_t{2} << 30);
  std::vector<FileFault> faults;
  readUrdf(sparse, "r.urdf", faults);
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_EQ(faults[0].text(), "r.urdf: is larger than 16 MiB");
}

TEST(Urdf, IsUtf8WithoutEntitiesOfItsOwn) {
  EXPECT_THAT(faultsOf("<?xml version='1.0' encoding='ISO-8859-1'?>\n<robot name='r\xE9'/>"),
              ::testing::ElementsAre("2: is not UTF-8 text"));
  EXPECT_THAT(faultsOf("<!DOCTYPE r [<!ENTITY a 'b'>]>\n<robot name='r'><link name='a'/></robot>"),
              ::testing::ElementsAre("1: has a document type: entities are not read"));
}

}  // namespace
}  // namespace handover
