// SPDX-License-Identifier: Apache-2.0
#include "settings/check.hpp"

#include "tiny_root.hpp"

#include <gmock/gmock.h>

namespace handover {
namespace {

using handover::testing::TinyRoot;
using handover::testing::with;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class CheckFiles : public ::testing::Test {
 protected:
  std::vector<std::string> check(const std::vector<std::string>& names) const {
    std::vector<std::filesystem::path> files;
    for (const std::string& name : names) files.push_back(root_.path() / name);
    return texts(checkFiles(files, root_.path()).faults);
  }

  static std::vector<std::string> texts(const std::vector<FileFault>& faults) {
    std::vector<std::string> shown;
    for (const FileFault& fault : faults) shown.push_back(fault.text());
    return shown;
  }

  TinyRoot root_;
};

TEST_F(CheckFiles, FindsCellsThatAreNotThere) {
  root_.write("some.yaml", "version: 1\ncells:\n  - test\n  - tset\n  - nowhere/x.yaml\n");
  root_.write("none.yaml", "version: 1\ncells: []\n");
  root_.write("silent.yaml", "version: 1\nthreads: 2\n");
  const auto faults = check({"some.yaml", "none.yaml", "silent.yaml"});
  ASSERT_EQ(faults.size(), 4u);
  EXPECT_THAT(faults[0], AllOf(HasSubstr("some.yaml:4: cells: no cell 'tset'"),
                               HasSubstr("the nearest known one is 'test'")));
  EXPECT_THAT(faults[1], HasSubstr("some.yaml:5: cells: no cell 'nowhere/x.yaml'"));
  EXPECT_THAT(faults[2], HasSubstr("none.yaml:2: cells: names no cell"));
  EXPECT_THAT(faults[3], HasSubstr("silent.yaml: cells: names no cell"));
}

TEST_F(CheckFiles, SaysThatATransportIsNotBuiltYet) {
  root_.write("lan.yaml", "version: 1\ncells: [test]\ntransport: lan\n");
  EXPECT_THAT(check({"lan.yaml"}),
              ElementsAre(HasSubstr("lan.yaml:3: transport: lan is not built yet")));
}

TEST_F(CheckFiles, FindsNothingWrongWithGoodOnes) {
  root_.write("handoverd.yaml", "version: 1\ncells: [test]\n");
  root_.write("t.obj",
              "o t\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
  EXPECT_THAT(check({"config/cells/test.yaml", "robots/tiny/tiny.yaml", "robots/tiny/tiny.urdf",
                     "robots/tiny/tiny.srdf", "handoverd.yaml", "t.obj"}),
              ElementsAre());
}

/// Two boxes joined by a thin bar: not convex. Metres times `scale`; without its first face.
std::string dumbbell(double scale, bool open) {
  std::string text = "o d\n";
  const double z[] = {0, 0.04, 0.04, 0.08, 0.08, 0.12},
               half[] = {0.02, 0.02, 0.01, 0.01, 0.02, 0.02};
  char line[96];
  for (int ring = 0; ring < 6; ++ring) {
    const double h = scale * half[ring];
    for (const auto& [x, y] :
         {std::pair(-h, -h), std::pair(h, -h), std::pair(h, h), std::pair(-h, h)}) {
      std::snprintf(line, sizeof line, "v %.9g %.9g %.9g\n", x, y, scale * z[ring]);
      text += line;
    }
  }
  if (!open) text += "f 4 3 2 1\n";
  for (int ring = 0; ring < 5; ++ring) {
    for (int i = 1; i <= 4; ++i) {
      const int a = 4 * ring + i, b = 4 * ring + i % 4 + 1;
      std::snprintf(line, sizeof line, "f %d %d %d %d\n", a, b, b + 4, a + 4);
      text += line;
    }
  }
  return text + "f 21 22 23 24\n";
}

constexpr const char* kMeshCup = "{type: mesh, path: cup.obj}";

TEST_F(CheckFiles, SaysWhatObjectsAreMadeOf) {
  root_.write("cup.obj", dumbbell(1, false));
  root_.write("config/cells/test.yaml",
              with(with(handover::testing::kTinyCell, "{type: sphere, radius: 0.03}", kMeshCup),
                   "  objects.cup.geometry.radius: {choices: [0.03, 0.04]}\n", ""));
  const CheckReport report = checkFiles({root_.path() / "config/cells/test.yaml"}, root_.path());
  EXPECT_THAT(texts(report.faults), ElementsAre());
  EXPECT_THAT(texts(report.warnings), ElementsAre());
  EXPECT_THAT(
      texts(report.facts),
      ::testing::Contains(::testing::MatchesRegex(
          ".*test.yaml:22: objects.cup: 40 x 40 x 120 mm, 3 convex parts; 3 parts of .* cm3 "
          "for a body of 144 cm3")));
  EXPECT_THAT(texts(report.facts),
              ::testing::Contains(HasSubstr("objects.table: 1000 x 1000 x 500 mm, 1 convex part")));
}

TEST_F(CheckFiles, WarnsOfOpenSurfacesAndOtherUnits) {
  const std::string cell =
      with(with(handover::testing::kTinyCell, "{type: sphere, radius: 0.03}", kMeshCup),
           "  objects.cup.geometry.radius: {choices: [0.03, 0.04]}\n", "");
  root_.write("config/cells/test.yaml", cell);
  const auto warnings = [&] {
    return texts(checkFiles({root_.path() / "config/cells/test.yaml"}, root_.path()).warnings);
  };
  root_.write("cup.obj", dumbbell(1, true));
  EXPECT_THAT(warnings(),
              ElementsAre(HasSubstr("test.yaml:22: objects.cup: its surface is open in 1 "
                                    "body (4 edges have not two faces)")));
  root_.write(
      "cup.obj",
      "o t\nv 0 0 0\nv 100 0 0\nv 0 100 0\nv 0 0 100\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
  EXPECT_THAT(warnings(),
              ElementsAre(HasSubstr("objects.cup: is 100 x 100 x 100 m: lengths are in "
                                    "metres; written in millimetres, it needs a scale")));
  root_.write("config/cells/test.yaml",
              with(cell, "path: cup.obj", "path: cup.obj, scale: [1.0e-6, 1.0e-6, 1.0e-6]"));
  EXPECT_THAT(warnings(), ElementsAre(HasSubstr("objects.cup: is 0.1 x 0.1 x 0.1 mm")));
}

TEST_F(CheckFiles, WarnsOfLimitsInDegrees) {
  root_.write("robots/tiny/tiny.urdf", with(handover::testing::kTinyUrdf, R"(lower="-2" upper="2")",
                                            R"(lower="-170" upper="170")"));
  EXPECT_THAT(texts(checkFiles({root_.path() / "robots/tiny/tiny.yaml"}, root_.path()).warnings),
              ElementsAre(HasSubstr("tiny.yaml: joint 'swing' may turn from -170 to 170 rad")));
}

TEST_F(CheckFiles, KnowsAFileByItsContent) {
  root_.write("a", with(handover::testing::kTinyCell, "posture: home", "postur: home"));
  root_.write("b", "version: 1\ndomain: 999\n");
  root_.write("c", with(handover::testing::kTinyUrdf, "0 0 1", "0 0 0"));
  root_.write("d", "colour: red\n");
  root_.write("e.srdf", handover::testing::kTinySrdf);
  root_.write("robots/tiny/f.yaml", with(handover::testing::kTinyYaml, "hand: hand", "hand: foot"));
  root_.write("g.stl", "hello");
  root_.write("h", "hello");
  EXPECT_THAT(check({"a", "b", "c", "d", "e.srdf", "robots/tiny/f.yaml", "g.stl", "h", "none"}),
              ElementsAre(HasSubstr("/a:7: robots.left.postur: unknown key"),
                          HasSubstr("/b:2: domain: must be a whole number from 0 to 232"),
                          HasSubstr("/c:4: <joint> 'swing': axis is zero"),
                          HasSubstr("/d: is no cell, robot or daemon settings"),
                          HasSubstr("e.urdf does not exist"),
                          HasSubstr("f.yaml:6: arms.arm.hand: hand 'foot' is not defined"),
                          HasSubstr("g.stl: is no STL"),
                          HasSubstr("/h: is no cell, robot or daemon settings"),
                          HasSubstr("/none: no such file")));
}

}  // namespace
}  // namespace handover
