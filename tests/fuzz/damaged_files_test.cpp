// SPDX-License-Identifier: Apache-2.0
// Files damaged at random (seeded): read or refused with a FileError, never anything else.
#include "damage.hpp"
#include "server/settings/tiny_root.hpp"
#include "settings/check.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <sstream>

namespace handover {
namespace {

using handover::testing::TinyRoot;
using test::damaged;
using test::fuzzRuns;

/// A tetrahedron as two instances of a node of the library.
constexpr const char* kDae = R"(<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="0.5" name="u"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g" name="g"><mesh>
<source id="p"><float_array id="pa" count="12">0 0 0 1 0 0 0 1 0 0 0 1</float_array>
<technique_common><accessor source="#pa" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<polylist count="4"><input semantic="VERTEX" source="#v" offset="0"/>
<vcount>3 3 3 3</vcount><p>0 2 1 0 1 3 1 2 3 0 3 2</p></polylist>
</mesh></geometry></library_geometries>
<library_nodes><node id="x"><rotate>0 0 1 90</rotate><instance_geometry url="#g"/></node></library_nodes>
<library_visual_scenes><visual_scene id="s" name="s">
<node id="a"><matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix><instance_node url="#x"/></node>
<node id="b"><translate>5 0 0</translate><instance_node url="#x"/><instance_geometry url="#g"/></node>
</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>
)";

constexpr const char* kAsciiStl =
    "solid t\n"
    "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0 1 0\nvertex 1 0 0\nendloop\nendfacet\n"
    "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 0 1\nendloop\nendfacet\n"
    "facet normal 0 0 0\nouter loop\nvertex 1 0 0\nvertex 0 1 0\nvertex 0 0 1\nendloop\nendfacet\n"
    "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0 0 1\nvertex 0 1 0\nendloop\nendfacet\n"
    "endsolid t\n";

std::string binaryStl() {
  static constexpr float kCorners[4][9] = {{0, 0, 0, 0, 1, 0, 1, 0, 0},
                                           {0, 0, 0, 1, 0, 0, 0, 0, 1},
                                           {1, 0, 0, 0, 1, 0, 0, 0, 1},
                                           {0, 0, 0, 0, 0, 1, 0, 1, 0}};
  std::string text(80, ' ');
  text += std::string("\4\0\0\0", 4);
  for (const auto& corners : kCorners) {
    text.append(12, '\0');  // the normal
    text.append(reinterpret_cast<const char*>(corners), sizeof(corners));
    text.append(2, '\0');
  }
  return text;
}

constexpr const char* kTetrahedron =
    "o t\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

/// Damages one file of a good root again and again and checks another.
void damageAndCheck(const std::string& damaged_file, const std::string& good,
                    const std::string& checked_file, int times) {
  const TinyRoot root;
  root.write(damaged_file, good);
  ASSERT_TRUE(checkFiles({root.path() / checked_file}, root.path()).faults.empty());
  int refused = 0;
  for (int seed = 1; seed <= fuzzRuns(times); ++seed) {
    std::mt19937_64 generator(static_cast<std::uint64_t>(seed));
    const std::string text = damaged(good, generator);
    root.write(damaged_file, text);
    const auto start = std::chrono::steady_clock::now();
    ASSERT_NO_THROW(refused +=
                    !checkFiles({root.path() / checked_file}, root.path()).faults.empty())
        << "seed " << seed << "\n"
        << text;
    ASSERT_LT(std::chrono::steady_clock::now() - start, test::kMostTime) << "seed " << seed << "\n"
                                                                         << text;
  }
  EXPECT_GT(refused, fuzzRuns(times) / 10);
}

TEST(DamagedFiles, Urdf) {
  damageAndCheck("robots/tiny/tiny.urdf", handover::testing::kTinyUrdf, "robots/tiny/tiny.yaml",
                 250);
}

TEST(DamagedFiles, Srdf) {
  damageAndCheck("robots/tiny/tiny.srdf", handover::testing::kTinySrdf, "robots/tiny/tiny.yaml",
                 250);
}

TEST(DamagedFiles, RobotSettings) {
  damageAndCheck("robots/tiny/tiny.yaml", handover::testing::kTinyYaml, "robots/tiny/tiny.yaml",
                 250);
}

TEST(DamagedFiles, Cell) {
  damageAndCheck("config/cells/test.yaml", handover::testing::kTinyCell, "config/cells/test.yaml",
                 250);
}

TEST(DamagedFiles, DaemonSettings) {
  damageAndCheck("handoverd.yaml", "version: 1\ncells: [test]\ndomain: 3\nthreads: 2\n",
                 "handoverd.yaml", 250);
}

TEST(DamagedFiles, Obj) { damageAndCheck("t.obj", kTetrahedron, "t.obj", 500); }

TEST(DamagedFiles, Dae) { damageAndCheck("t.dae", kDae, "t.dae", 500); }

TEST(DamagedFiles, AsciiStl) { damageAndCheck("t.stl", kAsciiStl, "t.stl", 500); }

TEST(DamagedFiles, BinaryStl) { damageAndCheck("t.stl", binaryStl(), "t.stl", 500); }

/// Tests read the shipped files too: they hold more of what files may hold.
TEST(DamagedFiles, ShippedUrdfAndSrdf) {
  const TinyRoot root;
  for (const char* name : {"robots/crichton/crichton.urdf", "robots/crichton/crichton.srdf"}) {
    std::ifstream stream(std::filesystem::path(HANDOVER_SOURCE_DIR) / name);
    std::ostringstream good;
    good << stream.rdbuf();
    ASSERT_GT(good.str().size(), 1000u);
    for (int seed = 1; seed <= fuzzRuns(40); ++seed) {
      std::mt19937_64 generator(static_cast<std::uint64_t>(seed));
      const std::string text = damaged(good.str(), generator);
      ASSERT_NO_THROW(checkFiles({root.write("any", text)}, root.path())) << "seed " << seed;
    }
  }
}

TEST(DamagedFiles, OverrideValuesAndPaths) {
  const TinyRoot root;
  const Cell cell = root.load();
  const std::vector<Override> good = {{"robots.right.base.xyz", "[2, 0.1, 0]"},
                                      {"objects.cup.geometry", "{type: box, size: [1, 1, 1]}"},
                                      {"robots.left.arms.arm.tool.xyz", "[0.45, 0, 0.5]"},
                                      {"tasks.fetch.goal_rest", "[table, floor]"}};
  for (std::uint64_t seed = 1; seed <= static_cast<std::uint64_t>(fuzzRuns(300)); ++seed) {
    std::mt19937_64 generator(seed);
    Override change = good[generator() % good.size()];
    if (generator() % 3 == 0) change.path = damaged(change.path, generator);
    if (generator() % 3 != 0) change.value = damaged(change.value, generator);
    ASSERT_NO_THROW((void)cell.instantiate({change}, 1)) << change.path << " = " << change.value;
  }
}

}  // namespace
}  // namespace handover
