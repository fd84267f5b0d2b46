// SPDX-License-Identifier: Apache-2.0
// handoverctl and handoverd as people run them: exit codes, output, signals.
#include "plan_text.hpp"
#include "process.hpp"
#include "temporary_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <signal.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

namespace handover::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const std::string kBin = HANDOVER_BINARY_DIR "/bin/";
const std::string kCtl = kBin + "handoverctl";
const std::string kScripted = HANDOVER_BINARY_DIR "/tests/scripted_daemon";

std::vector<std::string> operator+(std::vector<std::string> left,
                                   const std::vector<std::string>& right) {
  left.insert(left.end(), right.begin(), right.end());
  return left;
}

/// All of the text is JSON, a value a line; returns them.
std::vector<nlohmann::json> jsonLines(const std::string& text) {
  std::vector<nlohmann::json> all;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) all.push_back(nlohmann::json::parse(line));
  return all;
}

class Ctl : public testing::Test {
 protected:
  const int domain = freeDomain();

  std::vector<std::string> command(const std::string& arguments) const {
    return std::vector{kCtl} + words(arguments) + words("--domain " + std::to_string(domain));
  }

  Finished ctl(const std::string& arguments) const { return run(command(arguments)); }
};

/// With the scripted daemon.
class ScriptedCtl : public Ctl {
 protected:
  Process daemon{{kScripted, std::to_string(domain)}};

  void SetUp() override { ASSERT_EQ(ctl("status --wait 20").status, 0) << daemon.err(); }
};

// ---- without a daemon ----

struct Usage {
  const char* arguments;
  int status;
};

class CtlUsage : public testing::TestWithParam<Usage> {};

TEST_P(CtlUsage, HasItsExitCode) {
  const auto result = run(std::vector{kCtl} + words(GetParam().arguments));
  EXPECT_EQ(result.status, GetParam().status) << GetParam().arguments << "\n" << result.err;
  if (GetParam().status == 0) return;
  EXPECT_FALSE(result.err.empty());
  EXPECT_TRUE(result.out.empty()) << result.out;
}

INSTANTIATE_TEST_SUITE_P(
    Each, CtlUsage,
    testing::Values(
        Usage{"", 2}, Usage{"--help", 0}, Usage{"plan --help", 0}, Usage{"--version", 0},
        Usage{"plan --version", 0}, Usage{"fly", 2}, Usage{"plan", 2},
        Usage{"plan --cell c --nonsense", 2}, Usage{"plan --cell c extra", 2},
        Usage{"plan --cell c --mode fastest", 2}, Usage{"plan --cell c --search deep", 2},
        Usage{"plan --cell c --seed -1", 2}, Usage{"plan --cell c --seed x", 2},
        Usage{"plan --cell c --seed 18446744073709551616", 2}, Usage{"plan --cell c --output=", 2},
        Usage{"scene --version", 0}, Usage{"experiment --version", 0}, Usage{"view --version", 0},
        Usage{"plan --cell c --deadline 0", 2}, Usage{"plan --cell c --deadline nan", 2},
        Usage{"plan --cell c --deadline inf", 2}, Usage{"plan --cell c --speed 0", 2},
        Usage{"plan --cell c --speed 1.5", 2}, Usage{"plan --cell c --set nonsense", 2},
        Usage{"plan --cell c --set =3", 2}, Usage{"status --domain -1", 2},
        Usage{"status --domain 233", 2}, Usage{"status --domain x", 2},
        Usage{"status --wait nan", 2}, Usage{"status --wait -1", 2}, Usage{"cancel", 2},
        Usage{"cancel 123", 2}, Usage{"watch nothex", 2}, Usage{"scene show", 3},
        Usage{"experiment", 2}, Usage{"experiment c --runs 0", 2},
        Usage{"experiment c --runs -1", 2}, Usage{"experiment c --jobs 0", 2},
        Usage{"experiment c --stretch -1", 2}, Usage{"experiment c --stretch nan", 2},
        Usage{"experiment c --seed x", 2}, Usage{"experiment c --mode fastest", 2},
        Usage{"experiment c extra", 2}, Usage{"experiment c --html=", 2},
        Usage{"view none.json -o plan.html", 2}, Usage{"view none.json", 2},
        Usage{"view none.json -o plan.txt", 2}, Usage{"plan --cell c --chain a/b/c", 2},
        Usage{"plan --cell c --chain a,,b", 2}, Usage{"plan --cell c --chain a,auto", 2},
        Usage{"plan --cell c --slack 11", 2}, Usage{"plan --cell c --slack 0.25", 3},
        Usage{"plan --cell c --slack nan", 2}, Usage{"plan --cell c --objective haste", 2},
        Usage{"plan --cell c --search paper --objective tim", 2},
        Usage{"experiment c --deadline 0", 2}, Usage{"view cell.yaml -o cell.html", 3},
        Usage{"export plan.json --format csv -o out", 3}, Usage{"record r.mcap", 3},
        Usage{"replay r.mcap", 3}, Usage{"scene apply s.yaml", 3}, Usage{"scene reset --cell c", 3},
        Usage{"plan --cell c --dump-state start", 2},
        Usage{"plan --cell c --dump-state nap.0 cup.obj", 2},
        Usage{"plan --cell c --dump-state start cup.obj extra", 2}));

