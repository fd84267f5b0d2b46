// SPDX-License-Identifier: Apache-2.0
// The installation as its users have it: moved elsewhere, out of the repository's sight, serving a
// foreign project that is the README's example as it stands.
#include "process.hpp"
#include "temporary_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <memory>
#include <set>

namespace handover::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

const char* const kForeignProject = R"(
cmake_minimum_required(VERSION 3.25)
project(foreign LANGUAGES CXX)
find_package(handover 9 QUIET)
if(handover_FOUND)
  message(FATAL_ERROR "found although its version does not fit")
endif()
find_package(handover 0.1 REQUIRED)
add_executable(foreign main.cpp headers.cpp)
target_link_libraries(foreign PRIVATE handover::client)
)";

/// The first ```cpp block of the README.
std::string readmeExample() {
  const std::string readme = textOf(HANDOVER_SOURCE_DIR "/README.md");
  const std::string fence = "```cpp\n";
  const auto begin = readme.find(fence);
  if (begin == std::string::npos) throw std::runtime_error("no example in README.md");
  const auto first = begin + fence.size();
  return readme.substr(first, readme.find("```", first) - first);
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const auto at = text.find(what);
  if (at == std::string::npos) throw std::runtime_error("no '" + what + "'");
  return text.replace(at, what.size(), by);
}

/// Installed once for all tests below, then moved; nothing here knows its first place.
class Install : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    const fs::path first = *folder_ / "first";
    const Finished installed =
        run({HANDOVER_CMAKE, "--install", HANDOVER_BINARY_DIR, "--prefix", first.string()});
    ASSERT_EQ(installed.status, 0) << installed.err;
    fs::create_directories(*folder_ / "moved");
    fs::rename(first, prefix());
    fs::create_directories(*folder_ / "elsewhere");
  }

  static void TearDownTestSuite() { delete folder_; }

  static fs::path prefix() { return *folder_ / "moved/prefix"; }

  static std::string program(const std::string& name) { return prefix() / "bin" / name; }

  /// The command in a working folder away from everything.
  static std::vector<std::string> elsewhere(const std::string& command) {
    std::vector<std::string> all{"/usr/bin/env", "--chdir", *folder_ / "elsewhere"};
    for (auto& word : words(command)) all.push_back(std::move(word));
    return all;
  }

  static std::set<std::string> headers() {
    std::set<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(prefix() / "include")) {
      if (entry.is_regular_file()) {
        names.insert(fs::relative(entry.path(), prefix() / "include").string());
      }
    }
    return names;
  }

  static TemporaryFolder* folder_;
};

TemporaryFolder* Install::folder_ = nullptr;

TEST_F(Install, HoldsWhatUsersNeedAndNothingElse) {
  EXPECT_EQ(headers(), (std::set<std::string>{
                           "handover/client/answer.hpp", "handover/client/client.hpp",
                           "handover/client/plan_file.hpp", "handover/client/plan_motion.hpp",
                           "handover/common/enum_names.hpp", "handover/common/geometry.hpp",
                           "handover/common/plan_event.hpp", "handover/common/plan_request.hpp",
                           "handover/common/pose.hpp", "handover/common/request_id.hpp",
                           "handover/common/scene_snapshot.hpp", "handover/common/status.hpp"}));
  for (const auto& name : headers()) {
    const std::string text = textOf(prefix() / "include" / name);
    EXPECT_THAT(text, Not(testing::ContainsRegex("fastdds|fastrtps|<handover.h>|wire/"))) << name;
  }
  for (const char* file :
       {"bin/handoverd", "bin/handoverctl", "bin/handover-verify",
        "share/handover/config/handoverd.yaml", "share/handover/config/cells/butler.yaml",
        "share/handover/robots/hubo/hubo.urdf", "share/handover/robots/objects/cup/cup.obj",
        "share/handover/idl/handover.idl", "lib/systemd/system/handoverd.service"}) {
    EXPECT_TRUE(fs::is_regular_file(prefix() / file)) << file;
  }
  EXPECT_FALSE(fs::exists(prefix() / "share/handover/robots/tools"));
  EXPECT_FALSE(fs::exists(prefix() / "share/handover/config/handoverd.service"));
}

TEST_F(Install, NamesNoFolderOfTheBuild) {
  for (const auto& entry : fs::recursive_directory_iterator(prefix())) {
    const std::string name = entry.path().extension().string();
    if (name != ".cmake" && name != ".service" && name != ".hpp" && name != ".yaml") continue;
    const std::string text = textOf(entry.path());
    EXPECT_THAT(text, Not(HasSubstr(HANDOVER_SOURCE_DIR))) << entry.path();
    EXPECT_THAT(text, Not(HasSubstr((*folder_ / "first").string()))) << entry.path();
  }
}

TEST_F(Install, ForeignProjectPlansWithTheInstalledDaemon) {
  std::string includes;
  for (const auto& name : headers()) includes += "#include <" + name + ">\n";
  folder_->write("foreign/CMakeLists.txt", kForeignProject);
  folder_->write("foreign/main.cpp", readmeExample());
  folder_->write("foreign/headers.cpp", includes);
  const std::string source = *folder_ / "foreign", build = *folder_ / "foreign/build";
  const Finished configured =
      run({HANDOVER_CMAKE, "-S", source, "-B", build, "-DCMAKE_PREFIX_PATH=" + prefix().string()});
  ASSERT_EQ(configured.status, 0) << configured.out << configured.err;
  const Finished built = run({HANDOVER_CMAKE, "--build", build, "-j2"}, {}, 240s);
  ASSERT_EQ(built.status, 0) << built.out << built.err;

  // A task name that only the installed cell file has: what answers to it has read that file.
  const fs::path cell = prefix() / "share/handover/config/cells/butler.yaml";
  folder_->write(fs::relative(cell, folder_->path()).string(),
                 replaced(textOf(cell), "\n  serve:\n", "\n  serve_installed:\n"));
  const std::string domain = std::to_string(freeDomain());
  const std::vector<std::string> environment{"XDG_CACHE_HOME=" HANDOVER_BINARY_DIR "/test-cache",
                                             "HANDOVER_DOMAIN=" + domain};
  Process daemon(elsewhere(program("handoverd") + " serve --cell butler"), environment);
  const Finished status =
      run(elsewhere(program("handoverctl") + " status --wait 20 --json"), environment);
  ASSERT_EQ(status.status, 0) << status.err << daemon.err();
  EXPECT_THAT(status.out, HasSubstr("serve_installed"));

  const Finished planned = run(elsewhere(build + "/foreign"), environment, 240s);
  EXPECT_EQ(planned.status, 0) << planned.out << planned.err;

  const Finished plan =
      run(elsewhere(program("handoverctl") + " plan --cell butler --output plan.json"), environment,
          240s);
  ASSERT_EQ(plan.status, 0) << plan.out << plan.err;
  const Finished verified = run(elsewhere(program("handover-verify") + " plan.json"), {}, 120s);
  EXPECT_EQ(verified.status, 0) << verified.out << verified.err;

  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(), 0);
}

}  // namespace
}  // namespace handover::test
