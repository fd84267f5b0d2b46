// SPDX-License-Identifier: Apache-2.0
#include "experiment_file.hpp"

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

TEST(Funnel, CountsTheArmsOfTheSolution) {
  Funnel funnel;
  for (const PlanEvent& stage : test::sampleAnswer(RequestId::random())) funnel.add(stage);
  const auto counts = funnel.counts();
  EXPECT_EQ(counts.grasps_giver, 0u);  // the sample prunes the receiver's only
  EXPECT_EQ(counts.grasps_receiver, 40u);
  EXPECT_EQ(counts.handover_poses, 17u);
  EXPECT_EQ(counts.tuples, 300u);
}

TEST(Funnel, CountsTheArmsSelectedWhenThereIsNoSolution) {
  Funnel funnel;
  const auto add = [&funnel](PlanEventPayload payload) {
    funnel.add(PlanEvent{RequestId{}, 0, 0, std::move(payload)});
  };
  add(test::sampleScene());
  add(ArmSelected{"right", "left", {}});
  add(GraspsPruned{"crichton", "right", 316, 31, {}});
  add(GraspsPruned{"crichton", "left", 316, 99, {}});
  add(GraspsPruned{"hubo", "left", 368, 7, {}});
  add(HandoverCandidates{"right", "left", 5, 7, 2, 9, {}, {}});
  add(HandoverCandidates{"left", "left", 5, 7, 70, 90, {}, {}});
  const auto counts = funnel.counts();
  EXPECT_EQ(counts.grasps_giver, 31u);
  EXPECT_EQ(counts.grasps_receiver, 7u);
  EXPECT_EQ(counts.handover_poses, 2u);
  EXPECT_EQ(counts.tuples, 9u);
}

TEST(Funnel, KeepsTheCrossedMapsOfTheArmsAndTheFinalSolution) {
  Funnel funnel;
  EXPECT_EQ(funnel.chosen(), nullptr);
  const auto add = [&funnel](PlanEventPayload payload) {
    funnel.add(PlanEvent{RequestId{}, 0, 0, std::move(payload)});
  };
  const std::vector<LatticeCell> cells = {{{0.5, 0, 1}, 0.4}, {{0.55, 0, 1}, 0.3}};
  add(HandoverCandidates{"left", "left", 9, 9, 9, 9, {}, {{{2, 2, 2}, 1}}});
  add(HandoverCandidates{"right", "left", 2, 7, 0, 0, {}, cells});
  add(HandoverCandidates{"right", "left", 2, 70, 5, 9, {}, {}});  // widened: the same cells
  Solution first{.index = 0, .giver_arm = "right", .receiver_arm = "left"};
  first.X_WO_handover.xyz = {1, 2, 3};
  Solution second = first;
  second.index = 1;
  add(first);
  add(second);
  EXPECT_EQ(funnel.lattice(), cells);
  EXPECT_EQ(funnel.chosen(), nullptr);
  add(Outcome{Done{0, true}});
  ASSERT_NE(funnel.chosen(), nullptr);
  EXPECT_EQ(*funnel.chosen(), first);
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
  solved.counts = {10, 20, 4, 40};
  RunRecord failed;
  failed.index = 1;
  failed.seed = 2;
  failed.outcome = "failed";
  failed.reason = "no_path";
  failed.explanation = "no way";
  failed.planning_time_s = 0.75;
  failed.violations = {{"plan t=0 limits: q"}};
  experiment.runs = {solved, failed};
  return experiment;
}

TEST(ExperimentFile, HoldsWhatItsFormatSays) {
  const Json file = toJson(sampleExperiment());
  EXPECT_EQ(file["format"], "handover-experiment/1");
  for (const char* key : {"cell", "seed", "mode", "search", "stretch", "machine"}) {
    EXPECT_TRUE(file.contains(key)) << key;
  }
  ASSERT_EQ(file["records"].size(), 2u);
  for (const Json& record : file["records"]) {
    for (const char* key :
         {"index", "drawn", "redrawn", "outcome", "reason", "planning_time_s", "first_plan_s",
          "grasps_giver", "grasps_receiver", "handover_poses", "tuples"}) {
      EXPECT_TRUE(record.contains(key)) << key;
    }
  }
  EXPECT_FALSE(file["records"][0].contains("lattice"));  // of the page alone
  EXPECT_FALSE(file["records"][0].contains("handover"));
  EXPECT_EQ(file["records"][0]["reason"], nullptr);
  EXPECT_EQ(file["records"][1]["first_plan_s"], nullptr);
  const Json& summary = file["summary"];
  EXPECT_EQ(summary["runs"], 2);
  EXPECT_EQ(summary["solved"], 1);
  EXPECT_EQ(summary["redrawn"], 1);
  EXPECT_EQ(summary["touched"][0]["pair"], (Json{"hubo/Body_LWR", "table"}));
  EXPECT_EQ(summary["planning_time_s"]["mean"], 0.5);
  EXPECT_EQ(summary["planning_time_s"]["max"], 0.75);
  EXPECT_EQ(summary["first_plan_s"]["median"], 0.125);
  EXPECT_EQ(summary["grasps_giver_mean"], 5.0);
  EXPECT_EQ(summary["grasps_receiver_mean"], 10.0);
  EXPECT_EQ(summary["handover_poses_mean"], 2.0);
}

TEST(ExperimentTable, ShowsThePapersBesideOursAndWhatFailed) {
  std::ostringstream out;
  printTable(out, sampleExperiment());
  for (const char* text : {"1 of 2 runs solved", "2.31", "0.5000", "39.77", "10.00", "Table II",
                           "hubo/Body_LWR - table", "run 001 failed: no_path (no way)",
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