TEST(CtlUsage, NamesWhatIsWrong) {
  const auto err = [](const std::string& arguments) {
    return run(std::vector{kCtl} + words(arguments)).err;
  };
  EXPECT_THAT(err("plan --cell c --mode fastest"), HasSubstr("unknown mode 'fastest'"));
  EXPECT_THAT(err("plan --cell c --search deep"), HasSubstr("unknown search 'deep'"));
  EXPECT_THAT(err("plan --cell c --objective haste"), HasSubstr("unknown objective 'haste'"));
  EXPECT_THAT(err("plan --cell c --slack 0.1"), HasSubstr("not built yet: --slack above 0"));
  EXPECT_THAT(err("plan --cell c --chain a/b/c"), HasSubstr("'a/b/c' is not ROBOT or ROBOT/ARM"));
  EXPECT_THAT(err("frob"), HasSubstr("frob"));
  EXPECT_THAT(err("plan --cel butler"), HasSubstr("--cel"));
  EXPECT_THAT(err("record r.mcap"), HasSubstr("not built yet: record"));
}

TEST(CtlHelp, EndsWithAnExampleAndTheExitCodes) {
  for (const char* command : {"", " plan", " experiment", " watch", " status", " cells", " cancel",
                              " view", " scene", " export", " record", " replay"}) {
    const std::string help = run(words(kCtl + command + " --help")).out;
    EXPECT_THAT(help, HasSubstr("Example: handoverctl" + std::string(command))) << command;
    EXPECT_THAT(help, HasSubstr("13 no daemon.")) << command;
  }
}

TEST(CtlView, NamesAFileThatItCannotReadOnce) {
  const TemporaryFolder folder;
  const std::string page = (folder / "plan.html").string(), none = (folder / "none.json").string();
  const auto err = [&page](const std::string& plan) {
    const Finished viewed = run({kCtl, "view", plan, "-o", page});
    EXPECT_EQ(viewed.status, 2);
    return viewed.err;
  };
  EXPECT_EQ(err(none), "handoverctl: " + none + ": no such file\n");
  EXPECT_EQ(err(folder.path().string()),
            "handoverctl: " + folder.path().string() + ": is not a file\n");
  const std::string bad = folder.write("bad.json", "{\n  \"format\": nothing }").string();
  EXPECT_EQ(err(bad), "handoverctl: " + bad + ": line 2, column 14: is not JSON from there on\n");
}

TEST(CtlEnvironment, RefusesADomainThatIsNone) {
  for (const char* text : {"x", "12x", "233", "-1", " 1"}) {
    EXPECT_EQ(run({kCtl, "status"}, {std::string("HANDOVER_DOMAIN=") + text}).status, 2) << text;
    EXPECT_EQ(run({kBin + "handoverd", "serve"}, {std::string("HANDOVER_DOMAIN=") + text}).status,
              2);
  }
}

TEST_F(Ctl, ExitsWith13WhenNoDaemonShowsUp) {
  for (const char* arguments : {"status --wait 0.2", "cells --wait 0", "plan --cell c --wait 0.2",
                                "experiment c --wait 0.2", "watch --wait 0.2",
                                "cancel 00112233445566778899aabbccddeeff --wait 0.2"}) {
    EXPECT_EQ(ctl(arguments).status, 13) << arguments;
  }
  const auto json = ctl("plan --cell c --wait 0.2 --json");
  EXPECT_EQ(json.status, 13);
  EXPECT_EQ(jsonLines(json.out).at(0)["exit_code"], 13);
}

