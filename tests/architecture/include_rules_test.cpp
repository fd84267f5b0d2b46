// SPDX-License-Identifier: Apache-2.0
#include "include_rules.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace handover::test {
namespace {

std::string listed(const std::vector<Violation>& found) {
  std::string text;
  for (const Violation& it : found) text += it.file + ": " + it.text + "\n";
  return text;
}

TEST(IncludeRules, AreKeptByTheSourceTree) {
  const SourceTree tree = readSourceTree(HANDOVER_SOURCE_DIR);
  ASSERT_GT(tree.size(), 100u);
  EXPECT_EQ(listed(violations(tree)), "");
}

TEST(IncludeRules, ResolveTheIncludesOfTheSourceTree) {
  const SourceTree tree = readSourceTree(HANDOVER_SOURCE_DIR);
  std::size_t ours = 0;
  for (const auto& [file, text] : tree) {
    for (const Include& include : includesOf(tree, file)) ours += !include.target.empty();
  }
  EXPECT_GT(ours, 300u);  // else the rules look at nothing
}

// A tree with one file of every layer, and one more file with the include under test.
struct Misplaced {
  std::string name;
  std::string file, include;
  Rule rule;
};

SourceTree oneFilePerLayer() {
  SourceTree tree;
  for (const Layer& layer : layers()) tree[layer.folder + "/thing.hpp"] = "#pragma once\n";
  tree.erase("common/thing.hpp");
  tree["common/include/handover/common/thing.hpp"] = "#pragma once\n";
  tree["common/include/handover/common/log.hpp"] = "#include <spdlog/spdlog.h>\n";
  tree.erase("client/include/thing.hpp");
  tree["client/include/handover/client/thing.hpp"] = "#pragma once\n";
  return tree;
}

class MisplacedInclude : public testing::TestWithParam<Misplaced> {};

TEST_P(MisplacedInclude, IsRefused) {
  SourceTree tree = oneFilePerLayer();
  ASSERT_EQ(listed(violations(tree)), "");
  tree[GetParam().file] = "// A comment.\n#include " + GetParam().include + "\n";
  const std::vector<Violation> found = violations(tree);
  ASSERT_FALSE(found.empty());
  EXPECT_THAT(found, testing::Each(testing::Field(&Violation::file, GetParam().file)));
  EXPECT_THAT(found, testing::Contains(testing::Field(&Violation::rule, GetParam().rule)))
      << listed(found);
}

const std::vector<Misplaced>& misplaced() {
  static const std::vector<Misplaced> all{
      {"LaterCoreModule", "server/core/kinematics/a.cpp", "\"core/planning/thing.hpp\"",
       Rule::kLayer},
      {"NextCoreModule", "server/core/collision/a.hpp", "\"core/reachability/thing.hpp\"",
       Rule::kLayer},
      {"LaterCoreModuleByDots", "server/core/grasp/a.cpp", "\"../motion/thing.hpp\"", Rule::kLayer},
      {"LaterCoreModuleFromTheRoot", "server/core/model/a.cpp",
       "\"server/core/collision/thing.hpp\"", Rule::kLayer},
      {"LaterCoreModuleInAngles", "server/core/model/a.cpp", "<core/collision/thing.hpp>",
       Rule::kLayer},
      {"ReaderInModel", "server/core/model/a.cpp", "\"core/model_io/thing.hpp\"", Rule::kLayer},
      {"SettingsInCore", "server/core/grasp/a.cpp", "\"settings/thing.hpp\"", Rule::kLayer},
      {"RuntimeInCore", "server/core/planning/a.cpp", "\"runtime/thing.hpp\"", Rule::kLayer},
      {"WireInCore", "server/core/motion/a.cpp", "\"wire/thing.hpp\"", Rule::kLayer},
      {"ClientInCore", "server/core/motion/a.cpp", "<handover/client/thing.hpp>", Rule::kLayer},
      {"CoreInVerifier", "client/verify/rules.cpp", "\"../../server/core/planning/thing.hpp\"",
       Rule::kLayer},
      {"CommonInVerifier", "client/verify/rules.cpp", "<handover/common/thing.hpp>", Rule::kLayer},
      {"ClientInVerifier", "client/verify/rules.cpp", "<handover/client/thing.hpp>", Rule::kLayer},
      {"PagesInVerifier", "client/verify/rules.cpp", "\"view/thing.hpp\"", Rule::kLayer},
      {"VerifierInDaemon", "server/runtime/a.cpp", "\"../../client/verify/thing.hpp\"",
       Rule::kLayer},
      {"VerifierInClientLibrary", "client/src/a.cpp", "\"verify/thing.hpp\"", Rule::kLayer},
      {"ServerInClient", "client/ctl/a.cpp", "\"../../server/settings/thing.hpp\"", Rule::kLayer},
      {"ServerInCommon", "common/src/a.cpp", "\"../../server/core/model/thing.hpp\"", Rule::kLayer},
      {"WireInCommon", "common/src/a.cpp", "\"wire/thing.hpp\"", Rule::kLayer},
      {"NewCoreModule", "server/core/cooking/a.cpp", "<vector>", Rule::kNoLayer},
      {"NewServerFolder", "server/kitchen/a.cpp", "<vector>", Rule::kNoLayer},
      {"NewClientFolder", "client/kitchen/a.cpp", "<vector>", Rule::kNoLayer},
      {"FileThatIsNot", "server/core/model/a.cpp", "\"core/model/gone.hpp\"", Rule::kNotFound},
      {"Bullet", "server/core/motion/a.cpp", "<BulletCollision/btBulletCollisionCommon.h>",
       Rule::kLibrary},
      {"BulletMath", "server/core/grasp/a.cpp", "<LinearMath/btVector3.h>", Rule::kLibrary},
      {"BulletInHeader", "server/core/collision/a.hpp", "<btBulletCollisionCommon.h>",
       Rule::kHeader},
      {"Qhull", "server/core/model/a.cpp", "<libqhull_r/libqhull_r.h>", Rule::kLibrary},
      {"QhullInHeader", "server/core/decomposition/a.hpp", "<libqhull_r/qhull_ra.h>",
       Rule::kHeader},
      {"OMPL", "server/core/planning/a.cpp", "<ompl/base/Goal.h>", Rule::kLibrary},
      {"OMPLInHeader", "server/core/motion/a.hpp", "<ompl/base/Goal.h>", Rule::kHeader},
      {"urdfdom", "server/settings/a.cpp", "<urdf_parser/urdf_parser.h>", Rule::kLibrary},
      {"urdfdomConsole", "client/view/a.cpp", "<console_bridge/console.h>", Rule::kLibrary},
      {"tinyxml2", "server/core/model/a.cpp", "<tinyxml2.h>", Rule::kLibrary},
      {"assimp", "server/core/model/a.cpp", "<assimp/scene.h>", Rule::kLibrary},
      {"YAML", "server/cells/a.cpp", "<yaml-cpp/yaml.h>", Rule::kLibrary},
      {"FCL", "server/core/collision/a.cpp", "<fcl/narrowphase/collision.h>", Rule::kLibrary},
      {"KDL", "server/core/kinematics/a.cpp", "<kdl/tree.hpp>", Rule::kLibrary},
      {"DDS", "server/runtime/a.cpp", "<fastdds/dds/topic/Topic.hpp>", Rule::kLibrary},
      {"WireTypes", "client/ctl/a.cpp", "<handoverPubSubTypes.h>", Rule::kLibrary},
      {"spdlog", "server/settings/a.cpp", "<spdlog/spdlog.h>", Rule::kLibrary},
      {"CLI11", "server/settings/a.cpp", "<CLI/CLI.hpp>", Rule::kLibrary},
      {"YAMLInCore", "server/core/model/a.cpp", "<yaml-cpp/yaml.h>", Rule::kHiddenInCore},
      {"DDSInCore", "server/core/model/a.cpp", "<fastrtps/utils/fixed_size_string.hpp>",
       Rule::kHiddenInCore},
      {"WireTypesInCore", "server/core/model/a.cpp", "\"handover.h\"", Rule::kHiddenInCore},
      {"spdlogInCore", "server/core/model/a.cpp", "<spdlog/spdlog.h>", Rule::kHiddenInCore},
      {"spdlogInCoreThroughCommon", "server/core/model/a.cpp", "<handover/common/log.hpp>",
       Rule::kHiddenInCore},
      {"PrintingInCore", "server/core/model/a.cpp", "<iostream>", Rule::kHiddenInCore},
      {"ThreadsInCore", "server/core/motion/a.cpp", "<thread>", Rule::kHiddenInCore},
  };
  return all;
}

INSTANTIATE_TEST_SUITE_P(All, MisplacedInclude, testing::ValuesIn(misplaced()),
                         [](const auto& it) { return it.param.name; });

TEST(IncludeRules, HaveAnExampleEach) {
  std::vector<std::string> missing;
  for (const Library& library : libraries()) {
    const auto named = [&](const Misplaced& it) { return it.name == library.name; };
    if (std::none_of(misplaced().begin(), misplaced().end(), named))
      missing.push_back(library.name);
  }
  EXPECT_THAT(missing, testing::IsEmpty());
  for (const Rule rule : {Rule::kNoLayer, Rule::kNotFound, Rule::kLayer, Rule::kLibrary,
                          Rule::kHeader, Rule::kHiddenInCore}) {
    EXPECT_THAT(misplaced(), testing::Contains(testing::Field(&Misplaced::rule, rule)));
  }
}

TEST(IncludeRules, LetEachCoreModuleIncludeThoseBeforeItOnly) {
  std::vector<std::string> modules;
  for (const Layer& layer : layers()) {
    if (layer.folder.starts_with("server/core/")) modules.push_back(layer.folder.substr(7));
  }
  ASSERT_GE(modules.size(), 10u);
  for (std::size_t from = 0; from < modules.size(); ++from) {
    for (std::size_t to = 0; to < modules.size(); ++to) {
      SourceTree tree = oneFilePerLayer();
      tree["server/" + modules[from] + "/a.cpp"] = "#include \"" + modules[to] + "/thing.hpp\"\n";
      EXPECT_EQ(violations(tree).empty(), to <= from) << modules[from] << " " << modules[to];
    }
  }
}

}  // namespace
}  // namespace handover::test
