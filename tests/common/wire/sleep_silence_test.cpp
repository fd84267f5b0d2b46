// SPDX-License-Identifier: Apache-2.0
#include "wire/sleep_silence.hpp"

#include <gtest/gtest.h>

namespace handover::wire {
namespace {

using namespace std::chrono_literals;

TEST(SleepSilence, IsNoneWhileDatagramsGoOut) {
  SleepSilence silence(10s);
  for (auto now = 10s; now < 60s; now += 2s) {
    EXPECT_TRUE(silence.maySend(now));
    EXPECT_TRUE(silence.mayReceive(now + 1s));
  }
}

TEST(SleepSilence, LastsAfterASleepUntilEverybodyForgot) {
  SleepSilence silence(10s);
  // What waited is not taken, whether it is looked at before or after the first to go out.
  EXPECT_FALSE(silence.mayReceive(20s));
  EXPECT_FALSE(silence.maySend(20s));
  EXPECT_FALSE(silence.mayReceive(20s));
  for (auto now = 20s + 200ms; now <= 20s + kParticipantLease; now += 200ms) {
    EXPECT_FALSE(silence.maySend(now));
    EXPECT_FALSE(silence.mayReceive(now));
  }
  EXPECT_TRUE(silence.maySend(24s));
  EXPECT_TRUE(silence.mayReceive(24s));
}

TEST(SleepSilence, FollowsEverySleep) {
  SleepSilence silence(0s);
  EXPECT_FALSE(silence.maySend(10s));
  EXPECT_FALSE(silence.maySend(20s));
  EXPECT_FALSE(silence.maySend(22s));
  EXPECT_TRUE(silence.maySend(24s));
}

TEST(SleepSilence, CountsTimeForward) {
  const auto before = SleepSilence::sinceBoot();
  EXPECT_GT(before, 0s);
  EXPECT_GE(SleepSilence::sinceBoot(), before);
}

}  // namespace
}  // namespace handover::wire