TEST_F(Ctl, AnInterruptEndsTheWait) {
  Process waiting(command("plan --cell c --wait 60"));
  // The signal may come before it is blocked and handled: then it ends the process at once.
  waiting.signal(SIGINT);
  const auto status = waiting.wait();
  EXPECT_TRUE(status == 11 || status == 128 + SIGINT) << status.value_or(-1);
}

TEST_F(Ctl, ChecksTheOutputBeforeAsking) {
  const TemporaryFolder folder;
  // Below a plain file: not even root can write there.
  const std::string output = folder.write("file", "").string() + "/plan.json";
  for (const char* command : {"plan --cell c --output ", "plan --cell c --dump-state start ",
                              "experiment c --output ", "experiment c --html "}) {
    const auto result = ctl(command + output + " --wait 60");
    EXPECT_EQ(result.status, 3);
    EXPECT_THAT(result.err, HasSubstr(output));
  }
}

// ---- with a daemon ----

TEST_F(ScriptedCtl, StatusAndCells) {
  const auto status = ctl("status --json");
  EXPECT_EQ(status.status, 0);
  const auto lines = jsonLines(status.out);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0]["state"], "ready");
  EXPECT_EQ(lines[0]["cells"][0]["name"], "script");
  EXPECT_EQ(lines[0]["cells"][0]["scene_hash"], "0123abcd");
  EXPECT_GT(lines[0]["memory_bytes"], 1'000'000);
  EXPECT_EQ(lines[0]["refused"], 0);
  EXPECT_THAT(ctl("cells").out,
              HasSubstr("script: answer one three fail echo hold paced throw touch"));
  EXPECT_EQ(jsonLines(ctl("cells --json").out).at(0)["tasks"].size(), 11u);
  EXPECT_EQ(jsonLines(ctl("cells --json").out).at(0)["vary"]["number"]["range"],
            nlohmann::json::parse("[[0.0], [1.0]]"));
}

TEST_F(ScriptedCtl, StatusShowsEveryDaemon) {
  Process second({kScripted, std::to_string(domain)}), third({kScripted, std::to_string(domain)});
  for (Process* other : {&second, &third}) {
    ASSERT_TRUE(other->waitForOutput("serving")) << other->err();
  }
  // Who is not found in time, on a busy machine, is found by one of the next.
  std::size_t shown = 0;
  for (int attempt = 0; attempt < 20 && shown < 3; ++attempt) {
    shown = jsonLines(ctl("status --json").out).size();
  }
  EXPECT_EQ(shown, 3u);
}

TEST_F(ScriptedCtl, PlanWritesTheSamePlanTwice) {
  const TemporaryFolder folder;
  std::vector<std::string> plans;
  for (const char* name : {"a.json", "b.json"}) {
    const fs::path file = folder / name;
    const auto result = ctl("plan --cell script --task answer --output " + file.string());
    ASSERT_EQ(result.status, 0) << result.err;
    EXPECT_THAT(result.out, HasSubstr("home       hubo/right"));
    const std::string text = textOf(file);
    const auto json = nlohmann::json::parse(text);
    EXPECT_EQ(json["format"], "handover-plan/2");
    EXPECT_EQ(json["timing"]["scene_revision"], 7);
    plans.push_back(planMember(text));
    EXPECT_FALSE(plans.back().empty());
  }
  EXPECT_EQ(plans[0], plans[1]);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 2);  // nothing half-written
}

TEST_F(ScriptedCtl, PlansHaveAsManyStagesAsTheirChainNeeds) {
  const TemporaryFolder folder;
  const fs::path file = folder / "plan.json";
  for (const auto& [task, stages] : {std::pair{"one", 9u}, {"answer", 16u}, {"three", 23u}}) {
    const auto result =
        ctl("plan --cell script --task " + std::string(task) + " --output " + file.string());
    ASSERT_EQ(result.status, 0) << result.err;
    EXPECT_EQ(nlohmann::json::parse(textOf(file))["plan"]["stages"].size(), stages);
  }
}

TEST_F(ScriptedCtl, FlagsReachTheDaemon) {
  const auto given = ctl(
      "plan --cell script --task echo --chain crichton/left,hubo --objective dexterity --slack 0 "
      "--no-fix");
  EXPECT_EQ(given.status, 12);
  for (const char* text : {"chain: crichton/left,hubo", "objective: dexterity", "slack_s: 0.000000",
                           "wants_fix: false"}) {
    EXPECT_THAT(given.out, HasSubstr(text));
  }
  const auto defaults = ctl("plan --cell script --task echo --chain auto");
  for (const char* text :
       {"chain: auto", "objective: unspecified", "slack_s: 0.000000", "wants_fix: true"}) {
    EXPECT_THAT(defaults.out, HasSubstr(text));
  }
}

