// SPDX-License-Identifier: Apache-2.0
// What `wide` calls impossible is impossible, and what it solves is valid: random small cells,
// against brute force and the verifier.
#include "brute_force.hpp"
#include "support/property.hpp"
#include "support/recorder.hpp"
#include "support/verified.hpp"

#include <gtest/gtest.h>

#include <iostream>
#include <map>

namespace handover::test {
namespace {

const SmallRobots& robots() {
  static const SmallRobots all;
  return all;
}

/// A search that had to stop before it had looked at everything says so, and claims no more; that
/// there is no place in reach of both is held to be true all the same.
bool claimsAll(const Failed& failed) {
  EXPECT_FALSE(failed.reason == FailureReason::kNoPath && failed.explanation.exhaustive);
  return failed.explanation.exhaustive || failed.reason == FailureReason::kNoCommonWorkspace;
}

/// What is wrong with the answer for a cell, if anything; counts the kind of answer.
std::optional<std::string> faultOf(const CellDraw& draw, std::map<std::string, int>& answers) {
  const RandomCell cell = makeCell(robots(), draw);
  Recorder recorder;
  const Outcome outcome = planTransport(cell.problem, recorder, Deadline());
  if (std::holds_alternative<Done>(outcome)) {
    ++answers["done"];
    const auto valid = verified(recorder.stages, outcome, robots().root());
    if (!valid) return valid.message();
    return std::nullopt;
  }
  const auto* failed = std::get_if<Failed>(&outcome);
  if (failed == nullptr) return "outcome " + std::to_string(outcome.index());
  const std::string claim = toString(failed->reason);
  if (!claimsAll(*failed)) {
    ++answers["not found"];
    return std::nullopt;
  }
  ++answers[claim];
  const auto witness = BruteForce(cell).against(failed->reason);
  if (witness) return claim + ", but " + *witness;
  return std::nullopt;
}

TEST(Wide, ImpossibleIsImpossibleAndSolvedIsValid) {
  std::map<std::string, int> answers;
  int held = 0;
  const auto result = holds("random cells", 40, [&] {
    const CellDraw draw = *anyCell();
    const int done = answers["done"];
    const auto fault = faultOf(draw, answers);
    if (draw.hold && answers["done"] > done) ++held;
    if (fault) RC_FAIL(*fault);
  });
  EXPECT_TRUE(result);
  // The draws are of use only while they meet plans and every kind of claim.
  EXPECT_GE(answers["done"], 5);
  EXPECT_GE(answers.size(), 5u);
  EXPECT_GE(held, 2);
  for (const auto& [answer, count] : answers) std::cout << answer << ": " << count << '\n';
}

/// Cells that were answered wrongly once, and one where a hold 5 mm beside its place would be.
class WideOnce : public testing::TestWithParam<CellDraw> {};

TEST_P(WideOnce, Holds) {
  std::map<std::string, int> answers;
  const auto fault = faultOf(GetParam(), answers);
  EXPECT_FALSE(fault.has_value()) << *fault;
}

INSTANTIATE_TEST_SUITE_P(
    Kept, WideOnce,
    testing::Values(
        CellDraw{RobotKind::kSevenAxes, RobotKind::kGantry, 0, 0, 3, 0, false, 1300900158},
        CellDraw{RobotKind::kSevenAxes, RobotKind::kGantry, 1, 0, 8, 0, false, 48267810},
        CellDraw{RobotKind::kGantry, RobotKind::kSevenAxes, 0, 0, 6, 1, false, 281132655},
        CellDraw{RobotKind::kSevenAxes, RobotKind::kSevenAxes, 0, 0, 5, 1, true, 1323156248}));

/// The same cell answered by both widths: wide begins with the paper's candidates.
TEST(Wide, SolvesWhatThePaperSolvesInTheSameWay) {
  int solved = 0;
  const auto result = holds("random cells", 40, [&] {
    RandomCell cell = makeCell(robots(), *anyCell());
    cell.problem.search = SearchWidth::kPaper;
    Recorder paper;
    if (!std::holds_alternative<Done>(planTransport(cell.problem, paper, Deadline()))) return;
    ++solved;
    cell.problem.search = SearchWidth::kWide;
    Recorder wide;
    RC_ASSERT(std::holds_alternative<Done>(planTransport(cell.problem, wide, Deadline())));
    RC_ASSERT(wide.all<Solution>() == paper.all<Solution>());
    RC_ASSERT(wide.all<StageTrajectory>() == paper.all<StageTrajectory>());
  });
  EXPECT_TRUE(result);
  EXPECT_GE(solved, 2);
}

}  // namespace
}  // namespace handover::test
