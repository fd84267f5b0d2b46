// SPDX-License-Identifier: Apache-2.0
#include "core/planning/cause_tally.hpp"

#include <gtest/gtest.h>

namespace handover {
namespace {

TEST(CauseTally, SortsByCountAndSumsUpPairsBeyondTheLimit) {
  CauseTally tally;
  tally.add(Cause::kNoIk, 4);
  for (int i = 0; i < 7; ++i) {
    tally.add(Cause::kCollision, {"b" + std::to_string(i), "a"},
              static_cast<std::uint32_t>(10 + i));
  }
  const auto counts = tally.counts(5);
  ASSERT_EQ(counts.size(), 7u);
  EXPECT_EQ(counts[0].pair, NamePair("a", "b6"));
  EXPECT_EQ(counts[5].cause, Cause::kNoIk);
  EXPECT_EQ(counts.back().cause, Cause::kCollision);
  EXPECT_EQ(counts.back().count, 21u);  // 10 + 11, beyond the five most frequent
  EXPECT_EQ(counts.back().pair, NamePair());
  EXPECT_EQ(tally.total(), 4u + 10 + 11 + 12 + 13 + 14 + 15 + 16);
}

TEST(CauseTally, CountsAPairInEitherOrderAsOne) {
  CauseTally tally;
  tally.add(Cause::kCollision, {"a", "b"});
  tally.add(Cause::kCollision, {"b", "a"});
  ASSERT_EQ(tally.counts().size(), 1u);
  EXPECT_EQ(tally.counts()[0].count, 2u);
}

TEST(CauseTally, PutsTheOneThingOfAPairFirst) {
  CauseTally tally;
  tally.add(Cause::kHoldsObject, {"hubo/left", ""});
  tally.add(Cause::kHoldsObject, {"", "hubo/left"});
  ASSERT_EQ(tally.counts().size(), 1u);
  EXPECT_EQ(tally.counts()[0].pair, NamePair("hubo/left", ""));
}

TEST(CauseTally, KeepsStagesApart) {
  CauseTally tally;
  tally.add(Cause::kNoPath, StageRef{0, StageAction::kCarry});
  tally.add(Cause::kNoPath, StageRef{1, StageAction::kCarry});
  tally.add(Cause::kNoPath, StageRef{1, StageAction::kCarry});
  const auto counts = tally.counts();
  ASSERT_EQ(counts.size(), 2u);
  EXPECT_EQ(counts[0].count, 2u);
  EXPECT_EQ(counts[0].stage, (StageRef{1, StageAction::kCarry}));
}

}  // namespace
}  // namespace handover
