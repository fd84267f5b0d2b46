// SPDX-License-Identifier: Apache-2.0
// The page of an experiment, as text and in a real browser.
#include "experiment_page.hpp"
#include "process.hpp"
#include "temporary_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

namespace handover::ctl {
namespace {

using client::Json;
using testing::AllOf;
using testing::Gt;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using namespace std::chrono_literals;

constexpr int kRuns = 12;
const std::string kMarkup = "</script><script>alert(1)</script>";

/// Run i takes i + 1 tenths of a second; 3 and 7 fail for one reason, 5 for another.
ExperimentRecord sampleExperiment() {
  ExperimentRecord experiment;
  experiment.cell = "butler";
  experiment.task = "serve";
  experiment.seed = 40;
  experiment.mode = SearchMode::kAll;
  experiment.search = SearchWidth::kPaper;
  experiment.machine = "a machine, 2 cores";
  experiment.daemon_version = "7.8.9";
  for (int i = 0; i < kRuns; ++i) {
    RunRecord run;
    run.index = static_cast<std::uint64_t>(i);
    run.seed = 40 + run.index;
    run.drawn["robots.hubo.base.xyz"] = {1.25, 0.1 * i, 1.0};
    run.planning_time_s = 0.1 * (i + 1);
    run.counts = {10, 20, 4, 40};
    // Cells of two layers, each a row along x; the run's tool is in the upper one.
    for (const double z : {1.025, 1.075}) {
      for (int cell = 0; cell < 3; ++cell) {
        run.lattice.push_back({{0.525 + 0.05 * cell, 0.025, z}, 0.05 - 0.01 * cell});
      }
    }
    if (i == 3 || i == 5 || i == 7) {
      run.outcome = "failed";
      run.reason = i == 5 ? "no_path" : "no_handover_pose";
      run.explanation = kMarkup + std::to_string(i);
    } else {
      run.outcome = "done";
      run.first_plan_s = 2.0 - 0.1 * i;
      run.handover = {{0.5 + 0.01 * i, 0.0, 0.975}, {0.525, 0.025, 1.075}};
    }
    experiment.runs.push_back(run);
  }
  return experiment;
}

TEST(ExperimentPage, ReachesForNothingOutside) {
  const std::string page = experimentPage(sampleExperiment());
  EXPECT_THAT(page, HasSubstr("default-src 'none'; script-src 'sha256-"));
  EXPECT_THAT(page, Not(HasSubstr("unsafe-inline")));
  EXPECT_THAT(page, Not(HasSubstr("<script src")));
  EXPECT_THAT(page, Not(HasSubstr("<link ")));
}

TEST(ExperimentPage, KeepsMarkupInTextsOutOfThePage) {
  const std::string page = experimentPage(sampleExperiment());
  EXPECT_THAT(page, Not(HasSubstr("<script>alert")));
  EXPECT_THAT(page, HasSubstr("\\u003c/script>\\u003cscript>alert(1)"));
}

TEST(RepeatCommand, IsOneCommandOfPlainWords) {
  ExperimentRecord experiment = sampleExperiment();
  RunRecord run = experiment.runs[2];
  run.drawn = {{"robots.hubo.base.xyz", {1.25, 0.5, 1.0}}, {"word", "it's; rm"}};
  EXPECT_EQ(repeatCommand(experiment, run),
            "handoverctl plan --cell butler --task serve --mode all --search paper --seed 42 "
            "--set 'robots.hubo.base.xyz=[1.25, 0.5, 1.0]' --set 'word=it'\\''s; rm'");
  experiment.task.clear();
  experiment.cell = "a b";
  run.drawn = Json::object();
  EXPECT_EQ(repeatCommand(experiment, run),
            "handoverctl plan --cell 'a b' --mode all --search paper --seed 42");
}

class BrowsedPage : public testing::Test {
 protected:
  /// What the browser sees of an experiment's page.
  Json browse(const ExperimentRecord& experiment) {
    const auto page = folder_.write("report.html", experimentPage(experiment));
    const auto browsed = test::run({NODE, BROWSE_REPORT, page.string(), picture()}, {}, 120s);
    EXPECT_EQ(browsed.status, 0) << browsed.err;
    return Json::parse(browsed.out);
  }

