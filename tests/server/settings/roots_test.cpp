// SPDX-License-Identifier: Apache-2.0
#include "settings/roots.hpp"

#include "core/model_io/file_fault.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

namespace handover {
namespace {

class Roots : public ::testing::Test {
 protected:
  Roots() { ::unsetenv("HANDOVER_ROOT"); }

  ~Roots() override { ::unsetenv("HANDOVER_ROOT"); }

  test::TemporaryFolder folder_;
};

TEST_F(Roots, TheOptionComesBeforeTheEnvironment) {
  folder_.write("a/x", "");
  folder_.write("b/x", "");
  ::setenv("HANDOVER_ROOT", (folder_.path() / "b").c_str(), 1);
  EXPECT_EQ(findRoot((folder_.path() / "a").string()), folder_.path() / "a");
  EXPECT_EQ(findRoot(), folder_.path() / "b");
}

TEST_F(Roots, AGivenFolderMustExist) {
  EXPECT_THROW(findRoot((folder_.path() / "none").string()), FileError);
  ::setenv("HANDOVER_ROOT", (folder_.path() / "none").c_str(), 1);
  EXPECT_THROW(findRoot(), FileError);
}

TEST_F(Roots, OfADevelopmentBuildIsTheRepository) {
  EXPECT_TRUE(std::filesystem::equivalent(findRoot(), HANDOVER_SOURCE_DIR));
}

TEST_F(Roots, CellsAreNamesOrFiles) {
  EXPECT_EQ(cellFile("butler", "/r"), "/r/config/cells/butler.yaml");
  EXPECT_EQ(cellFile("butler.yaml", "/r"), "butler.yaml");
  EXPECT_EQ(cellFile("./butler", "/r"), "./butler");
  EXPECT_EQ(robotFile("hubo", "/r"), "/r/robots/hubo/hubo.yaml");
}

TEST_F(Roots, CacheFollowsTheSettingsThenXdg) {
  EXPECT_EQ(cacheFolder("here"), "here");
  ::setenv("XDG_CACHE_HOME", "/xdg", 1);
  EXPECT_EQ(cacheFolder(""), "/xdg/handover");
  const std::string home = std::getenv("HOME") == nullptr ? "" : std::getenv("HOME");
  ::setenv("HOME", "/home/me", 1);
  ::setenv("XDG_CACHE_HOME", "relative", 1);  // to be ignored, says its specification
  EXPECT_EQ(cacheFolder(""), "/home/me/.cache/handover");
  ::unsetenv("XDG_CACHE_HOME");
  ::setenv("HOME", home.c_str(), 1);
}

}  // namespace
}  // namespace handover
