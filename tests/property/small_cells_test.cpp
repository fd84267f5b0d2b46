// SPDX-License-Identifier: Apache-2.0
// What holds for every answer: the same for the same problem, counts that add up, stages that join,
// an end soon after a cancel.
#include "core/planning/collision_context.hpp"
#include "random_cell.hpp"
#include "support/joined_stages.hpp"
#include "support/plan_text.hpp"
#include "support/property.hpp"
#include "support/recorder.hpp"
#include "support/verified.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <set>
#include <thread>

namespace handover::test {
namespace {

const SmallRobots& robots() {
  static const SmallRobots all;
  return all;
}

TEST(SmallCells, AnswerIsTheSameForTheSameProblemWhateverWasPlannedBetween) {
  int solved = 0;
  const auto result = holds("random cells", 12, [&] {
    const CellDraw draw = *anyCell();
    RandomCell first = makeCell(robots(), draw), again = makeCell(robots(), draw);
    const auto mode = *rc::gen::element(SearchMode::kFirst, SearchMode::kBest, SearchMode::kAll);
    first.problem.mode = again.problem.mode = mode;
    RandomCell other = makeCell(robots(), *anyCell());
    Recorder one, two, between;
    const Outcome outcome = planTransport(first.problem, one, Deadline());
    planTransport(other.problem, between, Deadline());
    RC_ASSERT(planTransport(again.problem, two, Deadline()) == outcome);
    RC_ASSERT(one.events == two.events);
    if (!std::holds_alternative<Done>(outcome)) return;
    ++solved;
    RC_ASSERT(planMember(planText(one.events, outcome)) ==
              planMember(planText(two.events, outcome)));
    again.problem.seed = 77;
    Recorder seeded;
    const Outcome other_seed = planTransport(again.problem, seeded, Deadline());
    if (!std::holds_alternative<Done>(other_seed)) return;
    const auto valid = verified(seeded.events, other_seed, robots().root());
    if (!valid) RC_FAIL(std::string(valid.message()));
  });
  EXPECT_TRUE(result);
  EXPECT_GE(solved, 2);
}

TEST(SmallCells, BestCostsNoMoreThanFirst) {
  int better = 0;
  const auto result = holds("random cells", 12, [&] {
    RandomCell cell = makeCell(robots(), *anyCell());
    cell.problem.objective = *rc::gen::element(Objective::kBalanced, Objective::kTime);
    Recorder first, best;
    cell.problem.mode = SearchMode::kFirst;
    if (!std::holds_alternative<Done>(planTransport(cell.problem, first, Deadline()))) return;
    cell.problem.mode = SearchMode::kBest;
    const Outcome outcome = planTransport(cell.problem, best, Deadline());
    const std::vector<Solution> solutions = best.all<Solution>();
    RC_ASSERT(solutions.front() == first.all<Solution>().front());
    RC_ASSERT(std::get<Done>(outcome).solution + 1 == solutions.size());
    for (std::size_t i = 1; i < solutions.size(); ++i) {
      RC_ASSERT(solutions[i].cost < solutions[i - 1].cost);
    }
    if (solutions.size() > 1) ++better;
    const auto valid = verified(best.events, outcome, robots().root());
    if (!valid) RC_FAIL(std::string(valid.message()));
  });
  EXPECT_TRUE(result);
  EXPECT_GE(better, 2);
}

std::uint32_t total(const std::vector<CauseCount>& causes) {
  std::uint32_t sum = 0;
  for (const CauseCount& cause : causes) {
    EXPECT_NE(cause.cause, Cause::kUnspecified);
    sum += cause.count;
  }
  return sum;
}

std::size_t stageCount(const TransportProblem& problem) {
  return makeStages(transportOf(problem.task, problem.task.chain.size())).size();
}

TEST(SmallCells, FunnelAddsUpAndAgreesWithTheReason) {
  const auto result = holds("random cells", 25, [&] {
    const RandomCell cell = makeCell(robots(), *anyCell());
    Recorder recorder;
    const Outcome outcome = planTransport(cell.problem, recorder, Deadline());
    bool given = false, received = false;
    for (const GraspsPruned& pruned : recorder.all<GraspsPruned>()) {
      RC_ASSERT(pruned.kept + total(pruned.causes) == pruned.tested);
      RC_ASSERT(pruned.arm.robot == (pruned.holder == 0 ? "g" : "r"));
      RC_ASSERT(pruned.place == (pruned.holder == 0 ? PruningPlace::kStart : PruningPlace::kGoal));
      (pruned.holder == 0 ? given : received) |= pruned.kept > 0;
    }
    std::uint32_t tuples = 0;
    for (const HandoverCandidates& candidates : recorder.all<HandoverCandidates>()) {
      RC_ASSERT(candidates.poses <= candidates.poses_tried);
      RC_ASSERT(candidates.tuples >= candidates.poses);
      tuples += candidates.tuples;
    }
    std::set<std::pair<ArmName, ArmName>> arms;
    for (const HandoverCandidates& candidates : recorder.all<HandoverCandidates>()) {
      RC_ASSERT(candidates.handover == 0u);
      const bool first = arms.emplace(candidates.giver, candidates.receiver).second;
      RC_ASSERT(candidates.lattice.size() == (first ? candidates.lattice_points : 0u));
      RC_ASSERT(std::is_sorted(
          candidates.lattice.begin(), candidates.lattice.end(),
          [](const LatticeCell& a, const LatticeCell& b) { return a.score > b.score; }));
      if (!candidates.lattice.empty()) RC_ASSERT(candidates.lattice.back().score > 0);
    }
    const bool done = std::holds_alternative<Done>(outcome);
    RC_ASSERT(recorder.all<Solution>().size() == (done ? 1u : 0u));
    RC_ASSERT(recorder.all<StageTrajectory>().size() == (done ? stageCount(cell.problem) : 0u));
    RC_ASSERT(recorder.all<Outcome>().empty());
    if (done) return;
    const Failed& failed = std::get<Failed>(outcome);
    RC_ASSERT(!failed.explanation.causes.empty());
    RC_ASSERT(total(failed.explanation.causes) > 0u);
    switch (failed.reason) {
      case FailureReason::kNoGraspAtStart:
        RC_ASSERT(!given);
        break;
      case FailureReason::kNoGraspAtGoal:
        RC_ASSERT(given && !received);
        break;
      case FailureReason::kNoCommonWorkspace:
      case FailureReason::kNoHandoverPose:
        RC_ASSERT(given && received && tuples == 0u);
        break;
      case FailureReason::kNoPath:
        RC_ASSERT(given && received && tuples > 0u);
        break;
      default:
        RC_ASSERT(!given && !received);
    }
  });
  EXPECT_TRUE(result);
}

TEST(SmallCells, StagesJoinAndEveryTimeRises) {
  int solved = 0;
  const auto result = holds("random cells", 20, [&] {
    const RandomCell cell = makeCell(robots(), *anyCell());
    Recorder recorder;
    if (!std::holds_alternative<Done>(planTransport(cell.problem, recorder, Deadline()))) return;
    ++solved;
    const auto stages = recorder.all<StageTrajectory>();
    const auto fault = stagesFault(recorder.all<SceneSnapshot>().front(), stages);
    if (fault) RC_FAIL(*fault);
    std::map<std::string, double> ends;  // by robot
    double last = 0, sum = 0;
    for (const StageTrajectory& stage : stages) {
      double& end = ends[stage.robot];
      RC_ASSERT(stage.start > end - 1e-9);
      RC_ASSERT(stage.start < sum + 1e-9);  // never later than one after another
      sum += stage.t.back();
      RC_ASSERT(stage.t.front() == 0.0);
      for (std::size_t i = 1; i < stage.t.size(); ++i) {
        RC_ASSERT(stage.t[i] - stage.t[i - 1] > 1e-3 - 1e-12);
      }
      end = stage.start + stage.t.back();
      last = std::max(last, end);
    }
    RC_ASSERT(last < sum + 1e-9);
  });
  EXPECT_TRUE(result);
  EXPECT_GE(solved, 2);
}

TEST(SmallCells, PlansWithStagesThatOverlapAreVerifiedAtAnySpeed) {
  int overlapping = 0;
  const auto result = holds("random cells", 20, [&] {
    RandomCell cell = makeCell(robots(), *anyCell());
    cell.problem.speed_scale = *rc::gen::element(1.0, 0.7, 0.25);
    Recorder recorder;
    const Outcome outcome = planTransport(cell.problem, recorder, Deadline());
    if (!std::holds_alternative<Done>(outcome)) return;
    double last = 0, sum = 0;
    for (const StageTrajectory& stage : recorder.all<StageTrajectory>()) {
      last = std::max(last, stage.start + stage.t.back());
      sum += stage.t.back();
    }
    if (sum > last + 0.1) ++overlapping;
    const auto valid = verified(recorder.events, outcome, robots().root());
    if (!valid) RC_FAIL(std::string(valid.message()));
  });
  EXPECT_TRUE(result);
  EXPECT_GE(overlapping, 2);
}

TEST(SmallCells, CancelAndDeadlineEndASearchSoon) {
  using Clock = Deadline::Clock;
  const auto result = holds("random cells", 15, [&] {
    RandomCell cell = makeCell(robots(), *anyCell());
    cell.problem.mode = SearchMode::kAll;
    const auto after = std::chrono::microseconds(*rc::gen::inRange(0, 20'000));
    const bool cancel = *rc::gen::arbitrary<bool>();
    const auto begin = Clock::now();
    const Deadline deadline = cancel ? Deadline() : Deadline(begin + after);
    std::jthread canceller;
    if (cancel) {
      canceller = std::jthread([&] {
        std::this_thread::sleep_until(begin + after);
        deadline.cancel();
      });
    }
    Recorder recorder;
    const Outcome outcome = planTransport(cell.problem, recorder, deadline);
    // Some milliseconds in fact; the rest is for a busy machine.
    RC_ASSERT(Clock::now() - begin < after + std::chrono::seconds(2));
    const auto* failed = std::get_if<Failed>(&outcome);
    const bool late = failed != nullptr && failed->reason == FailureReason::kDeadline;
    RC_ASSERT(!(cancel && late));
    RC_ASSERT(!(!cancel && std::holds_alternative<Cancelled>(outcome)));
  });
  EXPECT_TRUE(result);
}

}  // namespace
}  // namespace handover::test
