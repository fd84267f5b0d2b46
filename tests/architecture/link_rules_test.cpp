// SPDX-License-Identifier: Apache-2.0
#include "link_rules.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

namespace handover::test {
namespace {

using testing::ElementsAre;

std::string textOf(const std::filesystem::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(LinkRules, TheCoresModulesLinkWhatTheyInclude) {
  const std::filesystem::path root(HANDOVER_SOURCE_DIR);
  std::map<std::string, std::string> texts;
  for (const auto& entry : std::filesystem::directory_iterator(root / "server/core")) {
    if (!entry.is_directory()) continue;
    texts[entry.path().filename().string()] = textOf(entry.path() / "CMakeLists.txt");
  }
  ASSERT_GT(texts.size(), 5u);
  EXPECT_THAT(missingLinks(readSourceTree(root), texts), testing::IsEmpty());
}

TEST(LinkRules, TheVerifierLinksNothingOfOurs) {
  const std::filesystem::path root(HANDOVER_SOURCE_DIR);
  const auto libraries = linkedLibraries(textOf(root / "client/verify/CMakeLists.txt"));
  ASSERT_EQ(libraries.size(), 1u);
  const LinkedLibrary& verify = libraries.front();
  ASSERT_EQ(verify.name, "verify");
  EXPECT_THAT(verify.private_links, testing::Contains("fcl"));
  for (const auto& links : {verify.public_links, verify.private_links}) {
    EXPECT_THAT(links, testing::Each(testing::Not(testing::StartsWith("handover"))));
  }
}

TEST(LinkRules, ReadALibraryAsCMakeDoes) {
  const auto found = linkedLibraries(
      "# handover\nhandover_library(grasp\n  SOURCES a.cpp b.cpp\n  PUBLIC handover::model\n"
      "  PRIVATE handover::collision xxhash)\n");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].name, "grasp");
  EXPECT_THAT(found[0].sources, ElementsAre("a.cpp", "b.cpp"));
  EXPECT_THAT(found[0].public_links, ElementsAre("handover::model"));
  EXPECT_THAT(found[0].private_links, ElementsAre("handover::collision", "xxhash"));
}

TEST(LinkRules, NameALinkThatIsMissingOrHidden) {
  const SourceTree tree{
      {"server/core/model/thing.hpp", ""},
      {"server/core/collision/thing.hpp", ""},
      {"server/core/grasp/a.hpp", "#include \"core/model/thing.hpp\"\n"},
      {"server/core/grasp/a.cpp", "#include \"core/collision/thing.hpp\"\n"},
  };
  const auto linked = [&](const std::string& links) {
    return missingLinks(tree, {{"grasp", "handover_library(grasp SOURCES a.cpp " + links + ")"}});
  };
  EXPECT_THAT(linked("PUBLIC handover::model PRIVATE handover::collision"), testing::IsEmpty());
  EXPECT_THAT(linked("PUBLIC handover::model"), ElementsAre("grasp: collision"));
  EXPECT_THAT(linked("PRIVATE handover::model handover::collision"),
              ElementsAre("grasp: model, for a header"));
}

}  // namespace
}  // namespace handover::test
