// SPDX-License-Identifier: Apache-2.0
#include "settings/cell_file.hpp"

#include "tiny_root.hpp"

#include <gmock/gmock.h>

namespace handover {
namespace {

using handover::testing::kTinyCell;
using handover::testing::TinyRoot;
using handover::testing::with;
using ::testing::ElementsAre;

const std::string kNoRadiusVaried =
    with(kTinyCell, "  objects.cup.geometry.radius: {choices: [0.03, 0.04]}\n", "");

Cell::Instance instanceOf(const Cell& cell) {
  return std::get<Cell::Instance>(cell.instantiate({}, 3));
}

TEST(Cell, ResolvesRobotsObjectsAndTasksIntoTheWorld) {
  const TinyRoot root;
  const Cell cell = root.load();
  EXPECT_EQ(cell.name(), "test");
  EXPECT_THAT(cell.taskNames(), ElementsAre("serve", "fetch"));
  const Cell::Instance instance = instanceOf(cell);
  const Scene& scene = *instance.scene;
  EXPECT_EQ(scene.cell, "test");
  EXPECT_EQ(scene.revision, 3u);
  ASSERT_EQ(scene.robots.size(), 2u);
  EXPECT_EQ(scene.robots[0].model, scene.robots[1].model);
  EXPECT_EQ(scene.robots[0].q_start, Eigen::Vector3d(0.5, 0.1, 0));
  EXPECT_EQ(scene.robots[1].q_start, Eigen::Vector3d::Zero());
  EXPECT_THAT(scene.robots[0].resting, ElementsAre(::testing::Pair(LinkId(0), "floor")));

  const SceneObject& cup = scene.objects[3];
  // 0.1 along the table's x, which a quarter turn makes the world's y.
  EXPECT_TRUE(cup.X_WO.translation().isApprox(Eigen::Vector3d(1, 1.1, 0.53), 1e-12));
  EXPECT_EQ(cup.X_WO.linear(), rotationFromRpy(0, 0, 0) * scene.objects[1].X_WO.linear());
  EXPECT_EQ(cup.X_WO.linear()(0, 0), 0.0);
  EXPECT_EQ(cup.grasp_counts.at("right").at("hand"), 20);
  EXPECT_THAT(cup.resting, ElementsAre("table"));

  // The tray, 0.1 before the palm of a robot that looks the other way.
  const SceneObject& tray = scene.objects[2];
  ASSERT_TRUE(tray.attached_to);
  EXPECT_TRUE(tray.X_WO.translation().isApprox(Eigen::Vector3d(1.7, 0, 0.5), 1e-12));
  EXPECT_THAT(tray.attached_to->touch_links, ElementsAre(LinkId(2), LinkId(3)));

  const SceneTask& serve = instance.tasks[0];
  EXPECT_EQ(serve.X_WO_start.matrix(), cup.X_WO.matrix());
  EXPECT_TRUE(serve.X_WO_goal.translation().isApprox(Eigen::Vector3d(1.7, 0, 0.535), 1e-12));
  EXPECT_EQ(serve.start_rest.objects, std::vector<std::string>{"table"});
  EXPECT_EQ(serve.goal_rest.objects, std::vector<std::string>{"tray"});
  const SceneTask& fetch = instance.tasks[1];
  EXPECT_EQ(fetch.X_WO_start.translation(), Eigen::Vector3d(1.5, 0, 0.5));
  EXPECT_EQ(fetch.goal_rest.objects, std::vector<std::string>{"table"});
  EXPECT_NEAR(fetch.X_WO_goal.translation().z(), 1.5, 1e-12);
  EXPECT_TRUE((fetch.X_WO_goal.linear() * Eigen::Vector3d::UnitZ())
                  .isApprox(-Eigen::Vector3d::UnitZ(), 1e-12));
}

TEST(Cell, KeepsHowFarTheObjectMayLean) {
  const TinyRoot root;
  const Cell cell =
      root.load(with(kTinyCell, "goal_rest: [table]",
                     "goal_rest: [table]\n    upright: {axis: [0, 0, -2], within_deg: 12.5}"));
  const Cell::Instance instance = instanceOf(cell);
  EXPECT_EQ(instance.tasks[0].upright, std::nullopt);
  EXPECT_EQ(instance.tasks[1].upright, (UprightSnapshot{{0, 0, -2}, 12.5}));
  SceneTask task = instance.tasks[1];
  EXPECT_EQ(snapshot(*instance.scene, task, 1).upright, task.upright);
  // A plan depends on it.
  const std::string hash = sceneHash(*instance.scene, task);
  task.upright->within_deg = 12;
  EXPECT_NE(sceneHash(*instance.scene, task), hash);
  task.upright.reset();
  EXPECT_NE(sceneHash(*instance.scene, task), hash);
}

TEST(Cell, LetsAnObjectStartOnWhatItsTaskSays) {
  const auto restOf = [](const std::string& start) {
    const TinyRoot root;
    const Cell cell = root.load(with(kTinyCell, "start: {xyz: [1.5, 0, 0.5]}", start));
    return instanceOf(cell).tasks[1].start_rest.objects;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(restOf("start: {xyz: [1.5, 0, 0.5]}"), std::nullopt);
  EXPECT_EQ(restOf("start: {frame: tray, xyz: [0, 0, 0.035]}"), Names{"tray"});
  EXPECT_EQ(restOf("start_rest: [floor, tray]"), (Names{"floor", "tray"}));
  EXPECT_EQ(restOf("start: {frame: tray, xyz: [0, 0, 0.035]}\n    start_rest: []"), Names{});
}

TEST(Cell, SharesModelsAlreadyLoaded) {
  const TinyRoot root;
  ModelCache models;
  const auto file = root.path() / "config/cells/test.yaml";
  const Cell first = Cell::load(file, root.path(), models);
  EXPECT_EQ(models.size(), 1u);
  const Cell second = Cell::load(file, root.path(), models);
  EXPECT_EQ(instanceOf(first).scene->robots[0].model, instanceOf(second).scene->robots[0].model);
}

TEST(Cell, KeepsVariations) {
  const TinyRoot root;
  const Cell cell = root.load();
  const std::vector<Variation>& variations = cell.variations();
  ASSERT_EQ(variations.size(), 3u);
  EXPECT_EQ(variations[0].path, "robots.right.base.xyz");
  EXPECT_THAT(variations[0].from, ElementsAre(2, -0.5, 0));
  EXPECT_THAT(variations[0].to, ElementsAre(2, 0.5, 0));
  EXPECT_FALSE(variations[0].facing);
  EXPECT_EQ(variations[1].facing, (std::array<double, 2>{0, 0}));
  EXPECT_THAT(variations[2].choices, ElementsAre("0.03", "0.04"));
}

TEST(Cell, ReadsCompoundsAndMeshes) {
  const TinyRoot root;
  root.write("meshes/t.obj",
             "o t\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
  const Cell cell =
      root.load(with(kNoRadiusVaried, "{type: sphere, radius: 0.03}",
                     "{type: compound, parts: [{name: ball, pose: {xyz: [0, 0, 1]}, "
                     "geometry: {type: sphere, radius: 0.03}}, {geometry: {type: mesh, "
                     "path: meshes/t.obj, scale: [0.1, 0.1, 0.1]}}]}"));
  const Cell::Instance instance = instanceOf(cell);
  const SceneObject& cup = instance.scene->objects[3];
  ASSERT_EQ(cup.shapes.size(), 2u);
  EXPECT_EQ(cup.shapes[0].X_BS.translation(), Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(std::get<ConvexShape>(cup.shapes[1].geometry).vertices.size(), 4u);
  const auto& parts = std::get<CompoundGeometry>(cup.geometry).parts;
  EXPECT_EQ(std::get<MeshGeometry>(parts[1].geometry).path, "meshes/t.obj");
}

struct BadCell {
  const char* name;
  const char* from;  ///< in kTinyCell
  const char* to;
  const char* message;  ///< "line: message", the only fault
};

std::ostream& operator<<(std::ostream& out, const BadCell& bad) { return out << bad.name; }

class CellFault : public ::testing::TestWithParam<BadCell> {};

TEST(CellFile, BoundsAllMeshesTogether) {
  const TinyRoot root;
  std::string parts;
  for (int i = 0; i < 9; ++i) {  // each by itself may be so large
    const std::string name = "meshes/m" + std::to_string(i) + ".stl";
    std::filesystem::resize_file(root.write(name, "solid"), std::uintmax_t{60} << 20);
    parts += (i > 0 ? ", {" : "{") + ("geometry: {type: mesh, path: " + name + "}}");
  }
  EXPECT_THAT(root.faultsOf(with(kTinyCell, "{type: box, size: [1, 1, 0.5]}",
                                 "{type: compound, parts: [" + parts + "]}")),
              ElementsAre("16: objects.table.geometry: the meshes up to here have more than 512 "
                          "MiB"));
}

TEST_P(CellFault, IsReportedWithItsLine) {
  const BadCell& bad = GetParam();
  EXPECT_THAT(TinyRoot().faultsOf(with(kTinyCell, bad.from, bad.to)), ElementsAre(bad.message));
}

INSTANTIATE_TEST_SUITE_P(
    All, CellFault,
    ::testing::Values(
        BadCell{"version", "version: 1", "version: 2",
                "1: version: must be a whole number from 1 to 1, not '2'"},
        BadCell{"no_version", "version: 1\n", "", "1: has no 'version'"},
        BadCell{"top_key", "name: test", "name: test\ncolour: red",
                "3: colour: unknown key; the nearest known one is 'robots'"},
        BadCell{"robot_key", "posture: home", "postur: home",
                "7: robots.left.postur: unknown key; the nearest known one is 'posture'"},
        BadCell{"twice", "posture: home", "model: tiny",
                "7: robots.left: has the key 'model' twice, first in line 5"},
        BadCell{"no_model", "    model: tiny\n    base: {xyz: [0, 0, 0]}",
                "    base: {xyz: [0, 0, 0]}", "4: robots.left: has no 'model'"},
        BadCell{"bad_name", "  right:\n", "  'r d': {model: tiny, base: {}}\n  right:\n",
                "10: robots.r d: 'r d' is not a name: up to 64 letters, digits, '_' and '-'"},
        BadCell{"base_frame", "base: {xyz: [0, 0, 0]}", "base: {frame: shelf, xyz: [0, 0, 0]}",
                "6: robots.left.base.frame: 'shelf' is neither world, an object, a robot nor "
                "robot/link; the nearest known one is 'left'"},
        BadCell{"base_on_its_own_tray", "base: {xyz: [2, 0, 0], rpy_deg: [0, 0, 180]}",
                "base: {frame: tray}", "12: robots.right.base.frame: cyclic frame reference"},
        BadCell{"two_numbers", "xyz: [0, 0, 0]", "xyz: [0, 0]",
                "6: robots.left.base.xyz: must be a list of three numbers"},
        BadCell{"nan", "xyz: [0, 0, 0]", "xyz: [0, .nan, 0]",
                "6: robots.left.base.xyz.1: must be a finite number, not '.nan'"},
        BadCell{"far", "xyz: [0, 0, 0]", "xyz: [0, 5000, 0]",
                "6: robots.left.base.xyz.1: must be within -1000 and 1000, not '5000'"},
        BadCell{"text_number", "radius: 0.03", "radius: big",
                "23: objects.cup.geometry.radius: must be a finite number, not 'big'"},
        BadCell{"negative", "radius: 0.03", "radius: -0.03",
                "23: objects.cup.geometry.radius: must be within 1e-06 and 1000, not '-0.03'"},
        BadCell{"geometry_type", "type: sphere", "type: ball",
                "23: objects.cup.geometry.type: must be one of box, sphere, cylinder, mesh, "
                "compound, not "
                "'ball'"},
        BadCell{"mesh_missing", "{type: sphere, radius: 0.03}", "{type: mesh, path: ../x.obj}",
                "23: objects.cup.geometry.path: must lie inside the root"},
        BadCell{"rotation_twice", "rpy_deg: [0, 0, 90]",
                "rpy_deg: [0, 0, 90], quat_wxyz: [1, 0, 0, 0]",
                "17: objects.table.pose: has both rpy_deg and quat_wxyz"},
        BadCell{"quaternion", "quat_wxyz: [0, 1, 0, 0]", "quat_wxyz: [0, 1.1, 0, 0]",
                "38: tasks.fetch.goal.quat_wxyz: must have length 1"},
        BadCell{"posture", "posture: home", "posture: sleep",
                "7: robots.left.posture: 'sleep' is no group state of robot 'tiny'; the nearest "
                "known one is 'home'"},
        BadCell{"joint", "reach: 0.1", "jump: 0.1",
                "8: robots.left.joints.jump: no such joint in robot 'tiny'; the nearest known one "
                "is 'bend'"},
        BadCell{
            "joint_limit", "reach: 0.1", "reach: 0.6",
            "8: robots.left.joints.reach: is outside the joint's limits: 0.6 is not from 0 to 0.5"},
        BadCell{"resting_link", "[[base, floor]]", "[[basis, floor]]",
                "9: robots.left.resting: link 'basis' is not in robot 'tiny'; the nearest known "
                "one is 'base'"},
        BadCell{"resting_pair", "[[base, floor]]", "[[base]]",
                "9: robots.left.resting.0: must be [link, object]"},
        BadCell{"resting_object", "resting: [table]", "resting: [desk]",
                "25: objects.cup.resting: no object 'desk' in this cell; the nearest known one is "
                "'cup'"},
        BadCell{"no_pose", "    pose: {frame: table, xyz: [0.1, 0, 0.28]}\n", "",
                "22: objects.cup: has neither pose nor attached_to"},
        BadCell{"frame", "frame: table", "frame: desk",
                "24: objects.cup.pose.frame: 'desk' is neither world, an object, a robot nor "
                "robot/link; the nearest known one is 'left'"},
        BadCell{"frame_circle", "pose: {xyz: [1, 1, 0.25], rpy_deg: [0, 0, 90]}",
                "pose: {frame: cup}", "17: objects.table.pose.frame: cyclic frame reference"},
        BadCell{"attached_link", "link: palm, pose", "link: hand, pose",
                "21: objects.tray.attached_to.link: link 'hand' is not in robot 'tiny'; the "
                "nearest known one is 'base'"},
        BadCell{"attached_robot", "robot: right, link", "robot: nobody, link",
                "21: objects.tray.attached_to.robot: no robot 'nobody' in this cell; the nearest "
                "known one is 'left'"},
        BadCell{"grasp_hand", "right: {hand: 20}", "right: {foot: 20}",
                "26: objects.cup.grasps.right.foot: robot 'right' has no such hand; the nearest "
                "known one is 'hand'"},
        BadCell{
            "grasp_count", "right: {hand: 20}", "right: {hand: 0}",
            "26: objects.cup.grasps.right.hand: must be a whole number from 1 to 10000, not '0'"},
        BadCell{
            "task_object", "object: cup", "object: mug",
            "29: tasks.serve.object: no object 'mug' in this cell; the nearest known one is 'cup'"},
        BadCell{"task_giver", "giver: left", "giver: nobody",
                "30: tasks.serve.giver: no robot 'nobody' in this cell; the nearest known one is "
                "'left'"},
        BadCell{"task_self", "receiver: right", "receiver: left",
                "31: tasks.serve.receiver: successive holders must be different arms"},
        BadCell{"task_no_goal", "    goal: {frame: tray, xyz: [0, 0, 0.035]}\n", "",
                "28: tasks.serve: has no 'goal'"},
        BadCell{"task_own_frame", "goal: {frame: tray", "goal: {frame: cup",
                "32: tasks.serve.goal.frame: is the task's own object"},
        BadCell{"start_rest", "goal_rest: [table]", "start_rest: [desk]",
                "39: tasks.fetch.start_rest: no object 'desk' in this cell; the nearest known one "
                "is 'cup'"},
        BadCell{"goal_rest", "goal_rest: [table]", "goal_rest: [cup]",
                "39: tasks.fetch.goal_rest: rests on itself"},
        BadCell{"upright_no_map", "goal_rest: [table]", "upright: true",
                "39: tasks.fetch.upright: must be a map, not 'true'"},
        BadCell{"upright_axis", "goal_rest: [table]", "upright: {axis: [0, 0, 0], within_deg: 5}",
                "39: tasks.fetch.upright.axis: is zero"},
        BadCell{"upright_flat", "goal_rest: [table]", "upright: {axis: [0, 1], within_deg: 5}",
                "39: tasks.fetch.upright.axis: must be a list of three numbers"},
        BadCell{"upright_beyond", "goal_rest: [table]",
                "upright: {axis: [0, 0, 1], within_deg: 180.5}",
                "39: tasks.fetch.upright.within_deg: must be within 0 and 180, not '180.5'"},
        BadCell{"upright_below", "goal_rest: [table]", "upright: {axis: [0, 0, 1], within_deg: -1}",
                "39: tasks.fetch.upright.within_deg: must be within 0 and 180, not '-1'"},
        BadCell{"upright_how_far", "goal_rest: [table]", "upright: {axis: [0, 0, 1]}",
                "39: tasks.fetch.upright: has no 'within_deg'"},
        BadCell{"upright_key", "goal_rest: [table]",
                "upright: {axis: [0, 0, 1], within_deg: 5, within: 5}",
                "39: tasks.fetch.upright.within: unknown key; the nearest known one is "
                "'within_deg'"},
        BadCell{"quoted_number", "radius: 0.03", "radius: '0.03'",
                "23: objects.cup.geometry.radius: must be a finite number, not the text '0.03'"},
        BadCell{"decimal_comma", "radius: 0.03", "radius: '0,03'",
                "23: objects.cup.geometry.radius: must be a finite number, not the text '0,03'"},
        BadCell{"hex", "radius: 0.03", "radius: 0x1",
                "23: objects.cup.geometry.radius: must be a finite number, not '0x1'"},
        BadCell{"too_large", "radius: 0.03", "radius: 1e400",
                "23: objects.cup.geometry.radius: must be a finite number, not '1e400'"},
        BadCell{"empty_key", "posture: home", "'': home", "4: robots.left: has an empty key"},
        BadCell{"robot_world", "  right:\n", "  world: {model: tiny, base: {}}\n  right:\n",
                "10: robots.world: 'world' is the world's own name"},
        BadCell{"object_world", "  floor: {geom",
                "  world: {geometry: {type: sphere, radius: 1}, pose: {}}\n  floor: {geom",
                "14: objects.world: 'world' is the world's own name"},
        BadCell{"object_robot", "  floor: {geom",
                "  left: {geometry: {type: sphere, radius: 1}, pose: {}}\n  floor: {geom",
                "14: objects.left: is the name of a robot too"},
        BadCell{"tool_arm", "posture: home", "arms: {leg: {tool: {xyz: [0, 0, 0]}}}",
                "7: robots.left.arms.leg: robot 'tiny' has no such arm; the nearest known one is "
                "'arm'"},
        BadCell{"tool_reach", "posture: home", "arms: {arm: {tool: {xyz: [9, 0, 0]}}}",
                "7: robots.left.arms.arm.tool: arm 'arm' of robot 'left' cannot reach this pose "
                "within its limits"},
        BadCell{"tool_key", "posture: home", "arms: {arm: {tol: {xyz: [9, 0, 0]}}}",
                "7: robots.left.arms.arm.tol: unknown key; the nearest known one is 'tool'"},
        BadCell{"no_size", "type: sphere, radius: 0.03", "type: cylinder, radius: 0.03",
                "23: objects.cup.geometry: has no 'length'"},
        BadCell{"key_of_another_type", "type: sphere, radius: 0.03",
                "type: sphere, radius: 0.03, size: 1",
                "23: objects.cup.geometry.size: unknown key; the nearest known one is 'type'"},
        BadCell{"no_parts", "type: sphere, radius: 0.03", "type: compound, parts: []",
                "23: objects.cup.geometry.parts: must have 1 to 256 entries"},
        BadCell{"nested_compound", "type: sphere, radius: 0.03",
                "type: compound, parts: [{geometry: {type: compound, parts: []}}]",
                "23: objects.cup.geometry.parts.0.geometry.type: must be one of box, sphere, "
                "cylinder, mesh, not 'compound'"},
        BadCell{"mesh_scale", "{type: sphere, radius: 0.03}",
                "{type: mesh, path: a.obj, scale: [1, 0, 1]}",
                "23: objects.cup.geometry.scale: must not be zero"},
        BadCell{"touch_link", "touch_links: [palm, finger]", "touch_links: [palm, thumb]",
                "21: objects.tray.attached_to.touch_links: link 'thumb' is not in robot 'tiny'; "
                "the nearest known one is 'palm'"},
        BadCell{"pose_and_attached", "rpy_deg: [0, 0, 90]}\n",
                "rpy_deg: [0, 0, 90]}\n    attached_to: {robot: left, link: palm}\n",
                "15: objects.table: has both pose and attached_to"},
        BadCell{"rests_on_itself", "resting: [table]", "resting: [cup]",
                "25: objects.cup.resting: rests on itself"},
        BadCell{"grasp_robot", "right: {hand: 20}", "nobody: {hand: 20}",
                "26: objects.cup.grasps.nobody: no robot 'nobody' in this cell; the nearest known "
                "one is 'left'"},
        BadCell{
            "grasp_negative", "right: {hand: 20}", "right: {hand: -5}",
            "26: objects.cup.grasps.right.hand: must be a whole number from 1 to 10000, not '-5'"},
        BadCell{"grasp_huge", "right: {hand: 20}", "right: {hand: 1e30}",
                "26: objects.cup.grasps.right.hand: must be a whole number from 1 to 10000, not "
                "'1e30'"},
        BadCell{"task_attached", "object: cup\n    giver: right", "object: tray\n    giver: right",
                "34: tasks.fetch.object: 'tray' is attached to a robot"},
        BadCell{"task_receiver", "receiver: right", "receiver: nobody",
                "31: tasks.serve.receiver: no robot 'nobody' in this cell; the nearest known one "
                "is 'left'"},
        BadCell{"task_start_frame", "start: {xyz", "start: {frame: desk, xyz",
                "37: tasks.fetch.start.frame: 'desk' is neither world, an object, a robot nor "
                "robot/link; the nearest known one is 'left'"},
        BadCell{"held_by_arm", "start: {xyz: [1.5, 0, 0.5]}", "start: {held_by: left/amr}",
                "37: tasks.fetch.start.held_by: robot 'left' has no arm 'amr'; the nearest known "
                "one is 'arm'"},
        BadCell{"held_by_robot", "start: {xyz: [1.5, 0, 0.5]}", "start: {held_by: left}",
                "37: tasks.fetch.start.held_by: must name the arm: robot/arm"},
        BadCell{"task_goal_link", "frame: left/palm", "frame: left/fist",
                "38: tasks.fetch.goal.frame: link 'fist' is not in robot 'tiny'; the nearest known "
                "one is 'base'"},
        BadCell{"vary_facing", "{choices: [0.03, 0.04]}", "{range: [0.03, 0.04], facing: [0, 0]}",
                "43: vary.objects.cup.geometry.radius.facing: must be [x, y], beside a range of "
                "rpy_deg"},
        BadCell{"vary_sizes", "[2, 0.5, 0]]", "[2, 0.5]]",
                "41: vary.robots.right.base.xyz.range: must have two ends of the same size"},
        BadCell{
            "vary_path", "objects.cup.geometry.radius: {", "objects.cap.geometry.radius: {",
            "43: vary.objects.cap.geometry.radius: unknown path: no 'cap' in objects; the nearest "
            "known one is 'objects.cup'"},
        BadCell{"vary_value", "choices: [0.03, 0.04]", "choices: [0.03, -1]",
                "43: vary.objects.cup.geometry.radius: must be within 1e-06 and 1000, not '-1'"},
        BadCell{"vary_order", "[2, 0.5, 0]]", "[2, -1, 0]]",
                "41: vary.robots.right.base.xyz.range: lower bound exceeds upper"},
        BadCell{"vary_facing_alone",
                "  robots.right.base.xyz: {range: [[2, -0.5, 0], [2, 0.5, 0]]}\n", "",
                "41: vary.robots.right.base.rpy_deg.facing: needs a range of "
                "robots.right.base.xyz too"},
        BadCell{"vary_both", "{choices: [0.03, 0.04]}", "{}",
                "43: vary.objects.cup.geometry.radius: must have either range or choices"}),
    [](const auto& bad) { return std::string(bad.param.name); });

TEST(Cell, MustHaveATask) {
  const std::string text = with(kTinyCell, "tasks:\n", "tasks: {}\nspare:\n");
  EXPECT_THAT(TinyRoot().faultsOf(text),
              ElementsAre("28: spare: unknown key; the nearest known one is 'name'",
                          "27: tasks: is empty"));
}

TEST(Cell, MayNotBeOfAnySize) {
  std::string choices = "0.03", objects;
  for (int i = 0; i < 600; ++i) choices += ", 0.03";
  EXPECT_THAT(TinyRoot().faultsOf(with(kTinyCell, "choices: [0.03", "choices: [" + choices)),
              ElementsAre("40: vary: has more than 512 ends and choices"));
  for (int i = 0; i < 1100; ++i) objects += "  o" + std::to_string(i) + ": {}\n";
  EXPECT_THAT(TinyRoot().faultsOf(with(kTinyCell, "objects:\n", "objects:\n" + objects)),
              ElementsAre("13: objects: has 1104 entries, more than 1024"));
  EXPECT_THAT(
      TinyRoot().faultsOf(with(kTinyCell, "posture: home", std::string(600, 'x') + ": home")),
      ElementsAre("4: robots.left: has a key of 600 bytes"));
}

TEST(Cell, ListsFaultsOfEveryKindAtOnce) {
  const TinyRoot root;
  root.write("robots/tiny/tiny.srdf", with(handover::testing::kTinySrdf, "value=", "valu="));
  std::string text = with(kTinyCell, "posture: home", "postur: home");
  text = with(text, "resting: [table]", "resting: [desk]");
  // What the robot's files say is not known: the cell's names wait until they are right.
  EXPECT_THAT(root.faultsOf(text),
              ElementsAre("7: robots.left.postur: unknown key; the nearest known one is 'posture'",
                          "3: <joint> 'swing' has no value"));
  root.write("robots/tiny/tiny.srdf", handover::testing::kTinySrdf);
  EXPECT_THAT(root.faultsOf(text),
              ElementsAre("7: robots.left.postur: unknown key; the nearest known one is 'posture'",
                          "25: objects.cup.resting: no object 'desk' in this cell; the nearest "
                          "known one is 'cup'"));
}

TEST(Cell, ListsEveryFault) {
  const TinyRoot root;
  std::string text = with(kTinyCell, "posture: home", "postur: home");
  text = with(text, "radius: 0.03", "radius: x");
  text = with(text, "object: cup", "objekt: cup");
  EXPECT_THAT(
      root.faultsOf(text),
      ElementsAre("7: robots.left.postur: unknown key; the nearest known one is 'posture'",
                  "23: objects.cup.geometry.radius: must be a finite number, not 'x'",
                  "28: tasks.serve: has no 'object'",
                  "29: tasks.serve.objekt: unknown key; the nearest known one is 'object'"));
}

TEST(Cell, ReportsYamlSyntaxByLine) {
  const auto faults = TinyRoot().faultsOf("version: 1\nname: [\n");
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_THAT(faults[0], ::testing::MatchesRegex("[23]: is not well-formed YAML: .*"));
  EXPECT_THAT(TinyRoot().faultsOf("[]"), ElementsAre("1: must be a map, not a list"));
}

TEST(Cell, ReportsAModelThatIsNotThere) {
  const auto faults = TinyRoot().faultsOf(
      with(kTinyCell, "model: tiny\n    base: {xyz: [2", "model: tin\n    base: {xyz: [2"));
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_THAT(faults[0], ::testing::StartsWith("11: robots.right.model: no model 'tin': "));
}

TEST(Cell, ReportsFaultsOfItsRobots) {
  const TinyRoot root;
  root.write("robots/tiny/tiny.urdf", with(handover::testing::kTinyUrdf, "0 0 1", "0 0 0"));
  try {
    root.load();
    FAIL();
  } catch (const FileError& error) {
    ASSERT_EQ(error.faults().size(), 1u);
    EXPECT_THAT(error.faults()[0].text(),
                ::testing::EndsWith("tiny.urdf:4: <joint> 'swing': axis is zero"));
  }
}

}  // namespace
}  // namespace handover
