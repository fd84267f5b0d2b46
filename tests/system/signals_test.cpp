// SPDX-License-Identifier: Apache-2.0
// What signals, lost readers and full disks do to the programs.
#include "process.hpp"
#include "temporary_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <signal.h>

#include <filesystem>

namespace handover::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

const std::string kBin = HANDOVER_BINARY_DIR "/bin/";
const std::string kCache = "XDG_CACHE_HOME=" HANDOVER_BINARY_DIR "/test-cache";

class Signals : public testing::Test {
 protected:
  const int domain = freeDomain();
  const std::string at_domain = " --domain " + std::to_string(domain);

  std::vector<std::string> ctl(const std::string& arguments) const {
    return words(kBin + "handoverctl " + arguments + at_domain);
  }

  std::vector<std::string> serve(const std::string& cell) const {
    return words(kBin + "handoverd serve --root " HANDOVER_SOURCE_DIR " --cell " + cell +
                 at_domain);
  }

  /// What the cell's first line of `handoverctl cells --json` says.
  nlohmann::json cell() const {
    const std::string text = run(ctl("cells --json --wait 20")).out;
    return nlohmann::json::parse(text.substr(0, text.find('\n')));
  }

  /// Waits until the daemon tells it.
  bool waitForRevision(int revision) const {
    for (int asked = 0; asked < 100; ++asked) {
      if (cell()["scene_revision"] == revision) return true;
    }
    return false;
  }
};

class ScriptedSignals : public Signals {
 protected:
  Process daemon{{HANDOVER_BINARY_DIR "/tests/scripted_daemon", std::to_string(domain)}};

  void SetUp() override { ASSERT_EQ(run(ctl("status --wait 20")).status, 0) << daemon.err(); }

  void expectOrderlyStop() {
    daemon.signal(SIGTERM);
    EXPECT_EQ(daemon.wait(5s), 0) << daemon.err();
  }
};

TEST_F(ScriptedSignals, AHangupReadsTheCellsAgainUnderARunningRequest) {
  Process plan(ctl("plan --cell script --task hold --json"));
  ASSERT_TRUE(plan.waitForOutput("arm_selected"));
  ASSERT_TRUE(waitForRevision(7));
  daemon.signal(SIGHUP);
  EXPECT_TRUE(waitForRevision(8));
  EXPECT_THAT(plan.out(), Not(HasSubstr("outcome")));
  plan.signal(SIGINT);
  EXPECT_EQ(plan.wait(), 11);
  expectOrderlyStop();
}

TEST_F(ScriptedSignals, SignalsThatSayNothingChangeNothing) {
  for (const int number : {SIGPIPE, SIGUSR1, SIGUSR2, SIGALRM}) daemon.signal(number);
  EXPECT_EQ(run(ctl("plan --cell script --task answer")).status, 0);
  expectOrderlyStop();
}

TEST_F(ScriptedSignals, AReaderOfTheLogThatIsGoneHarmsNobody) {
  daemon.closeOutput();
  for (int i = 0; i < 3; ++i) EXPECT_EQ(run(ctl("plan --cell script --task answer")).status, 0);
  expectOrderlyStop();
}

TEST_F(ScriptedSignals, AStopIsBoundedWhateverHangs) {
  Process plan(ctl("plan --cell script --task stuck --wait 2"));
  ASSERT_TRUE(plan.waitForOutput("arms"));
  expectOrderlyStop();
  EXPECT_THAT(daemon.err(), HasSubstr("the stop hangs and is cut short"));
  EXPECT_EQ(plan.wait(), 13);
}

TEST_F(ScriptedSignals, WhoPlansIsCancelledBySignalsAndLeavesNoFile) {
  for (const int number : {SIGHUP, SIGTERM, SIGINT}) {
    const TemporaryFolder folder;
    Process plan(ctl("plan --cell script --task hold --output " + (folder / "p.json").string() +
                     " --dump-state start " + (folder / "p.obj").string()));
    ASSERT_TRUE(plan.waitForOutput("arms"));
    plan.signal(number);
    EXPECT_EQ(plan.wait(), 11) << number;
    EXPECT_TRUE(fs::is_empty(folder.path())) << fs::directory_iterator(folder.path())->path();
  }
  expectOrderlyStop();
}

TEST_F(ScriptedSignals, AKilledClientLeavesNoFile) {
  const TemporaryFolder folder;
  Process plan(ctl("plan --cell script --task hold --output " + (folder / "p.json").string()));
  ASSERT_TRUE(plan.waitForOutput("arms"));
  plan.signal(SIGKILL);
  plan.wait();
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST_F(ScriptedSignals, WhoWatchesEndsWhenNobodyReads) {
  Process watch(ctl("watch"));
  ASSERT_EQ(run(ctl("plan --cell script --task answer")).status, 0);
  ASSERT_TRUE(watch.waitForOutput("done"));
  watch.closeOutput();
  ASSERT_EQ(run(ctl("plan --cell script --task answer")).status, 0);
  EXPECT_EQ(watch.wait(), 3);
}

TEST_F(ScriptedSignals, FullStandardOutputIsSaidByEveryCommand) {
  const std::string script = kBin + "handoverctl ";
  for (const std::string& command :
       {script + "status" + at_domain, script + "cells" + at_domain,
        script + "status --json" + at_domain,
        script + "plan --cell script --task answer" + at_domain,
        script + "plan --cell script --task answer --json" + at_domain, script + "--version",
        script + "plan --help", kBin + "handoverd --version", kBin + "handoverd check --help",
        kBin + "handover-verify --version"}) {
    for (const char* full : {" > /dev/full", " >&-"}) {
      const Finished result = run({"/bin/sh", "-c", command + full});
      EXPECT_EQ(result.status, 3) << command << full;
      EXPECT_THAT(result.err, HasSubstr("cannot write to standard output")) << command << full;
    }
  }
}

TEST_F(Signals, AStopBeforeTheDaemonServesIsAnOrderlyOne) {
  for (const int number : {SIGTERM, SIGINT}) {
    Process daemon(serve("butler"), {kCache});
    ASSERT_TRUE(daemon.waitUntilBlocks(number));  // before any library is started
    daemon.signal(number);
    EXPECT_EQ(daemon.wait(5s), 0) << daemon.err();
  }
}

TEST_F(Signals, AHangupServesTheCellFileAsItIsNow) {
  const TemporaryFolder folder;
  const std::string text = textOf(HANDOVER_SOURCE_DIR "/config/cells/butler.yaml");
  const auto at = text.find("  serve:");
  ASSERT_NE(at, std::string::npos);
  std::string changed = text;
  changed.replace(at, 8, "  offer:");
  const fs::path file = folder.write("butler.yaml", text);
  Process daemon(serve(file.string()), {kCache});
  ASSERT_EQ(cell()["tasks"][0], "serve") << daemon.err();

  folder.write("butler.yaml", changed);
  daemon.signal(SIGHUP);
  ASSERT_TRUE(waitForRevision(2));
  EXPECT_EQ(cell()["tasks"][0], "offer");
  EXPECT_EQ(run(ctl("plan --cell butler --task offer --mode first"), {}, 240s).status, 0);

  folder.write("butler.yaml", changed + "\nnonsense: 1\n");
  daemon.signal(SIGHUP);
  ASSERT_TRUE(daemon.waitForOutput("the cells stay as they are"));
  EXPECT_EQ(run(ctl("plan --cell butler --task offer --mode first")).status, 0);
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(5s), 0);
  EXPECT_THAT(daemon.err(), HasSubstr("unknown key"));
}

}  // namespace
}  // namespace handover::test