TEST_F(ScriptedCtl, AFailedRequestIsAFileToo) {
  const TemporaryFolder folder;
  const fs::path file = folder / "plan.json", state = folder / "state.obj";
  const auto result = ctl("plan --cell script --task fail --output " + file.string() +
                          " --dump-state start " + state.string());
  EXPECT_EQ(result.status, 10) << result.err;
  EXPECT_THAT(result.out, HasSubstr("no plan     no_grasp_at_goal: No grasp of cup"));
  const auto json = nlohmann::json::parse(textOf(file));
  EXPECT_TRUE(json["plan"].is_null());
  EXPECT_EQ(json["scene"]["cell"], "butler");
  EXPECT_EQ(json["explanation"]["reason"], "no_grasp_at_goal");
  EXPECT_EQ(json["explanation"]["causes"][0]["count"], 300);
  EXPECT_FALSE(fs::exists(state));  // there is no plan of which it could be a moment
}

TEST_F(ScriptedCtl, AFailureBeforeItsSceneKeepsItsExitCodeThoughItHasNoPage) {
  const TemporaryFolder folder;
  const fs::path file = folder / "plan.json", page = folder / "plan.html";
  const auto late = ctl("plan --cell script --task hold --deadline 0.05 --output " + file.string() +
                        " --html " + page.string());
  EXPECT_EQ(late.status, 11) << late.err;
  EXPECT_THAT(late.err, HasSubstr("not written: " + page.string()));
  EXPECT_TRUE(nlohmann::json::parse(textOf(file))["scene"].is_null());
  EXPECT_FALSE(fs::exists(page));
}

TEST_F(ScriptedCtl, UnwritableStandardOutputIsSaid) {
  const Finished result = run({"/bin/sh", "-c",
                               kCtl + " plan --cell script --task answer --domain " +
                                   std::to_string(domain) + " > /dev/full"});
  EXPECT_EQ(result.status, 3);
  EXPECT_THAT(result.err, HasSubstr("cannot write to standard output"));
}

TEST_F(ScriptedCtl, JsonIsAllThatStandardOutputHolds) {
  const auto result = ctl("plan --cell script --task answer --json");
  EXPECT_EQ(result.status, 0);
  const auto lines = jsonLines(result.out);
  ASSERT_EQ(lines.size(), 40u);
  for (std::size_t i = 0; i < lines.size(); ++i) EXPECT_EQ(lines[i]["sequence"], i);
  EXPECT_EQ(lines.front()["type"], "accepted");
  EXPECT_EQ(lines.back()["outcome"], "done");
  EXPECT_THAT(result.err, HasSubstr("reach      crichton/right"));
}

TEST_F(ScriptedCtl, OutcomesHaveTheirExitCodes) {
  const TemporaryFolder folder;
  const std::string output = " --output " + (folder / "plan.json").string();
  const auto failed = ctl("plan --cell script --task fail" + output);
  EXPECT_EQ(failed.status, 10);
  EXPECT_THAT(failed.out, HasSubstr("no_grasp_at_goal"));
  EXPECT_THAT(failed.out, HasSubstr("--set 'robots.hubo.base.xyz=[1.1, -0.3, 0.98]'"));
  EXPECT_EQ(ctl("plan --cell script --task throw" + output).status, 1);
  EXPECT_EQ(ctl("plan --cell script --task hold --deadline 0.05" + output).status, 11);
  const auto late = nlohmann::json::parse(textOf(folder / "plan.json"));
  EXPECT_EQ(late["explanation"]["causes"][0]["cause"], "deadline");
  fs::remove(folder / "plan.json");
  const auto unknown = ctl("plan --cell nowhere" + output);
  EXPECT_EQ(unknown.status, 12);
  EXPECT_THAT(unknown.out, HasSubstr("unknown_cell"));
  EXPECT_TRUE(fs::is_empty(folder.path()));
  EXPECT_EQ(ctl("plan --cell script --task answer").status, 0);  // and it lives
}

TEST_F(ScriptedCtl, AnInterruptCancels) {
  Process plan(command("plan --cell script --task hold"));
  ASSERT_TRUE(plan.waitForOutput("arms"));
  plan.signal(SIGINT);
  EXPECT_EQ(plan.wait(), 11);
  EXPECT_THAT(plan.out(), HasSubstr("cancelled   asked"));
}

