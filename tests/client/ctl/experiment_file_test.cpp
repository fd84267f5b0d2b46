// SPDX-License-Identifier: Apache-2.0
#include "experiment_file.hpp"

#include "plan_file/json_writer.hpp"
#include "sample_events.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

namespace handover::ctl {
namespace {

using client::Json;
using testing::HasSubstr;

TEST(SpreadOf, InterpolatesQuantiles) {
  const auto spread = spreadOf({4, 1, 3, 2});
  ASSERT_TRUE(spread);
  EXPECT_DOUBLE_EQ(spread->mean, 2.5);
  EXPECT_DOUBLE_EQ(spread->median, 2.5);
  EXPECT_DOUBLE_EQ(spread->p95, 3.85);
  EXPECT_DOUBLE_EQ(spread->max, 4);
  EXPECT_DOUBLE_EQ(spreadOf({7})->p95, 7);
  EXPECT_FALSE(spreadOf({}));
}

void add(Funnel& funnel, PlanEventPayload payload) {
  funnel.add(PlanEvent{RequestId{}, test::kSampleAnswer, 0, 0, std::move(payload)});
}

const ArmName kGiver{"crichton", "right"}, kReceiver{"hubo", "left"}, kOther{"crichton", "left"};

GraspsPruned prunedOf(const ArmName& arm, PruningPlace place, std::uint32_t kept) {
  return {.arm = arm, .holder = 0, .place = place, .tested = 316, .kept = kept, .causes = {}};
}

HandoverCandidates candidatesOf(const ArmName& giver, const ArmName& receiver, std::uint32_t poses,
                                std::uint32_t tuples, std::uint32_t handover = 0) {
  HandoverCandidates candidates{.handover = handover, .giver = giver, .receiver = receiver};
  candidates.poses = poses;
  candidates.receiver_grasps = 2 * poses;
  candidates.tuples = tuples;
  return candidates;
}

Solution solutionOf(const std::vector<ArmName>& arms) {
  Solution solution;
  for (const ArmName& arm : arms) solution.holders.push_back({.arm = arm});
  return solution;
}

TEST(Funnel, CountsTheChainOfTheSolution) {
  Funnel funnel;
  for (const PlanEvent& event : test::sampleAnswer(RequestId::random())) funnel.add(event);
  const auto counts = funnel.counts();
  EXPECT_FALSE(counts.grasps_giver);  // the sample prunes the receiver's only
  EXPECT_EQ(counts.grasps_receiver, 40u);
  EXPECT_EQ(counts.handover_poses, 17u);
  EXPECT_EQ(counts.tuples, 306u);
  EXPECT_EQ(counts.grasps_giver_per_pose, 18);
  EXPECT_EQ(counts.grasps_receiver_per_pose, 2);
  EXPECT_EQ(funnel.object(), "cup");
}

TEST(Funnel, CountsTheArmsSelectedWhenThereIsNoSolution) {
  Funnel funnel;
  add(funnel, ArmSelected{{kGiver, kReceiver}, {}});
  add(funnel, prunedOf(kGiver, PruningPlace::kStart, 31));
  add(funnel, prunedOf(kOther, PruningPlace::kStart, 99));
  add(funnel, prunedOf(kReceiver, PruningPlace::kGoal, 7));
  add(funnel, candidatesOf(kGiver, kReceiver, 2, 9));
  add(funnel, candidatesOf(kOther, kReceiver, 70, 90));
  const auto counts = funnel.counts();
  EXPECT_EQ(counts.grasps_giver, 31u);
  EXPECT_EQ(counts.grasps_receiver, 7u);
  EXPECT_EQ(counts.handover_poses, 2u);
  EXPECT_EQ(counts.tuples, 9u);
}

TEST(Funnel, AddsUpTheHandoversOfALongChainAndHasNoneOfOneHolder) {
  Funnel funnel;
  add(funnel, prunedOf(kGiver, PruningPlace::kStart, 31));
  add(funnel, prunedOf(kOther, PruningPlace::kGoal, 5));
  add(funnel, candidatesOf(kGiver, kReceiver, 2, 9, 0));
  add(funnel, candidatesOf(kReceiver, kOther, 3, 11, 1));
  add(funnel, candidatesOf(kReceiver, kOther, 50, 50, 0));  // of another chain
  add(funnel, solutionOf({kGiver, kReceiver, kOther}));
  EXPECT_EQ(funnel.counts().handover_poses, 5u);
  EXPECT_EQ(funnel.counts().tuples, 20u);
  EXPECT_EQ(funnel.counts().grasps_receiver, 5u);
  add(funnel, solutionOf({kGiver}));
  EXPECT_FALSE(funnel.counts().grasps_giver);
  EXPECT_FALSE(funnel.counts().grasps_receiver);
  EXPECT_FALSE(funnel.counts().grasps_giver_per_pose);
  EXPECT_EQ(funnel.counts().handover_poses, 0u);
}

TEST(Funnel, KeepsTheCrossedMapsOfTheArmsAndTheFinalSolution) {
  Funnel funnel;
  EXPECT_EQ(funnel.chosen(), nullptr);
  const std::vector<LatticeCell> cells = {{{0.5, 0, 1}, 0.4}, {{0.55, 0, 1}, 0.3}};
  HandoverCandidates other = candidatesOf(kOther, kReceiver, 9, 9);
  other.lattice = {{{2, 2, 2}, 1}};
  HandoverCandidates first = candidatesOf(kGiver, kReceiver, 0, 0);
  first.lattice = cells;
  add(funnel, other);
  add(funnel, first);
  add(funnel, candidatesOf(kGiver, kReceiver, 5, 9));  // widened: the same cells
  Solution solution = solutionOf({kGiver, kReceiver});
  add(funnel, solution);
  Solution second = solution;
  second.index = 1;
  add(funnel, second);
  EXPECT_EQ(funnel.lattice(), cells);
  EXPECT_EQ(funnel.chosen(), nullptr);
  add(funnel, Outcome{Done{0, true}});
  ASSERT_NE(funnel.chosen(), nullptr);
  EXPECT_EQ(*funnel.chosen(), solution);
}

TEST(Funnel, ForgetsAnAnswerWhenAnotherBegins) {
  Funnel funnel;
  for (const PlanEvent& event : test::sampleAnswer(RequestId::random())) funnel.add(event);
  PlanEvent event{RequestId{}, {7}, 0, 0, Accepted{}};
  funnel.add(event);
  EXPECT_EQ(funnel.counts().handover_poses, 0u);
  EXPECT_EQ(funnel.chosen(), nullptr);
}

ExperimentRecord sampleExperiment() {
  ExperimentRecord experiment;
  experiment.cell = "butler";
  experiment.machine = "a machine, 2 cores";
  RunRecord solved;
  solved.index = 0;
  solved.seed = 1;
  solved.drawn["robots.hubo.base.xyz"] = {1.18, 0.1, 0.98};
  solved.redrawn = 1;
  solved.touched = {{"hubo/Body_LWR", "table"}};
  solved.outcome = "done";
  solved.planning_time_s = 0.25;
  solved.first_plan_s = 0.125;
  solved.first_cost = 15;
  solved.cost = 14.5;
  solved.quality = test::sampleQuality();
  solved.counts = {10, 20, 2.5, 1.5, 4, 40};
  RunRecord failed;
  failed.index = 1;
  failed.seed = 2;
  failed.outcome = "failed";
  failed.reason = "no_path";
  failed.explanation = "no way";
  failed.planning_time_s = 0.75;
  failed.failure_s = 0.5;
  failed.violations = {{"plan t=0 limits: q"}};
  experiment.runs = {solved, failed};
  return experiment;
}

std::vector<std::string> keysOf(const Json& json) {
  std::vector<std::string> keys;
  for (auto it = json.begin(); it != json.end(); ++it) keys.push_back(it.key());
  return keys;
}

TEST(ExperimentFile, HoldsWhatItsFormatSays) {
  const Json file = toJson(sampleExperiment());
  EXPECT_EQ(file["format"], "handover-experiment/2");
  EXPECT_THAT(keysOf(file),
              testing::ElementsAre("format", "cell", "seed", "mode", "search", "objective",
                                   "stretch", "machine", "records", "summary"));
  EXPECT_EQ(file["objective"], "dexterity");
  ASSERT_EQ(file["records"].size(), 2u);
  for (const Json& record : file["records"]) {
    EXPECT_THAT(keysOf(record),
                testing::IsSupersetOf({"index", "drawn", "redrawn", "outcome", "reason",
                                       "planning_time_s", "first_plan_s", "first_cost", "cost",
                                       "quality", "grasps_giver", "grasps_receiver",
                                       "grasps_giver_per_pose", "grasps_receiver_per_pose",
                                       "handover_poses", "tuples", "failure_s"}));
  }
  const Json &solved = file["records"][0], &failed = file["records"][1];
  EXPECT_FALSE(solved.contains("lattice"));  // of the page alone
  EXPECT_FALSE(solved.contains("handovers"));
  EXPECT_EQ(solved["reason"], nullptr);
  EXPECT_EQ(solved["quality"]["duration_s"], 12.5);
  EXPECT_EQ(solved["failure_s"], nullptr);
  for (const char* key : {"first_plan_s", "first_cost", "cost", "quality", "grasps_giver",
                          "grasps_receiver_per_pose"}) {
    EXPECT_EQ(failed[key], nullptr) << key;
  }
  EXPECT_EQ(failed["failure_s"], 0.5);
}

TEST(ExperimentFile, SumsUpWhatItsRecordsHave) {
  const Json summary = summaryOf(sampleExperiment());
  EXPECT_EQ(summary["runs"], 2);
  EXPECT_EQ(summary["solved"], 1);
  EXPECT_EQ(summary["redrawn"], 1);
  EXPECT_EQ(summary["touched"][0]["pair"], (Json{"hubo/Body_LWR", "table"}));
  EXPECT_EQ(summary["planning_time_s"]["mean"], 0.5);
  EXPECT_EQ(summary["planning_time_s"]["max"], 0.75);
  EXPECT_EQ(summary["first_plan_s"]["median"], 0.125);
  EXPECT_EQ(summary["duration_s"]["mean"], 12.5);
  EXPECT_EQ(summary["object_s"]["p95"], 7.0);
  EXPECT_EQ(summary["duration_over_bound"]["max"], 1.25);
  EXPECT_EQ(client::compact(summary["clearance_furniture_m"]),
            R"({"median": 0.012, "min": 0.012})");
  EXPECT_EQ(summary["clearance_robots_m"]["min"], 0.05);
  EXPECT_EQ(summary["grasps_giver_mean"], 10.0);
  EXPECT_EQ(summary["grasps_receiver_mean"], 20.0);
  EXPECT_EQ(summary["handover_poses_mean"], 2.0);
}

TEST(ExperimentFile, IsNullWhereNoRunHasAValue) {
  ExperimentRecord experiment = sampleExperiment();
  experiment.runs.erase(experiment.runs.begin());
  const Json summary = summaryOf(experiment);
  for (const char* key : {"first_plan_s", "duration_s", "object_s", "duration_over_bound",
                          "clearance_furniture_m", "clearance_robots_m", "grasps_giver_mean"}) {
    EXPECT_EQ(summary[key], nullptr) << key;
  }
}

TEST(ExperimentTable, ShowsThePapersBesideOursAndWhatFailed) {
  std::ostringstream out;
  printTable(out, sampleExperiment());
  for (const char* text : {"1 of 2 runs solved", "2.31", "0.5000", "39.77", "10.00", "2.50",
                           "Table II", "hubo/Body_LWR - table", "run 001 failed: no_path (no way)",
                           "run 001 violates: plan t=0 limits: q"}) {
    EXPECT_THAT(out.str(), HasSubstr(text));
  }
  ExperimentRecord other = sampleExperiment();
  other.cell = "elsewhere";
  std::ostringstream without;
  printTable(without, other);
  EXPECT_THAT(without.str(), testing::Not(HasSubstr("paper:")));
}

}  // namespace
}  // namespace handover::ctl
