// SPDX-License-Identifier: Apache-2.0
#include "settings/check.hpp"

#include "tiny_root.hpp"

#include <gmock/gmock.h>

namespace handover {
namespace {

using handover::testing::TinyRoot;
using handover::testing::with;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class CheckFiles : public ::testing::Test {
 protected:
  std::vector<std::string> check(const std::vector<std::string>& names) const {
    std::vector<std::filesystem::path> files;
    for (const std::string& name : names) files.push_back(root_.path() / name);
    std::vector<std::string> shown;
    for (const FileFault& fault : checkFiles(files, root_.path())) shown.push_back(fault.text());
    return shown;
  }

  TinyRoot root_;
};

TEST_F(CheckFiles, FindsNothingWrongWithGoodOnes) {
  root_.write("handoverd.yaml", "version: 1\ncells: [test]\n");
  root_.write("t.obj",
              "o t\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
  EXPECT_THAT(check({"config/cells/test.yaml", "robots/tiny/tiny.yaml", "robots/tiny/tiny.urdf",
                     "robots/tiny/tiny.srdf", "handoverd.yaml", "t.obj"}),
              ElementsAre());
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
