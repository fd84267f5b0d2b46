// SPDX-License-Identifier: Apache-2.0
// The page of an experiment, as text and in a real browser.
#include "process.hpp"
#include "temporary_folder.hpp"
#include "view/page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>

namespace handover::view {
namespace {

using Json = nlohmann::ordered_json;
using testing::AllOf;
using testing::Gt;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using namespace std::chrono_literals;

constexpr int kRuns = 12;
const std::string kMarkup = "</script><script>alert(1)</script>";

Json spreadOf(double mean, double median, double p95, double max) {
  return {{"mean", mean}, {"median", median}, {"p95", p95}, {"max", max}};
}

/// Run i takes i + 1 tenths of a second; 3 and 7 fail for one reason, 5 for another.
Json recordOf(int i) {
  const bool failed = i == 3 || i == 5 || i == 7;
  Json record = {{"index", i},
                 {"drawn", {{"robots.hubo.base.xyz", {1.25, 0.1 * i, 1.0}}}},
                 {"redrawn", 0},
                 {"outcome", failed ? "failed" : "done"},
                 {"reason", nullptr},
                 {"planning_time_s", 0.1 * (i + 1)},
                 {"first_plan_s", nullptr},
                 {"first_cost", nullptr},
                 {"cost", nullptr},
                 {"quality", nullptr},
                 {"grasps_giver", 10},
                 {"grasps_receiver", 20},
                 {"grasps_giver_per_pose", nullptr},
                 {"grasps_receiver_per_pose", nullptr},
                 {"handover_poses", 4},
                 {"tuples", 40},
                 {"failure_s", nullptr}};
  if (failed) {
    record["reason"] = i == 5 ? "no_path" : "no_handover_pose";
    record["explanation"] = kMarkup + std::to_string(i);
    record["failure_s"] = 0.0625;
    return record;
  }
  record["first_plan_s"] = 2.0 - 0.1 * i;
  record["first_cost"] = 12.5;
  record["cost"] = 11.5;
  record["quality"] = {{"duration_s", 9.0 + i},
                       {"clearance",
                        {{{"between", "furniture"}, {"least_m", 0.05}},
                         {{"between", "robots"}, {"least_m", 0.0125}}}}};
  record["grasps_giver_per_pose"] = 2.5;
  record["grasps_receiver_per_pose"] = i;
  return record;
}

/// Cells of two layers, each a row along x; the run's tool is in the upper one.
Json moreOf(int i, bool solved) {
  Json more = {{"command", "handoverctl plan --cell butler --seed " + std::to_string(40 + i)},
               {"lattice", Json::array()},
               {"handovers", Json::array()},
               {"page", nullptr}};
  if (!solved && i != 5) more["page"] = "report.failures.html#run-" + std::to_string(i);
  for (const double z : {1.025, 1.075}) {
    for (int cell = 0; cell < 3; ++cell) {
      more["lattice"].push_back({0.525 + 0.05 * cell, 0.025, z, 0.05 - 0.01 * cell});
    }
  }
  if (solved) {
    more["handovers"].push_back(
        {{"object", {0.5 + 0.01 * i, 0.0, 0.975}}, {"receiver_tool", {0.525, 0.025, 1.075}}});
  }
  return more;
}

/// What the page gets.
Json sampleExperiment() {
  Json records = Json::array(), more = Json::array();
  for (int i = 0; i < kRuns; ++i) {
    records.push_back(recordOf(i));
    more.push_back(moreOf(i, records.back()["outcome"] == "done"));
  }
  const Json summary = {{"runs", kRuns},
                        {"solved", 9},
                        {"redrawn", 0},
                        {"planning_time_s", spreadOf(0.65, 0.65, 1.145, 0.1 * kRuns)},
                        {"first_plan_s", spreadOf(1.4333, 1.4, 1.96, 2.0)},
                        {"duration_s", spreadOf(14.1, 13, 19.6, 20)},
                        {"object_s", spreadOf(7, 7, 8, 9)},
                        {"duration_over_bound", spreadOf(1.25, 1.2, 1.5, 1.75)},
                        {"clearance_furniture_m", {{"median", 0.05}, {"min", 0.05}}},
                        {"clearance_robots_m", {{"median", 0.0125}, {"min", 0.0025}}},
                        {"grasps_giver_mean", 10},
                        {"grasps_receiver_mean", 20},
                        {"handover_poses_mean", 4}};
  const Json paper = {{"table", "II"},
                      {"planning_time_s", 2.31},
                      {"grasps_giver", 32.36},
                      {"grasps_receiver", 39.77},
                      {"handover_poses", 16.64}};
  return {{"experiment",
           {{"format", "handover-experiment/2"},
            {"cell", "butler"},
            {"seed", 40},
            {"mode", "all"},
            {"search", "paper"},
            {"objective", "dexterity"},
            {"stretch", 1.0},
            {"machine", "a machine, 2 cores"},
            {"records", records},
            {"summary", summary}}},
          {"task", "serve"},
          {"versions", {{"handoverctl", "1.2.3"}, {"handoverd", "7.8.9"}}},
          {"paper", paper},
          {"lattice_edge", 0.05},
          {"more", more}};
}

TEST(ExperimentPage, ReachesForNothingOutside) {
  const std::string page = experimentPage(sampleExperiment().dump());
  EXPECT_THAT(page, HasSubstr("default-src 'none'; script-src 'sha256-"));
  EXPECT_THAT(page, Not(HasSubstr("unsafe-inline")));
  EXPECT_THAT(page, Not(HasSubstr("<script src")));
  EXPECT_THAT(page, Not(HasSubstr("<link ")));
}

TEST(ExperimentPage, KeepsMarkupInTextsOutOfThePage) {
  const std::string page = experimentPage(sampleExperiment().dump());
  EXPECT_THAT(page, Not(HasSubstr("<script>alert")));
  EXPECT_THAT(page, HasSubstr("\\u003c/script>\\u003cscript>alert(1)"));
}

class BrowsedPage : public testing::Test {
 protected:
  /// What the browser sees of an experiment's page.
  Json browse(const Json& experiment) {
    const auto page = folder_.write("report.html", experimentPage(experiment.dump()));
    const auto browsed = test::run({NODE, BROWSE_REPORT, page.string(), picture()}, {}, 240s);
    EXPECT_EQ(browsed.status, 0) << browsed.err;
    EXPECT_THAT(std::filesystem::file_size(picture()), Gt(20'000u));
    return Json::parse(browsed.out);
  }

  /// Of the sample: looked at once.
  const Json& seenSample() {
    static const Json seen = browse(sampleExperiment());
    return seen;
  }

  std::string picture() const { return (folder_ / "report.png").string(); }

  const test::TemporaryFolder folder_;
};

TEST_F(BrowsedPage, ShowsTheNumbersGiven) {
  const Json& seen = seenSample();
  EXPECT_THAT(seen["messages"], IsEmpty());
  EXPECT_THAT(seen["requests"], IsEmpty());
  EXPECT_EQ(seen["error"], false);
  EXPECT_EQ(seen["title"], "butler: 9 of 12 runs solved");
  EXPECT_THAT(seen["setting"].get<std::string>(),
              AllOf(HasSubstr("taskserve"), HasSubstr("seed40"), HasSubstr("modeall"),
                    HasSubstr("searchpaper"), HasSubstr("a machine, 2 cores"),
                    HasSubstr("handoverd7.8.9")));
  EXPECT_EQ(seen["means"], Json::parse(R"json([["planning time [s]", "2.31", "0.6500"],
                            ["giver’s grasps |G_g|, at the start (§IV-C)", "32.36", "10.00"],
                            ["giver’s grasps |G_g*|, for each handover pose", "", "2.50"],
                            ["receiver’s grasps |G_r|, at the goal (§IV-B)", "39.77", "20.00"],
                            ["receiver’s grasps, for each handover pose", "", "5.67"],
                            ["handover poses", "16.64", "4.00"]])json"));
  EXPECT_EQ(seen["spreads"],
            Json::parse(R"([["to the outcome", "0.6500", "0.6500", "1.1450", "1.2000"],
                            ["to the first plan", "1.4333", "1.4000", "1.9600", "2.0000"]])"));
  EXPECT_EQ(seen["qualities"], Json::parse(R"([["duration [s]", "14.10", "13.00", "19.60", "20.00"],
                            ["object under way [s]", "7.00", "7.00", "8.00", "9.00"],
                            ["duration, of the shortest possible", "1.25", "1.20", "1.50", "1.75"]])"));
  EXPECT_EQ(seen["clearances"], Json::parse(R"([["to furniture", "50.0", "50.0"],
                                                ["between robots", "12.5", "2.5"]])"));
  ASSERT_EQ(seen["failures"].size(), 3u);
  EXPECT_EQ(seen["failures"][0][0], "no_handover_pose (2 ×)");
  EXPECT_EQ(seen["failures"][0][1], "3");
  EXPECT_THAT(seen["failures"][0][2].get<std::string>(), HasSubstr(kMarkup + "3"));
  EXPECT_EQ(seen["failures"][1][0], "7");  // below the same reason
  EXPECT_EQ(seen["failures"][2][0], "no_path (1 ×)");
  const Json more = sampleExperiment()["more"];
  EXPECT_EQ(seen["commands"], (Json{more[3]["command"], more[7]["command"], more[5]["command"]}));
  // Run 4: its place, drawn again, outcome, times and counts, the plan; x and z are the same in
  // every run.
  EXPECT_EQ(seen["runs"][4],
            Json::parse(R"(["4", "0.4000", "0", "done", "0.5000", "1.6000", "10", "20", "4", "40",
                            "–", "12.50", "11.50", "13.0", "12.5"])"));
  EXPECT_EQ(seen["runs"][5][3], "no_path");
  EXPECT_EQ(seen["runs"][5][5], "–");
  EXPECT_EQ(seen["runs"][5][10], "0.0625");
}

TEST_F(BrowsedPage, LinksFailuresToTheirPages) {
  const Json& seen = seenSample();
  const Json links{"report.failures.html#run-3", "report.failures.html#run-7"};
  EXPECT_EQ(seen["failure_links"], links);
  EXPECT_EQ(seen["run_links"], links);
  EXPECT_THAT(seen["failures_text"].get<std::string>(), HasSubstr("2 have one"));
}

TEST_F(BrowsedPage, DrawsEveryRunAndIsNotBlank) {
  const Json& seen = seenSample();
  const auto total = [&](const char* kind) {
    int sum = 0;
    for (const Json& bar : seen["bars"][kind]) sum += bar.get<int>();
    return sum;
  };
  EXPECT_EQ(total("done"), 9);
  EXPECT_EQ(total("failed"), 3);
  EXPECT_EQ(seen["marks"], (Json{"mean 0.65 s", "median 0.65 s", "p95 1.15 s"}));
  // From above the layer of the tool, from the side both layers.
  const Json& places = seen["places"];
  EXPECT_EQ(places["views"], 2);
  EXPECT_EQ(places["points"], 2 * 9);
  EXPECT_EQ(places["cells"], 3 + 6);
  EXPECT_EQ(places["chosen"],
            (Json{"run 0: 0.500, 0.000, 0.975 m", "run 0: 0.500, 0.000, 0.975 m"}));
  EXPECT_THAT(places["text"].get<std::string>(), HasSubstr("z = 1.075 m and y = 0.025 m"));
  EXPECT_EQ(seen["places_after"]["chosen"][0], "run 1: 0.525, 0.025, 1.075 m");
  EXPECT_GT(seen["colours"], 200) << "the picture is blank";
}

TEST_F(BrowsedPage, FitsOnAPhone) { EXPECT_THAT(seenSample()["beyond_phone"], IsEmpty()); }

TEST_F(BrowsedPage, SortsByTheColumnClicked) {
  Json experiment = sampleExperiment();
  Json& records = experiment["experiment"]["records"];
  std::swap(records[0]["planning_time_s"], records[11]["planning_time_s"]);
  const Json seen = browse(experiment);
  const auto ends = [](const Json& indices) { return Json{indices.front(), indices.back()}; };
  EXPECT_EQ(seen["by_time"].size(), 12u);
  EXPECT_EQ(seen["by_time"][1], "1");
  EXPECT_EQ(ends(seen["by_time"]), (Json{"11", "0"}));
  EXPECT_EQ(ends(seen["by_time_down"]), (Json{"0", "11"}));
  // Those without a plan come last.
  EXPECT_EQ(seen["by_first_plan"],
            (Json{"11", "10", "9", "8", "6", "4", "2", "1", "0", "3", "5", "7"}));
}

TEST_F(BrowsedPage, ShowsEveryHandoverOfAChain) {
  Json experiment = sampleExperiment();
  for (Json& run : experiment["more"]) {
    if (!run["handovers"].empty()) {
      run["handovers"].push_back({{"object", {0.6, 0.1, 1.0}}, {"receiver_tool", {0.6, 0.1, 1.1}}});
    }
  }
  const Json seen = browse(experiment);
  EXPECT_THAT(seen["messages"], IsEmpty());
  EXPECT_EQ(seen["places"]["points"], 2 * 18);
  EXPECT_EQ(seen["places"]["chosen"][1], "run 0, handover 2: 0.600, 0.100, 1.000 m");
  EXPECT_THAT(seen["places"]["text"].get<std::string>(), HasSubstr("18 in 9 solved runs"));
}

TEST_F(BrowsedPage, ShowsAnExperimentWithoutAnyPlan) {
  Json data = sampleExperiment();
  Json& experiment = data["experiment"];
  experiment["cell"] = "elsewhere";
  data["paper"] = nullptr;
  for (Json& record : experiment["records"]) {
    const int index = record["index"];
    record.update({{"outcome", "rejected"},
                   {"reason", "bad_request"},
                   {"quality", nullptr},
                   {"first_plan_s", nullptr},
                   {"cost", nullptr},
                   {"first_cost", nullptr},
                   {"grasps_giver_per_pose", nullptr},
                   {"grasps_receiver_per_pose", nullptr},
                   {"failure_s", nullptr}});
    Json& run = data["more"][static_cast<std::size_t>(index)];
    run["handovers"] = Json::array();
    if (index > 1) run["lattice"] = Json::array();
  }
  for (const char* key : {"first_plan_s", "duration_s", "object_s", "duration_over_bound",
                          "clearance_furniture_m", "clearance_robots_m"}) {
    experiment["summary"][key] = nullptr;
  }
  experiment["summary"]["solved"] = 0;
  const Json seen = browse(data);
  EXPECT_THAT(seen["messages"], IsEmpty());
  EXPECT_EQ(seen["error"], false);
  EXPECT_EQ(seen["means"][0], (Json{"planning time [s]", "0.6500"}));
  EXPECT_THAT(seen["qualities"], IsEmpty());
  EXPECT_EQ(seen["failures"].size(), 12u);
  EXPECT_EQ(seen["runs"][0].size(), 10u);  // no columns for what no run has
  EXPECT_EQ(seen["places"]["points"], 0);
  EXPECT_EQ(seen["places"]["cells"], 3 + 6);
}

}  // namespace
}  // namespace handover::view