  std::string picture() const { return (folder_ / "report.png").string(); }

  const test::TemporaryFolder folder_;
};

TEST_F(BrowsedPage, ShowsTheNumbersGiven) {
  const Json seen = browse(sampleExperiment());
  EXPECT_THAT(seen["messages"], IsEmpty());
  EXPECT_THAT(seen["requests"], IsEmpty());
  EXPECT_EQ(seen["error"], false);
  EXPECT_EQ(seen["title"], "butler: 9 of 12 runs solved");
  EXPECT_THAT(seen["setting"].get<std::string>(),
              AllOf(HasSubstr("taskserve"), HasSubstr("seed40"), HasSubstr("modeall"),
                    HasSubstr("searchpaper"), HasSubstr("a machine, 2 cores"),
                    HasSubstr("handoverd7.8.9")));
  EXPECT_EQ(seen["means"], Json::parse(R"([["planning time [s]", "2.31", "0.6500"],
                                           ["giver’s grasps |G_g|", "32.36", "10.00"],
                                           ["receiver’s grasps |G_r|", "39.77", "20.00"],
                                           ["handover poses", "16.64", "4.00"]])"));
  EXPECT_EQ(seen["spreads"],
            Json::parse(R"([["to the outcome", "0.6500", "0.6500", "1.1450", "1.2000"],
                            ["to the first plan", "1.4333", "1.4000", "1.9600", "2.0000"]])"));
  ASSERT_EQ(seen["failures"].size(), 3u);
  EXPECT_EQ(seen["failures"][0][0], "no_handover_pose (2 ×)");
  EXPECT_EQ(seen["failures"][0][1], "3");
  EXPECT_THAT(seen["failures"][0][2].get<std::string>(), HasSubstr(kMarkup + "3"));
  EXPECT_EQ(seen["failures"][1][0], "7");  // below the same reason
  EXPECT_EQ(seen["failures"][2][0], "no_path (1 ×)");
  const ExperimentRecord experiment = sampleExperiment();
  EXPECT_EQ(seen["commands"], (Json{repeatCommand(experiment, experiment.runs[3]),
                                    repeatCommand(experiment, experiment.runs[7]),
                                    repeatCommand(experiment, experiment.runs[5])}));
  // Run 4: its place, drawn again, outcome, times and counts; x and z are the same in every run.
  EXPECT_EQ(seen["runs"][4], Json::parse(R"(["4", "0.4000", "0", "done", "0.5000", "1.6000", "10",
                                             "20", "4", "40"])"));
  EXPECT_EQ(seen["runs"][5][3], "no_path");
  EXPECT_EQ(seen["runs"][5][5], "–");
}

TEST_F(BrowsedPage, DrawsEveryRunAndIsNotBlank) {
  const Json seen = browse(sampleExperiment());
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
  EXPECT_THAT(std::filesystem::file_size(picture()), Gt(20'000u));
}

TEST_F(BrowsedPage, SortsByTheColumnClicked) {
  ExperimentRecord experiment = sampleExperiment();
  std::swap(experiment.runs[0].planning_time_s, experiment.runs[11].planning_time_s);
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

TEST_F(BrowsedPage, ShowsAnExperimentWithoutAnyPlan) {
  ExperimentRecord experiment = sampleExperiment();
  experiment.cell = "elsewhere";
  for (RunRecord& run : experiment.runs) {
    run.outcome = "rejected";
    run.reason = "bad_request";
    run.handover.reset();
    run.first_plan_s.reset();
    if (run.index > 1) run.lattice.clear();
  }
  const Json seen = browse(experiment);
  EXPECT_THAT(seen["messages"], IsEmpty());
  EXPECT_EQ(seen["error"], false);
  EXPECT_EQ(seen["means"][0], (Json{"planning time [s]", "0.6500"}));
  EXPECT_EQ(seen["failures"].size(), 12u);
  EXPECT_EQ(seen["places"]["points"], 0);
  EXPECT_EQ(seen["places"]["cells"], 3 + 6);
}

}  // namespace
}  // namespace handover::ctl
