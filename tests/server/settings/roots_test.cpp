// SPDX-License-Identifier: Apache-2.0
#include "settings/roots.hpp"

#include "core/model_io/file_fault.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <optional>

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

/// Sets HOME and XDG_CACHE_HOME (nullptr: unset) and puts them back.
class Homes {
 public:
  Homes(const char* home, const char* xdg) : home_("HOME", home), xdg_("XDG_CACHE_HOME", xdg) {}

 private:
  class Variable {
   public:
    Variable(const char* name, const char* value) : name_(name) {
      if (const char* old = std::getenv(name)) old_ = old;
      set(value);
    }

    ~Variable() { set(old_ ? old_->c_str() : nullptr); }

    Variable(const Variable&) = delete;
    Variable& operator=(const Variable&) = delete;

   private:
    void set(const char* value) {
      if (value == nullptr) {
        ::unsetenv(name_);
      } else {
        ::setenv(name_, value, 1);
      }
    }

    const char* name_;
    std::optional<std::string> old_;
  };

  Variable home_, xdg_;
};

TEST_F(Roots, CacheFollowsTheSettingsThenXdgThenTheHome) {
  const Homes none(nullptr, nullptr);
  EXPECT_EQ(cacheFolder("here"), "here");
  {
    const Homes homes("/home/me", "/xdg");
    EXPECT_EQ(cacheFolder("here"), "here");
    EXPECT_EQ(cacheFolder(""), "/xdg/handover");
  }
  {
    const Homes homes("/home/me", "relative");  // to be ignored, says its specification
    EXPECT_EQ(cacheFolder(""), "/home/me/.cache/handover");
  }
  const Homes homes("/home/me", nullptr);
  EXPECT_EQ(cacheFolder(""), "/home/me/.cache/handover");
}

TEST_F(Roots, WithoutAHomeThereIsNoCacheAndTheErrorSaysWhatToSet) {
  for (const char* home : {static_cast<const char*>(nullptr), "", "relative"}) {
    const Homes homes(home, nullptr);
    try {
      const auto folder = cacheFolder("");
      FAIL() << folder;
    } catch (const std::runtime_error& error) {
      for (const char* name : {"XDG_CACHE_HOME", "HOME", "cache:"}) {
        EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
      }
    }
  }
}

}  // namespace
}  // namespace handover
