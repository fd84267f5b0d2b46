// SPDX-License-Identifier: Apache-2.0
#include "core/planning/reject_tally.hpp"

#include <gtest/gtest.h>

namespace handover {
namespace {

TEST(RejectTally, SortsByCountAndSumsUpPairsBeyondTheLimit) {
  RejectTally tally;
  tally.add("no_ik", 4);
  for (int i = 0; i < 7; ++i) {
    tally.add("collision", {"b" + std::to_string(i), "a"}, static_cast<std::uint32_t>(10 + i));
  }
  const auto counts = tally.counts(5);
  ASSERT_EQ(counts.size(), 7u);
  EXPECT_EQ(counts[0].cause, "collision");
  EXPECT_EQ(counts[0].count, 21u);  // 10 + 11, beyond the five most frequent
  EXPECT_EQ(counts[0].pair, NamePair());
  EXPECT_EQ(counts[1].pair, NamePair("a", "b6"));
  EXPECT_EQ(counts.back().cause, "no_ik");
  EXPECT_EQ(tally.total(), 4u + 10 + 11 + 12 + 13 + 14 + 15 + 16);
}

TEST(RejectTally, CountsAPairInEitherOrderAsOne) {
  RejectTally tally;
  tally.add("collision", {"a", "b"});
  tally.add("collision", {"b", "a"});
  ASSERT_EQ(tally.counts().size(), 1u);
  EXPECT_EQ(tally.counts()[0].count, 2u);
}

}  // namespace
}  // namespace handover
