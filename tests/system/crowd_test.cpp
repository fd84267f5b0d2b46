// SPDX-License-Identifier: Apache-2.0
// Many programs one after the other, each for one question. HANDOVER_CROWD: how many.
#include "process.hpp"

#include <gtest/gtest.h>
#include <signal.h>

#include <atomic>
#include <cstdlib>
#include <thread>

namespace handover::test {
namespace {

TEST(Crowd, OfShortLivedClientsIsAnswered) {
  const char* wanted = std::getenv("HANDOVER_CROWD");
  const int clients = wanted == nullptr ? 400 : std::atoi(wanted);
  const std::string domain = std::to_string(freeDomain());
  Process daemon{{HANDOVER_BINARY_DIR "/tests/scripted_daemon", domain}};
  ASSERT_TRUE(daemon.waitForOutput("serving"));

  const std::string ctl = HANDOVER_BINARY_DIR "/bin/handoverctl";
  const std::vector<std::string> plan{ctl,      "plan",     "--cell", "script", "--task",
                                      "answer", "--domain", domain,   "--wait", "30"};
  const std::vector<std::string> status{ctl, "status", "--domain", domain, "--wait", "30"};
  std::atomic<int> next = 0, failed = 0;
  const auto ask = [&] {
    for (int i = next++; i < clients; i = next++) {
      const Finished finished = run(i % 2 == 0 ? plan : status, {}, 60s);
      if (finished.status != 0 && failed++ == 0) ADD_FAILURE() << finished.err;
    }
  };
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 8; ++i) threads.emplace_back(ask);
  }
  EXPECT_EQ(failed, 0);
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(5s), 0);
}

}  // namespace
}  // namespace handover::test
