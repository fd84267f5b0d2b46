// SPDX-License-Identifier: Apache-2.0
#include "settings/yaml_node.hpp"

#include "core/model_io/file_fault.hpp"

#include <gmock/gmock.h>

namespace handover {
namespace {

std::string refusalOf(const std::string& text) {
  try {
    parseYaml(text, "a.yaml");
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
}

TEST(YamlNode, KeepsOrderAndLines) {
  const YamlNode node = parseYaml("b: 1\na:\n  - x\n  - {c: ~, d: '2'}\n", "a.yaml");
  ASSERT_TRUE(node.isMap());
  EXPECT_EQ(node.keys[0].text, "b");
  EXPECT_EQ(node.keys[1].line, 2);
  const YamlNode& list = *node.find("a");
  ASSERT_TRUE(list.isList());
  EXPECT_EQ(list.values[1].line, 4);
  EXPECT_EQ(list.values[1].find("c")->kind, YamlNode::Kind::kNull);
  EXPECT_EQ(list.values[1].find("d")->text, "2");
  EXPECT_EQ(list.find("a"), nullptr);
}

TEST(YamlNode, IsWrittenOnOneLineAsItWasRead) {
  for (const char* text :
       {"[\"1\", 1]", "[1, -0.5, {a: b, c: \"x: y\"}]", "~", "abc", "{}", "\"\""}) {
    EXPECT_EQ(parseYaml(text, "").flowText(), text);
  }
}

TEST(YamlNode, SetsAndRemovesKeys) {
  YamlNode node = parseYaml("{a: 1, b: 2}", "");
  node.set("a", parseYaml("3", ""));
  node.set("c", parseYaml("[4]", ""));
  node.remove("b");
  node.remove("x");
  EXPECT_EQ(node.flowText(), "{a: 3, c: [4]}");
}

TEST(YamlNode, IsOneCopyPerAlias) {
  YamlNode node = parseYaml("{a: &one {x: 1}, b: *one}", "");
  node.find("b")->set("x", parseYaml("2", ""));
  EXPECT_EQ(node.flowText(), "{a: {x: 1}, b: {x: 2}}");
}

TEST(YamlNode, RefusesAliasesThatNeverEndOrUnfoldTooFar) {
  EXPECT_THAT(refusalOf("a: &a [*a]"),
              ::testing::HasSubstr("a.yaml:1: holds an alias of what it lies in"));
  std::string bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 10; ++i) {
    const std::string name = "a" + std::to_string(i), below = "*a" + std::to_string(i - 1) + " ";
    bomb += name + ": &" + name + " [";
    for (int k = 0; k < 9; ++k) bomb += below + ", ";
    bomb += below + "]\n";
  }
  EXPECT_THAT(refusalOf(bomb), ::testing::HasSubstr("a.yaml:5: holds more than 50000 values"));
  EXPECT_THAT(refusalOf("a: [\n"), ::testing::StartsWith("a.yaml:2: is not well-formed YAML: "));
}

TEST(YamlNode, RefusesWhatWouldBeDroppedInSilence) {
  EXPECT_EQ(refusalOf("a: 1\n---\nb: 2\n"), "a.yaml:2: has a second document");
  EXPECT_EQ(refusalOf("a: 1\nb: !foo 2\n"), "a.yaml:2: has the tag '!foo': none is known here");
  EXPECT_EQ(refusalOf("a: !foo [1]\n"), "a.yaml:1: has the tag '!foo': none is known here");
  EXPECT_EQ(refusalOf("---\na: 1\n...\n"), "");
}

TEST(YamlNode, TellsQuotedFromPlain) {
  const YamlNode node = parseYaml("[1, \"1\", '1']", "");
  EXPECT_FALSE(node.values[0].quoted);
  EXPECT_TRUE(node.values[1].quoted);
  EXPECT_TRUE(node.values[2].quoted);
}

TEST(YamlNode, RefusesDepthAndSizeSoon) {
  EXPECT_EQ(refusalOf(std::string(200'000, '[')), "a.yaml:1: is nested deeper than 64 levels");
  std::string maps, blocks;
  for (int i = 0; i < 100'000; ++i) maps += "{a: ";
  for (int i = 0; i < 100'000; ++i) blocks += "- ";
  EXPECT_EQ(refusalOf(maps), "a.yaml:1: is nested deeper than 64 levels");
  EXPECT_EQ(refusalOf(blocks + "a"), "a.yaml:1: is nested deeper than 64 levels");
  std::string flat = "[";
  for (int i = 0; i < 1'000'000; ++i) flat += "1,";
  EXPECT_EQ(refusalOf(flat + "]"), "a.yaml:1: holds more than 50000 values");
}

TEST(YamlNode, IsUtf8Text) {
  EXPECT_EQ(refusalOf("a: 1\nb: \xFF\n"), "a.yaml:2: is not UTF-8 text");
  EXPECT_EQ(refusalOf(std::string("a: \0", 4)), "a.yaml:1: is not UTF-8 text");
  EXPECT_EQ(refusalOf("\xEF\xBB\xBF"
                      "a: gr\xC3\xBC\xC3\x9F"
                      "e\n"),
            "");
}

}  // namespace
}  // namespace handover