TEST_F(ScriptedCtl, CancelAndWatchFindARequestById) {
  Process plan(command("plan --cell script --task hold --json"));
  ASSERT_TRUE(plan.waitForOutput("arm_selected"));
  const std::string id = jsonLines(plan.out().substr(0, plan.out().find('\n'))).at(0)["request_id"];
  Process watch(command("watch " + id));
  ASSERT_TRUE(watch.waitForOutput("arms"));  // what was before it came is there too
  EXPECT_EQ(ctl("cancel " + id).status, 0);
  EXPECT_EQ(plan.wait(), 11);
  EXPECT_EQ(watch.wait(), 11);
  const auto unknown = ctl("cancel 00112233445566778899aabbccddeeff --wait 4");
  EXPECT_EQ(unknown.status, 2);
  EXPECT_THAT(unknown.err, HasSubstr("no such request"));
}

TEST_F(ScriptedCtl, SigtermOfTheDaemonGivesOutcomes) {
  Process running(command("plan --cell script --task hold"));
  ASSERT_TRUE(running.waitForOutput("arms"));
  Process queued(command("plan --cell script --task answer"));
  ASSERT_TRUE(queued.waitForOutput("1 ahead"));
  daemon.signal(SIGTERM);
  EXPECT_EQ(running.wait(), 11);
  EXPECT_EQ(queued.wait(), 11);
  EXPECT_THAT(queued.out(), HasSubstr("cancelled   daemon_stopping"));
  EXPECT_EQ(daemon.wait(), 0);
}

TEST_F(ScriptedCtl, AKilledDaemonIsLost) {
  Process plan(command("plan --cell script --task hold --wait 2"));
  ASSERT_TRUE(plan.waitForOutput("arms"));
  daemon.signal(SIGKILL);
  EXPECT_EQ(plan.wait(), 13);
  EXPECT_THAT(plan.err(), HasSubstr("did not come back"));
}

TEST_F(ScriptedCtl, WatchingOrCancellingEndsWithALostDaemon) {
  Process plan(command("plan --cell script --task hold --json"));
  ASSERT_TRUE(plan.waitForOutput("arm_selected"));
  const std::string id = jsonLines(plan.out().substr(0, plan.out().find('\n'))).at(0)["request_id"];
  Process all(command("watch --wait 2")), one(command("watch --wait 2 " + id));
  ASSERT_TRUE(all.waitForOutput("arms"));
  ASSERT_TRUE(one.waitForOutput("arms"));
  daemon.signal(SIGKILL);
  EXPECT_EQ(all.wait(), 13);
  EXPECT_EQ(one.wait(), 13);
  EXPECT_THAT(one.err(), HasSubstr("did not come back"));
}

TEST_F(ScriptedCtl, AnIdOfZerosIsOneRequestLikeAnyOther) {
  EXPECT_EQ(ctl("watch 00000000000000000000000000000000 --wait 2").status, 2);
}

TEST_F(ScriptedCtl, ADaemonThatComesBackAnswersAnew) {
  Process plan(command("plan --cell script --task hold --wait 30 --json"));
  ASSERT_TRUE(plan.waitForOutput("arm_selected"));
  const std::string id = jsonLines(plan.out().substr(0, plan.out().find('\n'))).at(0)["request_id"];
  daemon.signal(SIGKILL);
  daemon.wait();
  Process second({kScripted, std::to_string(domain)});
  Process watch(command("watch " + id + " --wait 20"));
  ASSERT_TRUE(watch.waitForOutput("arms")) << second.err();
  EXPECT_EQ(ctl("cancel " + id).status, 0);
  EXPECT_EQ(plan.wait(), 11);
  const auto lines = jsonLines(plan.out());
  // What the first daemon sent; that it is void; and a whole answer of the second.
  ASSERT_EQ(lines.size(), 6u);
  EXPECT_EQ(lines[2]["type"], "restart");
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(lines[3 + i]["sequence"], i);
  EXPECT_NE(lines[3]["answer_id"], lines[1]["answer_id"]);
  EXPECT_EQ(lines[5]["answer_id"], lines[3]["answer_id"]);
  EXPECT_THAT(plan.err(), HasSubstr("restarted"));
}

TEST_F(ScriptedCtl, AKilledClientFreesTheDaemon) {
  Process plan(command("plan --cell script --task hold"));
  ASSERT_TRUE(plan.waitForOutput("arms"));
  Process watch(command("watch --json"));
  ASSERT_TRUE(watch.waitForOutput("arm_selected"));
  plan.signal(SIGKILL);
  EXPECT_TRUE(watch.waitForOutput("\"client_lost\""));
  EXPECT_EQ(ctl("plan --cell script --task answer").status, 0);
  watch.signal(SIGTERM);
  EXPECT_EQ(watch.wait(), 0);
}

