// SPDX-License-Identifier: Apache-2.0
// handoverctl as it is built without node and npm.
#include "client/verify/gantry_plan.hpp"
#include "support/process.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace handover::verify::test {
namespace {

using handover::test::Finished;
using testing::HasSubstr;
using testing::IsEmpty;

class NoPages : public testing::Test {
 protected:
  NoPages() { cell_.write("plan.json", cell_.plan().dump()); }

  std::string path(const std::string& name) const { return (cell_.root() / name).string(); }

  Finished ctl(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), HANDOVERCTL_WITHOUT_PAGES);
    return handover::test::run(std::move(arguments));
  }

  Finished view(const std::string& output) const {
    return ctl({"view", path("plan.json"), "-o", path(output), "--root", cell_.root().string()});
  }

  void expectNoPages(const Finished& it, const std::string& output) const {
    EXPECT_EQ(it.status, 3);
    EXPECT_THAT(it.err, HasSubstr("the pages are not in this build"));
    EXPECT_FALSE(std::filesystem::exists(path(output)));
  }

  const GantryCell cell_;
};

TEST_F(NoPages, EveryPageIsRefusedBeforeADaemonIsSought) {
  expectNoPages(ctl({"plan", "--cell", "butler", "--html", path("plan.html")}), "plan.html");
  expectNoPages(ctl({"experiment", "butler", "--html", path("e.html")}), "e.html");
  expectNoPages(view("view.html"), "view.html");
}

TEST_F(NoPages, JsonSaysSoToo) {
  const Finished it = ctl({"plan", "--cell", "butler", "--html", path("plan.html"), "--json"});
  EXPECT_EQ(it.status, 3);
  const Json line = Json::parse(it.out);
  EXPECT_EQ(line["exit_code"], 3);
  EXPECT_THAT(line.dump(), HasSubstr("the pages are not in this build"));
}

TEST_F(NoPages, RecordingsAreMadeAsEver) {
  const Finished it = view("plan.mcap");
  EXPECT_EQ(it.status, 0);
  EXPECT_THAT(it.err, IsEmpty());
  EXPECT_GT(std::filesystem::file_size(path("plan.mcap")), 0u);
}

}  // namespace
}  // namespace handover::verify::test
