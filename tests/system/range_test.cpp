// SPDX-License-Identifier: Apache-2.0
// The scenes over their ranges, by the real programs: what is drawn is planned, and every plan
// verified.
#include "plan_text.hpp"
#include "process.hpp"
#include "temporary_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <signal.h>

#include <cmath>

namespace handover::test {
namespace {

const std::string kBin = HANDOVER_BINARY_DIR "/bin/";

class Range : public testing::Test {
 protected:
  /// The experiment's file; its exit status is 0, so no plan has violations.
  nlohmann::json experiment(const std::string& cell, int runs, const std::string& more = "") {
    return unverified(cell, runs, "--verify " + more);
  }

  nlohmann::json unverified(const std::string& cell, int runs, const std::string& more,
                            int threads = 1) {
    Process daemon(
        words(kBin + "handoverd serve --root " HANDOVER_SOURCE_DIR " --cell " + cell +
              " --threads " + std::to_string(threads) + " --domain " + std::to_string(domain_)),
        {"XDG_CACHE_HOME=" HANDOVER_BINARY_DIR "/test-cache"});
    const std::string file = (folder_ / "e.json").string();
    const Finished result = run(words(kBin + "handoverctl experiment " + cell +
                                      " --wait 60 --runs " + std::to_string(runs) + " --output " +
                                      file + " " + more + " --domain " + std::to_string(domain_)),
                                {}, std::chrono::seconds(120 + 60 * runs));
    EXPECT_EQ(result.status, 0) << result.out << result.err;
    daemon.signal(SIGTERM);
    EXPECT_EQ(daemon.wait(), 0);
    return nlohmann::json::parse(textOf(file));
  }

  const int domain_ = freeDomain();
  TemporaryFolder folder_;
};

int runsWanted() {
  const char* runs = std::getenv("HANDOVER_RANGE_RUNS");
  return runs == nullptr ? 5 : std::atoi(runs);
}

/// Every draw of a number lies in its range.
void expectDrawn(const nlohmann::json& file, const char* path, int axis, double from, double to) {
  for (const auto& record : file["records"]) {
    const double value = record["drawn"][path][axis];
    EXPECT_TRUE(value >= from && value <= to) << path << ' ' << value;
  }
}

/// Every draw is planned, its plan valid.
void expectAllSolved(const nlohmann::json& file) {
  ASSERT_EQ(file["records"].size(), static_cast<std::size_t>(runsWanted()));
  for (const auto& record : file["records"]) {
    EXPECT_EQ(record["outcome"], "done") << record;
    EXPECT_TRUE(record["violations"].empty()) << record;
    EXPECT_GT(record["grasps_giver"], 0);
    EXPECT_GT(record["grasps_receiver"], 0);
    EXPECT_GT(record["handover_poses"], 0);
  }
}

TEST_F(Range, ButlerIsPlannedAndVerifiedWhereverHuboStands) {
  const auto file = experiment("butler", runsWanted());
  expectAllSolved(file);
  expectDrawn(file, "robots.hubo.base.xyz", 1, -0.8, 0.8);
}

TEST_F(Range, StoolIsPlannedAndVerifiedWhereverItStands) {
  const auto file = experiment("stool", runsWanted());
  expectAllSolved(file);
  expectDrawn(file, "objects.stool.pose.xyz", 1, 0.46, 0.76);
}

TEST_F(Range, KneelingIsPlannedAndVerifiedWhereverTheJarGoes) {
  const auto file = experiment("kneeling", runsWanted());
  expectAllSolved(file);
  expectDrawn(file, "tasks.feed.goal.rpy_deg", 0, 10, 50);
}

/// The far end of this range is at the limit of both arms' reach: a draw there may fail, but says
/// why.
TEST_F(Range, ButlerLeftIsPlannedOrSaysWhyNot) {
  const auto file = experiment("butler_left", runsWanted());
  int solved = 0;
  for (const auto& record : file["records"]) {
    if (record["outcome"] == "done") {
      ++solved;
      EXPECT_TRUE(record["violations"].empty()) << record;
      continue;
    }
    EXPECT_EQ(record["outcome"], "failed") << record;
    EXPECT_TRUE(record["reason"].is_string() && record["explanation"].is_string()) << record;
  }
  EXPECT_GT(solved, 0);
}

class EveryCell : public Range, public testing::WithParamInterface<const char*> {};

TEST_P(EveryCell, PlansAreTheSameToTheByteForAnyThreads) {
  const auto plans = [&](const char* name) { return (folder_ / name).string(); };
  const auto one = unverified(GetParam(), 4, "--plans " + plans("one"));
  const auto four = unverified(GetParam(), 4, "--jobs 4 --plans " + plans("four"), 4);
  int done = 0;
  for (int i = 0; i < 4; ++i) {
    ASSERT_EQ(one["records"][i]["outcome"], four["records"][i]["outcome"]);
    ASSERT_EQ(one["records"][i]["reason"], four["records"][i]["reason"]);
    if (one["records"][i]["outcome"] != "done") continue;
    ++done;
    const std::string name = "00" + std::to_string(i) + ".json";
    const std::string text = planMember(textOf(folder_ / "one" / name));
    EXPECT_GT(text.size(), 1000u);
    EXPECT_EQ(text, planMember(textOf(folder_ / "four" / name))) << name;
  }
  EXPECT_GE(done, 3);
}

INSTANTIATE_TEST_SUITE_P(Shipped, EveryCell,
                         testing::Values("butler", "butler_left", "stool", "kneeling", "relay",
                                         "hand_to_hand", "pick_place", "serve_person"),
                         [](const auto& cell) { return std::string(cell.param); });

TEST_F(Range, ARunCanBeRepeatedFromItsRecord) {
  const auto file = experiment("butler", 2, "--seed 3 --plans " + (folder_ / "plans").string());
  const auto& record = file["records"][1];
  Process daemon(
      words(kBin + "handoverd serve --root " HANDOVER_SOURCE_DIR " --cell butler --domain " +
            std::to_string(domain_)),
      {"XDG_CACHE_HOME=" HANDOVER_BINARY_DIR "/test-cache"});
  std::vector<std::string> command =
      words(kBin + "handoverctl plan --cell butler --wait 60 --seed " +
            std::to_string(record["seed"].get<std::uint64_t>()) + " --output " +
            (folder_ / "p.json").string() + " --domain " + std::to_string(domain_));
  for (const auto& [path, value] : record["drawn"].items()) {
    command.push_back("--set");
    command.push_back(path + "=" + value.dump());
  }
  const Finished planned = run(command, {}, std::chrono::seconds(120));
  ASSERT_EQ(planned.status, 0) << planned.out << planned.err;
  const auto plan = [](const std::filesystem::path& path) {
    const auto read = nlohmann::json::parse(textOf(path));
    return nlohmann::json{read["scene"], read["plan"]};
  };
  EXPECT_EQ(plan(folder_ / "p.json"), plan(folder_ / "plans" / "001.json"));
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(), 0);
}

}  // namespace
}  // namespace handover::test
