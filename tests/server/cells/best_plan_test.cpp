// SPDX-License-Identifier: Apache-2.0
// Mode best (design §3, Modes; §7, Objective): the first plan as in mode first, then better ones.
// ask() has the verifier look at each of them.
#include "butler_service.hpp"
#include "support/recorder.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <map>

namespace handover::test {
namespace {

using namespace std::chrono_literals;

Answer planned(SearchMode mode, Objective objective, std::uint64_t seed = 1) {
  PlanRequest request = butlerRequest();
  request.mode = mode;
  request.objective = objective;
  request.seed = seed;
  return ask(request);
}

std::vector<Solution> solutionsOf(const Answer& answer) { return allOf<Solution>(answer.events); }

TEST(BestPlan, BeginsWithTheFirstPlanAndCostsLessEachTime) {
  for (const Objective objective : {Objective::kBalanced, Objective::kTime}) {
    const std::vector<Solution> first = solutionsOf(planned(SearchMode::kFirst, objective));
    const Answer best = planned(SearchMode::kBest, objective);
    const std::vector<Solution> solutions = solutionsOf(best);
    ASSERT_EQ(first.size(), 1u);
    ASSERT_GT(solutions.size(), 1u);
    EXPECT_EQ(solutions[0], first[0]);
    for (std::size_t i = 1; i < solutions.size(); ++i) {
      EXPECT_EQ(solutions[i].index, i);
      EXPECT_LT(solutions[i].cost, solutions[i - 1].cost);
    }
    const Done done = std::get<Done>(best.outcome);
    EXPECT_EQ(done.solution, solutions.back().index);
    EXPECT_TRUE(done.complete);
  }
}

TEST(BestPlan, SendsEveryStageOfEachSolution) {
  const Answer best = planned(SearchMode::kBest, Objective::kBalanced);
  std::map<std::uint32_t, std::uint32_t> stages;
  for (const StageTrajectory& stage : allOf<StageTrajectory>(best.events)) {
    EXPECT_EQ(stage.index, stages[stage.solution]++);
  }
  for (const Solution& solution : solutionsOf(best)) {
    EXPECT_EQ(stages[solution.index], solution.stage_count);
  }
}

TEST(BestPlan, EndsAtADeadlineWithTheBestSoFar) {
  const PlanRequest request = butlerRequest();
  int cut = 0;
  for (const auto patience : {60ms, 90ms, 120ms, 160ms, 220ms, 300ms}) {
    const Answer answer = ask(request, Deadline(Deadline::Clock::now() + patience));
    const auto* done = std::get_if<Done>(&answer.outcome);
    if (done == nullptr) continue;  // too soon for the first
    const std::vector<Solution> solutions = solutionsOf(answer);
    ASSERT_FALSE(solutions.empty());
    EXPECT_EQ(done->solution, solutions.back().index);
    if (!done->complete) ++cut;
  }
  EXPECT_GT(cut, 0);
}

TEST(BestPlan, OfDexterityIsTheMostDexterousPlacing) {
  const std::vector<Solution> solutions =
      solutionsOf(planned(SearchMode::kBest, Objective::kDexterity));
  for (std::size_t i = 1; i < solutions.size(); ++i) {
    EXPECT_GT(solutions[i].holders.back().dexterity.give,
              solutions[i - 1].holders.back().dexterity.give);
  }
}

TEST(BestPlan, CostsTheSumOfItsTerms) {
  const Solution best = solutionsOf(planned(SearchMode::kBest, Objective::kBalanced)).back();
  ASSERT_TRUE(best.quality);
  double sum = 0;
  for (const auto& [name, seconds] : best.quality->terms) {
    EXPECT_GE(seconds, 0) << name;
    sum += seconds;
  }
  EXPECT_NEAR(best.cost, sum, 1e-9);
  EXPECT_EQ(best.quality->terms.front().first, "duration");
  EXPECT_NEAR(best.quality->terms.front().second, best.quality->duration_s, 1e-9);
}

}  // namespace
}  // namespace handover::test