TEST_F(ScriptedCtl, AStoppedClientHoldsUpNobody) {
  Process watch(command("watch"));
  ASSERT_EQ(ctl("plan --cell script --task answer").status, 0);
  ASSERT_TRUE(watch.waitForOutput("done"));
  watch.signal(SIGSTOP);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(ctl("plan --cell script --task answer").status, 0);
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(10s), 0);
}

// ---- experiments ----

TEST_F(ScriptedCtl, AnExperimentAnswersEveryRun) {
  const TemporaryFolder folder;
  const fs::path output = folder / "e.json", plans = folder / "plans";
  const std::string arguments = "experiment script --task answer --runs 12 --seed 5 --jobs 3";
  const auto result =
      ctl(arguments + " --output " + output.string() + " --plans " + plans.string());
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("12 of 12 runs solved"));
  EXPECT_THAT(result.err, HasSubstr("12 of 12 runs"));
  const auto file = nlohmann::json::parse(textOf(output));
  EXPECT_EQ(file["format"], "handover-experiment/2");
  ASSERT_EQ(file["records"].size(), 12u);
  std::set<nlohmann::json> drawn;
  for (std::size_t i = 0; i < 12; ++i) {
    const auto& record = file["records"][i];
    EXPECT_EQ(record["index"], i);
    EXPECT_EQ(record["seed"], 5 + i);
    EXPECT_EQ(record["outcome"], "done");
    EXPECT_EQ(record["handover_poses"], 17);
    EXPECT_EQ(record["first_cost"], 14.5);
    EXPECT_EQ(record["cost"], 13.5);
    EXPECT_EQ(record["quality"]["bound_s"], 10.0);
    EXPECT_LE(record["first_plan_s"], record["planning_time_s"]);
    drawn.insert(record["drawn"]["number"]);
    char name[16];
    std::snprintf(name, sizeof name, "%03zu.json", i);
    EXPECT_EQ(nlohmann::json::parse(textOf(plans / name))["format"], "handover-plan/2");
  }
  EXPECT_EQ(drawn.size(), 12u);

  const auto again = ctl(arguments + " --json");
  ASSERT_EQ(again.status, 0);
  auto lines = jsonLines(again.out);
  ASSERT_EQ(lines.size(), 13u);
  EXPECT_EQ(lines.back()["type"], "summary");
  EXPECT_EQ(lines.back()["solved"], 12);
  lines.pop_back();
  for (const auto& line : lines) {
    EXPECT_EQ(line["type"], "run");
    EXPECT_EQ(line["drawn"], file["records"][line["index"].get<std::size_t>()]["drawn"]);
  }
}

TEST_F(ScriptedCtl, AnExperimentIsShownAsAPage) {
  const TemporaryFolder folder;
  const fs::path output = folder / "e.json", html = folder / "e.html";
  const auto result = ctl("experiment script --task refuse_low --runs 12 --output " +
                          output.string() + " --html " + html.string());
  ASSERT_EQ(result.status, 0) << result.err;
  const std::string page = textOf(html);
  const std::string opening = R"(<script type="application/json" id="data">)";
  const auto begin = page.find(opening) + opening.size();
  ASSERT_LT(begin, page.size());
  const auto data =
      nlohmann::json::parse(page.substr(begin, page.find("</script>", begin) - begin));
  const auto file = nlohmann::json::parse(textOf(output));
  EXPECT_EQ(data["experiment"], file);
  EXPECT_EQ(data["task"], "refuse_low");
  EXPECT_EQ(data["versions"]["handoverd"], data["versions"]["handoverctl"]);
  ASSERT_EQ(data["more"].size(), 12u);
  for (std::size_t i = 0; i < 12; ++i) {
    const auto& more = data["more"][i];
    EXPECT_THAT(more["command"].get<std::string>(),
                HasSubstr("--cell script --task refuse_low --mode best --search wide "
                          "--objective dexterity --seed " +
                          std::to_string(i + 1) + " --set number=0."));
    const bool done = file["records"][i]["outcome"] == "done";
    EXPECT_EQ(more["lattice"].size(), done ? 2u : 0u);
    EXPECT_EQ(more["handovers"].size(), done ? 1u : 0u);
  }
}

