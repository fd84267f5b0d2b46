// SPDX-License-Identifier: Apache-2.0
// A daemon does not grow: mixed requests by clients that cancel, fail and die.
// HANDOVER_MEMORY_REQUESTS: how many (default: 1000). With more than a thousand, what the daemon
// has after all is held against what it had after the first thousand, each time once it has nothing
// to keep for anybody: before, it holds up to 8 MB of answers that may be asked for again, more or
// less by chance.
#include "process.hpp"

#include <handover/client/client.hpp>

#include <gtest/gtest.h>
#include <signal.h>

#include <cstdlib>
#include <iostream>
#include <thread>

namespace handover::test {
namespace {

using client::Client;

const std::string kBin = HANDOVER_BINARY_DIR "/bin/";

constexpr int kStep = 1000;
/// Answers are kept for a minute; memory is given back within seconds then.
constexpr auto kAllForgotten = 75s;
constexpr std::uint64_t kMostBytes = 150'000'000;

int requestCount() {
  const char* given = std::getenv("HANDOVER_MEMORY_REQUESTS");
  return given == nullptr ? 1000 : std::atoi(given);
}

class Memory : public testing::Test {
 protected:
  const int domain = freeDomain();
  const std::string at_domain = " --domain " + std::to_string(domain);
  Process daemon{
      words(kBin + "handoverd serve --cell butler --root " HANDOVER_SOURCE_DIR + at_domain),
      {"XDG_CACHE_HOME=" HANDOVER_BINARY_DIR "/test-cache"}};

  /// The least of some seconds, once it is quiet: memory is given back then.
  std::uint64_t residentBytes(Client& client) const {
    std::uint64_t least = UINT64_MAX;
    const auto until = std::chrono::steady_clock::now() + 8s;
    while (std::chrono::steady_clock::now() < until) {
      std::this_thread::sleep_for(100ms);  // of one look to the next
      for (const DaemonStatus& status : client.daemons()) {
        if (status.queued + status.running == 0) least = std::min(least, status.memory_bytes);
      }
    }
    return least;
  }

  std::uint64_t settledBytes(Client& client) const {
    std::this_thread::sleep_for(kAllForgotten);
    const std::uint64_t bytes = residentBytes(client);
    std::cout << "settled: " << megabytes(bytes) << " MB" << std::endl;
    return bytes;
  }

  static double megabytes(std::uint64_t bytes) { return static_cast<double>(bytes / 100'000) / 10; }

  /// The i-th of the mix: plans, failures, changed scenes.
  static PlanRequest mixed(int i) {
    PlanRequest request;
    request.cell = "butler";
    request.mode = SearchMode::kFirst;
    request.seed = static_cast<std::uint64_t>(i);
    request.wants_fix = false;
    if (i % 10 == 3) request.overrides = {{"robots.hubo.base.xyz", "[6, 0, 0.98]"}};
    if (i % 10 == 6) request.overrides = {{"robots.hubo.bass.xyz", "[6, 0, 0.98]"}};
    if (i % 10 == 8) {
      const std::string y = std::to_string(0.001 * (i % 400) - 0.2);
      request.overrides = {{"robots.hubo.base.xyz", "[1.18, " + y + ", 0.98]"}};
    }
    return request;
  }

  void ask(Client& client, int i) const {
    if (i % 100 == 50) {  // a client that dies
      Process dying(words(kBin + "handoverctl plan --cell butler --wait 20" + at_domain));
      dying.waitForOutput("arms");
      dying.signal(SIGKILL);
      dying.wait();
      return;
    }
    const auto handle = client.plan(mixed(i));
    if (i % 7 == 5) handle.cancel();
    ASSERT_TRUE(handle.waitFor(30s)) << "request " << i;
    handle.wait();
  }
};

TEST_F(Memory, StaysAsItIsUnderMixedRequests) {
  Client client({.domain = domain, .client_id = {}, .wait = 60s});
  const int all = requestCount();
  const bool compares = all > kStep;
  std::uint64_t first = 0, last = 0;
  for (int i = 1; i <= all; ++i) {
    ASSERT_NO_FATAL_FAILURE(ask(client, i - 1)) << daemon.err();
    if (i % kStep != 0) continue;
    last = residentBytes(client);
    std::cout << "resident after " << i << ": " << megabytes(last) << " MB" << std::endl;
    EXPECT_LT(last, kMostBytes);
    if (i == kStep && compares) first = settledBytes(client);
  }
  if (compares) {
    EXPECT_LT(settledBytes(client), first + first / 10);
  }
  EXPECT_GT(last, 0u);
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(5s), 0);
}

}  // namespace
}  // namespace handover::test
