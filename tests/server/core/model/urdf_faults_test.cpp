// SPDX-License-Identifier: Apache-2.0
// One bad URDF per rule: the fault and its line.
#include "core/model/urdf_reader.hpp"
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
                "3: <origin>: xyz is not three finite numbers: '0\t0 0'"},
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
        BadUrdf{"no_name", LINKS "<joint type='fixed'>" ENDS "</joint>", "3: <joint> has no name"}),
    [](const auto& bad) { return std::string(bad.param.name); });

TEST(Urdf, OfAnotherVersionIsRefused) {
  EXPECT_THAT(faultsOf("<robot name='r' version='2.0'>\n<link name='a'/></robot>"),
              ::testing::ElementsAre("1: <robot> 'r': version is not 1.0: '2.0'"));
}

TEST(Urdf, TellsWhatOnlyUrdfdomRefuses) {
  ::testing::internal::CaptureStderr();
  EXPECT_THAT(
      faultsOf("<robot name='r'><link name='a'><inertial/></link></robot>"),
      ::testing::ElementsAre(::testing::AllOf(::testing::StartsWith("0: urdfdom refuses it: "),
                                              ::testing::HasSubstr("nertial"))));
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
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

}  // namespace
}  // namespace handover
