// SPDX-License-Identifier: Apache-2.0
// A root folder with one small robot and a cell that is right; tests change one thing at a time.
#pragma once

#include "settings/cell_file.hpp"
#include "support/temporary_folder.hpp"

#include <string>

namespace handover::testing {

inline constexpr const char* kTinyUrdf = R"(<robot name="tiny">
  <link name="base"/><link name="upper"/><link name="palm"/><link name="finger"/>
  <joint name="swing" type="revolute"><parent link="base"/><child link="upper"/>
    <axis xyz="0 0 1"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
  <joint name="reach" type="prismatic"><parent link="upper"/><child link="palm"/>
    <origin xyz="0.2 0 0.5"/><axis xyz="1 0 0"/><limit lower="0" upper="0.5" velocity="1" effort="1"/></joint>
  <joint name="bend" type="revolute"><parent link="palm"/><child link="finger"/>
    <axis xyz="0 1 0"/><limit lower="0" upper="1" velocity="1" effort="1"/></joint>
</robot>
)";

inline constexpr const char* kTinySrdf = R"(<robot name="tiny">
  <group name="arm"><chain base_link="base" tip_link="palm"/></group>
  <group_state name="home" group="arm"><joint name="swing" value="0.5"/></group_state>
</robot>
)";

inline constexpr const char* kTinyYaml = R"(version: 1
name: tiny
urdf: tiny.urdf
srdf: tiny.srdf
arms:
  arm: {tool_link: palm, approach_axis: [1, 0, 0], hand: hand, acceleration: 0.5}
hands:
  hand:
    palm_link: palm
    fingers: [[bend]]
    finger_links: [finger]
    open: {bend: 0}
    closed: {bend: 1}
    acceleration: 5
)";

inline constexpr const char* kTinyCell = R"(version: 1
name: test
robots:
  left:
    model: tiny
    base: {xyz: [0, 0, 0]}
    posture: home
    joints: {reach: 0.1}
    resting: [[base, floor]]
  right:
    model: tiny
    base: {xyz: [2, 0, 0], rpy_deg: [0, 0, 180]}
objects:
  floor: {geometry: {type: box, size: [6, 6, 0.1]}, pose: {xyz: [0, 0, -0.05]}}
  table:
    geometry: {type: box, size: [1, 1, 0.5]}
    pose: {xyz: [1, 1, 0.25], rpy_deg: [0, 0, 90]}
    resting: [floor]
  tray:
    geometry: {type: cylinder, radius: 0.1, length: 0.01}
    attached_to: {robot: right, link: palm, pose: {xyz: [0.1, 0, 0]}, touch_links: [palm, finger]}
  cup:
    geometry: {type: sphere, radius: 0.03}
    pose: {frame: table, xyz: [0.1, 0, 0.28]}
    resting: [table]
    grasps: {left: {hand: 10}, right: {hand: 20}}
tasks:
  serve:
    object: cup
    giver: left
    receiver: right
    goal: {frame: tray, xyz: [0, 0, 0.035]}
  fetch:
    object: cup
    giver: right
    receiver: left
    start: {xyz: [1.5, 0, 0.5]}
    goal: {frame: left/palm, xyz: [0, 0, 1], quat_wxyz: [0, 1, 0, 0]}
    goal_rest: [table]
vary:
  robots.right.base.xyz: {range: [[2, -0.5, 0], [2, 0.5, 0]]}
  robots.right.base.rpy_deg: {range: [[0, 0, -15], [0, 0, 15]], facing: [0, 0]}
  objects.cup.geometry.radius: {choices: [0.03, 0.04]}
)";

class TinyRoot {
 public:
  TinyRoot() {
    folder_.write("robots/tiny/tiny.urdf", kTinyUrdf);
    folder_.write("robots/tiny/tiny.srdf", kTinySrdf);
    folder_.write("robots/tiny/tiny.yaml", kTinyYaml);
    folder_.write("config/cells/test.yaml", kTinyCell);
  }

  const std::filesystem::path& path() const { return folder_.path(); }

  std::filesystem::path write(const std::string& name, const std::string& text) const {
    return folder_.write(name, text);
  }

  Cell load(const std::string& text = kTinyCell) const {
    ModelCache models;
    return Cell::load(folder_.write("config/cells/test.yaml", text), path(), models);
  }

  /// "line: message" of every fault of a cell text, the file's name left out.
  std::vector<std::string> faultsOf(const std::string& text) const {
    std::vector<std::string> shown;
    try {
      load(text);
    } catch (const FileError& error) {
      for (const FileFault& fault : error.faults()) {
        shown.push_back(std::to_string(fault.line) + ": " + fault.message);
      }
    }
    return shown;
  }

 private:
  test::TemporaryFolder folder_;
};

/// The text with the first `from` replaced; throws when there is none.
inline std::string with(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

}  // namespace handover::testing