TEST_F(ScriptedCtl, FailedRunsAreAnswersToo) {
  const TemporaryFolder folder;
  folder.write("plans/001.json", "of another experiment");
  const auto failed =
      ctl("experiment script --task fail --runs 2 --plans " + (folder / "plans").string());
  EXPECT_EQ(failed.status, 0) << failed.err;
  EXPECT_THAT(failed.out, HasSubstr("0 of 2 runs solved"));
  EXPECT_THAT(failed.out, HasSubstr("run 001 failed: no_grasp_at_goal (No grasp of cup"));
  for (const char* name : {"plans/000.json", "plans/001.json"}) {
    const auto file = nlohmann::json::parse(textOf(folder / name));
    EXPECT_TRUE(file["plan"].is_null());
    EXPECT_EQ(file["explanation"]["reason"], "no_grasp_at_goal");
  }
  const auto some = ctl("experiment script --task refuse_low --runs 12 --json");
  EXPECT_EQ(some.status, 0) << some.err;
  EXPECT_EQ(ctl("experiment script --task refuse_low --runs 3 --stretch 0").status, 0);
}

TEST_F(ScriptedCtl, ARejectedRunLeavesNoFile) {
  const TemporaryFolder folder;
  folder.write("plans/000.json", "of another experiment");
  const auto rejected =
      ctl("experiment script --task echo --runs 1 --plans " + (folder / "plans").string());
  EXPECT_EQ(rejected.status, 12) << rejected.err;
  EXPECT_TRUE(fs::is_empty(folder / "plans"));
}

// The scripted failures speak of a mesh that is nowhere.
TEST_F(ScriptedCtl, AnExperimentIsShownAsAPageWithoutFailuresThatCannotBeDrawn) {
  const TemporaryFolder folder;
  const fs::path html = folder / "e.html";
  const auto result = ctl("experiment script --task fail --runs 2 --html " + html.string());
  EXPECT_EQ(result.status, 0);
  EXPECT_THAT(result.err, HasSubstr("not written: " + (folder / "e.failures.html").string()));
  EXPECT_THAT(textOf(html), HasSubstr(R"("page": null)"));
  EXPECT_FALSE(fs::exists(folder / "e.failures.html"));
}

TEST_F(ScriptedCtl, ARunIsDrawnAgainWhenItsStartTouches) {
  const auto result = ctl("experiment script --task touch_low --runs 60 --json");
  ASSERT_EQ(result.status, 0) << result.err;
  const auto lines = jsonLines(result.out);
  int redrawn = 0;
  for (const auto& line : lines) {
    if (line["type"] != "run") continue;
    EXPECT_EQ(line["outcome"], "done");
    EXPECT_GE(line["drawn"]["number"], 0.04);
    EXPECT_EQ(line["touched"].size(), line["redrawn"].get<std::size_t>());
    redrawn += line["redrawn"].get<int>();
  }
  EXPECT_GT(redrawn, 0);
  EXPECT_EQ(lines.back()["redrawn"], redrawn);
  EXPECT_EQ(lines.back()["touched"][0]["pair"], nlohmann::json::parse(R"(["a", "b"])"));
}

TEST_F(ScriptedCtl, MoreThanATenthDrawnAgainFailsTheExperiment) {
  const TemporaryFolder folder;
  const auto result =
      ctl("experiment script --task touch --runs 20 --output " + (folder / "e.json").string());
  EXPECT_EQ(result.status, 3) << result.err;
  EXPECT_THAT(result.err, HasSubstr("3 of 3 drawn start scenes are in collision (limit 10 %"));
  EXPECT_THAT(result.err, HasSubstr("a - b (3 x)"));
  const auto file = nlohmann::json::parse(textOf(folder / "e.json"));
  ASSERT_EQ(file["records"].size(), 1u);  // the one that was drawn again and again
  EXPECT_EQ(file["records"][0]["reason"], "start_in_collision");
  EXPECT_EQ(file["summary"]["redrawn"], 3);
}

TEST_F(ScriptedCtl, ExperimentsHaveTheirExitCodes) {
  EXPECT_EQ(ctl("experiment nowhere --runs 2").status, 12);
  EXPECT_EQ(ctl("experiment script --task dance --runs 2").status, 12);
  const TemporaryFolder folder;
  const std::string file = folder.write("file", "").string();
  EXPECT_EQ(ctl("experiment script --runs 1 --output " + file + "/e.json").status, 3);
  EXPECT_EQ(ctl("experiment script --runs 1 --plans " + file + "/plans").status, 3);
  // The scripted plans show robots that are nowhere: the verifier cannot read them, or refuses.
  const auto unverified = ctl("experiment script --task answer --runs 1 --verify");
  EXPECT_TRUE(unverified.status == 1 || unverified.status == 2) << unverified.status;
}

