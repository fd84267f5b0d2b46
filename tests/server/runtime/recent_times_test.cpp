// SPDX-License-Identifier: Apache-2.0
#include "runtime/recent_times.hpp"

#include <gtest/gtest.h>

namespace handover {
namespace {

TEST(RecentTimes, AreNoneBeforeTheFirst) { EXPECT_EQ(RecentTimes().summary(), std::nullopt); }

TEST(RecentTimes, AreOfTheLastOnly) {
  RecentTimes times;
  for (int i = 0; i < 1000; ++i) times.add(100);
  for (int i = 256; i > 0; --i) times.add(1e-3 * i);
  const auto summary = times.summary();
  ASSERT_TRUE(summary);
  EXPECT_DOUBLE_EQ(summary->median_ms, 128);
  EXPECT_DOUBLE_EQ(summary->p95_ms, 243);
}

}  // namespace
}  // namespace handover
