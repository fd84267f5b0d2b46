// SPDX-License-Identifier: Apache-2.0
#include "dds/self_check.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <future>

namespace handover {
namespace {

using namespace std::chrono_literals;

TEST(SelfCheck, FeedsTheWatchdogWhileItIsHeard) {
  std::atomic<int> fed = 0;
  std::promise<void> thrice;
  const SelfCheck check({.probe = [] { return true; },
                         .on_alive =
                             [&] {
                               if (++fed == 3) thrice.set_value();
                             },
                         .period = 1ms});
  EXPECT_EQ(thrice.get_future().wait_for(20s), std::future_status::ready);
}

TEST(SelfCheck, SaysOnceThatItIsDeafAndFeedsNothing) {
  std::atomic<int> fed = 0, probes = 0;
  std::promise<void> deaf;  // a second time would throw
  const SelfCheck check({.probe = [&] { return ++probes < 0; },
                         .on_alive = [&] { ++fed; },
                         .on_deaf = [&] { deaf.set_value(); },
                         .period = 1ms,
                         .patience = 20ms});
  EXPECT_EQ(deaf.get_future().wait_for(20s), std::future_status::ready);
  EXPECT_GT(probes, 1);
  EXPECT_EQ(fed, 0);
}

TEST(SelfCheck, IsPatientWithAProbeThatIsLost) {
  std::atomic<int> probes = 0, deaf = 0;
  std::promise<void> heard;
  const SelfCheck check({.probe = [&] { return ++probes == 3; },
                         .on_alive = [&] { heard.set_value(); },
                         .on_deaf = [&] { ++deaf; },
                         .period = 1ms,
                         .patience = 20s});
  EXPECT_EQ(heard.get_future().wait_for(20s), std::future_status::ready);
  EXPECT_EQ(deaf, 0);
}

}  // namespace
}  // namespace handover