TEST_F(ScriptedCtl, AnInterruptEndsAnExperiment) {
  Process experiment(command("experiment script --task hold --runs 5 --jobs 2"));
  Process watch(command("watch"));
  ASSERT_TRUE(watch.waitForOutput("arms"));
  experiment.signal(SIGINT);
  EXPECT_EQ(experiment.wait(), 11);
  EXPECT_TRUE(watch.waitForOutput("cancelled"));
  EXPECT_EQ(ctl("plan --cell script --task answer").status, 0);  // nothing is left in the queue
}

TEST_F(ScriptedCtl, AnExperimentEndsWithALostDaemon) {
  Process experiment(command("experiment script --task hold --runs 5 --jobs 2 --wait 2"));
  Process watch(command("watch"));
  ASSERT_TRUE(watch.waitForOutput("arms"));
  daemon.signal(SIGKILL);
  EXPECT_EQ(experiment.wait(), 13);
}

// ---- the real daemon ----

class Handoverd : public Ctl {
 protected:
  std::vector<std::string> serve(const std::string& more = "") const {
    return std::vector{kBin + "handoverd"} + words("serve --root " HANDOVER_SOURCE_DIR
                                                   " --domain " +
                                                   std::to_string(domain) + " " + more);
  }
};

TEST_F(Handoverd, ServesTheCellsAndStopsOnEitherSignal) {
  for (const int number : {SIGTERM, SIGINT}) {
    Process daemon(serve("--cell butler"), {"XDG_CACHE_HOME=" HANDOVER_BINARY_DIR "/test-cache"});
    ASSERT_THAT(ctl("cells --wait 20").out, HasSubstr("butler")) << daemon.err();
    daemon.signal(number);
    EXPECT_EQ(daemon.wait(), 0);
    EXPECT_TRUE(daemon.out().empty()) << daemon.out();
  }
}

TEST_F(Handoverd, RejectsNonsenseByField) {
  Process daemon(serve("--cell butler"), {"XDG_CACHE_HOME=" HANDOVER_BINARY_DIR "/test-cache"});
  const auto ask = [&](const std::string& more) {
    return run(command("plan --cell butler --wait 20 " + more), {}, 240s);  // maps are made first
  };
  const auto nan = ask("--set robots.hubo.base.xyz=[nan,0,0]");
  EXPECT_EQ(nan.status, 12) << nan.err;
  EXPECT_THAT(nan.out, HasSubstr("robots.hubo.base.xyz"));
  EXPECT_EQ(ask("--set robots.hubo.bass.xyz=[0,0,0]").status, 12);
  EXPECT_EQ(ask("--set robots.hubo.base.xyz=three").status, 12);
  EXPECT_EQ(ask("--task dance").status, 12);
  const auto several = ask("--chain crichton/third,nobody --set robots.hubo.base.xyz=three");
  EXPECT_EQ(several.status, 12);
  for (const char* field : {"chain", "robots.hubo.base.xyz"}) {
    EXPECT_THAT(several.out, HasSubstr(field));
  }
  const auto unknown = run(command("plan --cell nowhere"));
  EXPECT_EQ(unknown.status, 12);
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(), 0);
}

TEST_F(Handoverd, RefusesBadStarts) {
  EXPECT_EQ(run(serve("--cell nowhere")).status, 3);
  EXPECT_EQ(run(serve("--threads 0")).status, 2);
  EXPECT_EQ(run(serve("--fly")).status, 2);
  const TemporaryFolder folder;
  fs::create_directories(folder.path() / "config");
  fs::create_directories(folder.path() / "robots");
  const auto none = run({kBin + "handoverd", "serve", "--root", folder.path().string()});
  EXPECT_EQ(none.status, 3);
  EXPECT_THAT(none.err, HasSubstr("no cell"));
  EXPECT_EQ(run({kBin + "handoverd"}).status, 2);
  EXPECT_EQ(run({kBin + "handoverd", "check"}).status, 2);
  for (const char* command : {"", "serve ", "prepare ", "check "}) {
    const auto version = run(words(kBin + "handoverd " + command + "--version"));
    EXPECT_EQ(version.status, 0) << command;
    EXPECT_THAT(version.out, HasSubstr("handoverd "));
  }
}

}  // namespace
}  // namespace handover::test
