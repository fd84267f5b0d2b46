// SPDX-License-Identifier: Apache-2.0
#include "core/planning/chain_search.hpp"

#include <gtest/gtest.h>

namespace handover {
namespace {

using enum StageAction;

FailureScope scopeOf(std::uint32_t holder, StageAction action, std::size_t holders,
                     Cause cause = Cause::kNoPath) {
  return failureScope({{holder, action}, cause, {}}, holders);
}

// Chain of three: handover 0 from holder 0 to 1, handover 1 from holder 1 to 2.

TEST(FailureScope, TheFirstCarryDependsOnTheFirstHandoverAndTheGraspGivenWith) {
  EXPECT_EQ(scopeOf(0, kCarry, 3), (FailureScope{0, false}));
}

TEST(FailureScope, AMiddleCarryBeginsAtThePoseOfTheHandoverBefore) {
  EXPECT_EQ(scopeOf(1, kCarry, 3), (FailureScope{0, true}));
}

TEST(FailureScope, NothingBeforeTheLastHandoverMendsTheLastCarry) {
  EXPECT_EQ(scopeOf(2, kCarry, 3), (FailureScope{1, true}));
  EXPECT_EQ(scopeOf(1, kCarry, 2), (FailureScope{0, true}));
}

TEST(FailureScope, ReachAndGraspDependOnTheHandoverThatTheyLeadTo) {
  for (const StageAction action : {kReach, kApproach, kGrasp}) {
    EXPECT_EQ(scopeOf(1, action, 3), (FailureScope{0, false}));
    EXPECT_EQ(scopeOf(2, action, 3), (FailureScope{1, false}));
  }
}

TEST(FailureScope, AGiverLeavesTheHandoverThatItGaveAt) {
  for (const StageAction action : {kRelease, kRetreat, kHome}) {
    EXPECT_EQ(scopeOf(0, action, 3), (FailureScope{0, false}));
    EXPECT_EQ(scopeOf(1, action, 3), (FailureScope{1, false}));
  }
}

TEST(FailureScope, PlacingDependsOnTheLastGraspAlone) {
  for (const std::size_t holders : {1u, 2u, 3u}) {
    const auto last = static_cast<std::uint32_t>(holders - 1);
    EXPECT_TRUE(scopeOf(last, kPlace, holders, Cause::kStraightApproach).ofPlacing(holders));
    // An object that stays in the hand is not put down: the end of the carry itself is not free.
    EXPECT_TRUE(scopeOf(last, kCarry, holders, Cause::kStraightApproach).ofPlacing(holders));
    EXPECT_FALSE(scopeOf(last, kCarry, holders).ofPlacing(holders));
  }
}

}  // namespace
}  // namespace handover
