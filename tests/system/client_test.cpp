// SPDX-License-Identifier: Apache-2.0
// The client library with a daemon in another process: within one, Fast DDS takes short cuts.
#include "process.hpp"

#include <handover/client/client.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace handover::test {
namespace {

using client::Client;

class ClientOfAnotherProcess : public testing::Test {
 protected:
  const int domain_ = freeDomain();
  Process daemon_{{HANDOVER_BINARY_DIR "/tests/scripted_daemon", std::to_string(domain_)}};
  Client client_{{.domain = domain_, .client_id = {}, .wait = 20s}};

  static PlanRequest scripted(const std::string& task) {
    PlanRequest request;
    request.cell = "script";
    request.task = task;
    return request;
  }
};

TEST_F(ClientOfAnotherProcess, IsAnsweredAgainAndAgain) {
  for (int i = 0; i < 20; ++i) {
    int events = 0;
    const auto handle = client_.plan(scripted("answer"), [&events](const PlanEvent&) { ++events; });
    ASSERT_TRUE(handle.waitFor(20s)) << "request " << i;
    EXPECT_TRUE(std::holds_alternative<Done>(handle.wait()));
    EXPECT_EQ(events, 40);
  }
}

TEST_F(ClientOfAnotherProcess, WaitsForNoHeartbeatHoweverOftenItAsks) {
  // More requests than the daemon keeps answers of.
  std::vector<double> seconds;
  for (int i = 0; i < 200; ++i) {
    const auto handle = client_.plan(scripted("fail"));
    ASSERT_TRUE(handle.waitFor(20s)) << "request " << i;
    if (i >= 140) seconds.push_back(handle.answerTime().count());
  }
  std::sort(seconds.begin(), seconds.end());
  EXPECT_LT(seconds[seconds.size() / 2], 0.05);  // the heartbeat's period is 0.1; usual is 0.0003
}

TEST_F(ClientOfAnotherProcess, CanCancelWhatWasTakenThoughInterrupted) {
  for (int i = 0; i < 8; ++i) {
    Client client({.domain = domain_, .client_id = {}, .wait = 20s});
    const auto handle =
        client.plan(scripted("hold"), [&client](const PlanEvent&) { client.interrupt(); });
    handle.cancel();
    ASSERT_TRUE(handle.waitFor(20s));
    EXPECT_TRUE(std::holds_alternative<Cancelled>(handle.wait()));
  }
}

TEST_F(ClientOfAnotherProcess, SendsEveryOptionOfItsRequest) {
  PlanRequest request = scripted("echo");
  request.chain = {"crichton/left", "hubo"};
  request.objective = Objective::kDexterity;
  request.slack_s = 0.5;
  request.wants_fix = false;
  const Outcome outcome = client_.plan(request).wait();
  ASSERT_TRUE(std::holds_alternative<Rejected>(outcome));
  const std::vector<Fault> echoed{{"chain", "crichton/left,hubo"},
                                  {"objective", "dexterity"},
                                  {"slack_s", "0.500000"},
                                  {"wants_fix", "false"}};
  EXPECT_EQ(std::get<Rejected>(outcome).faults, echoed);
}

TEST_F(ClientOfAnotherProcess, IsAnsweredAfterACancel) {
  const auto held = client_.plan(scripted("hold"));
  held.cancel();
  ASSERT_TRUE(held.waitFor(20s));
  EXPECT_EQ(held.wait(), Outcome{Cancelled{CancelCause::kAsked}});
  const auto next = client_.plan(scripted("answer"));
  ASSERT_TRUE(next.waitFor(20s));
  EXPECT_TRUE(std::holds_alternative<Done>(next.wait()));
}

}  // namespace
}  // namespace handover::test
