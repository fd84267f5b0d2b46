// SPDX-License-Identifier: Apache-2.0
// No client holds up another, whatever it does or does not do.
#include "bare_client.hpp"
#include "wire/codec.hpp"
#include "wire/entities.hpp"
#include "wire_daemon.hpp"

#include <handover/client/client.hpp>

#include <gmock/gmock.h>
#include <signal.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <string>
#include <thread>

namespace handover::test {
namespace {

using client::Client;

/// Reads the events of everybody and takes none.
class SleepingReader {
 public:
  explicit SleepingReader(int domain)
      : process_({HANDOVER_BINARY_DIR "/tests/sleeping_reader", std::to_string(domain)}) {
    EXPECT_TRUE(process_.waitForOutput("reading"));
  }

 private:
  Process process_;
};

class ClientStreams : public WireDaemonTest {
 protected:
  /// Plans again and again; the time below which 19 of 20 answers came [s].
  double mostTake(Client& client, int plans) {
    std::vector<double> seconds;
    for (int i = 0; i < plans; ++i) {
      const auto handle = client.plan(scripted("answer"));
      EXPECT_TRUE(handle.waitFor(20s));
      EXPECT_TRUE(std::holds_alternative<Done>(handle.wait()));
      seconds.push_back(handle.answerTime().count());
    }
    std::sort(seconds.begin(), seconds.end());
    return seconds[static_cast<std::size_t>(plans) * 19 / 20];
  }

  static bool holdsWithin(std::chrono::seconds most, const std::function<bool()>& test) {
    const auto until = std::chrono::steady_clock::now() + most;
    while (!test() && std::chrono::steady_clock::now() < until) std::this_thread::sleep_for(5ms);
    return test();
  }

  DaemonStatus status() {
    Client client({.domain = domain, .client_id = {}, .wait = 20s});
    return client.daemons().at(0);
  }
};

TEST_F(ClientStreams, GoOnToAnotherWriterWhenOneIsFull) {
  start();
  Client client({.domain = domain, .client_id = "often", .wait = 20s});
  EXPECT_LT(mostTake(client, 3 * wire::kAnswersPerWriter), 0.5);
}

TEST_F(ClientStreams, AreNotHeldUpByAReaderThatDoesNotTake) {
  start();
  const SleepingReader reader(domain);
  Client client({.domain = domain, .client_id = "healthy", .wait = 20s});
  EXPECT_LT(mostTake(client, 2 * wire::kAnswersPerWriter), 0.5);
}

TEST_F(ClientStreams, EndAnAnswerThatIsTooLongForAReaderThatDoesNotTake) {
  start();
  const SleepingReader reader(domain);
  Client client({.domain = domain, .client_id = "talks", .wait = 20s});
  bool restarted = false;
  const auto handle = client.plan(scripted("talk"), {}, [&] { restarted = true; });
  ASSERT_TRUE(handle.waitFor(20s));
  const Outcome outcome = handle.wait();
  ASSERT_TRUE(std::holds_alternative<Failed>(outcome));
  EXPECT_EQ(std::get<Failed>(outcome).reason, FailureReason::kInternal);
  EXPECT_TRUE(restarted);
  EXPECT_LT(mostTake(client, 3), 5);
}

TEST_F(ClientStreams, GoOnForAClientWhoseAnswerWasGivenUp) {
  start();
  Client client({.domain = domain, .client_id = "slow", .wait = 20s});
  {
    const SleepingReader sleeping(domain);
    EXPECT_TRUE(std::holds_alternative<Failed>(client.plan(scripted("talk")).wait()));
    EXPECT_TRUE(std::holds_alternative<Done>(client.plan(scripted("answer")).wait()));
  }
  // As does one that comes later by the same name.
  Client again({.domain = domain, .client_id = "slow", .wait = 20s});
  for (Client* each : {&client, &again}) {
    EXPECT_TRUE(std::holds_alternative<Done>(each->plan(scripted("answer")).wait()));
  }
}

TEST_F(ClientStreams, AreNoneForRequestsOfAnotherDaemonsCell) {
  start();
  wire::Participant other({.domain = domain, .name = "other", .on_writer = {}});
  wire::Writer<msg::DaemonStatus> statuses(other, {});
  DaemonStatus elsewhere{.id = RequestId::random().bytes, .version = "test"};
  elsewhere.state = DaemonState::kReady;
  elsewhere.cells = {{"elsewhere", {"answer"}, 1, {}, ""}};
  ASSERT_EQ(statuses.write(wire::encode(elsewhere)), wire::WriteResult::kOk);
  ASSERT_TRUE(holdsWithin(20s, [&] { return endpoint->others().size() == 1; }));
  BareClient bare(domain, "client-0");
  for (int i = 0; i < 300; ++i) {
    auto request = scripted("answer");
    request.client_id = "client-" + std::to_string(i);
    request.cell = "elsewhere";
    bare.send(wire::encode(request));
  }
  auto request = scripted("answer");
  request.client_id = "client-0";
  bare.send(wire::encode(request));
  EXPECT_EQ(bare.outcome(), (Outcome{Done{1, true}}));
  // It itself, and what asks for the status.
  Client client({.domain = domain, .client_id = {}, .wait = 20s});
  for (const DaemonStatus& daemon : client.daemons()) EXPECT_LE(daemon.clients, 3u);
}

TEST_F(ClientStreams, AreMadeAheadForAFewOnly) {
  start();
  wire::Participant squatter({.domain = domain, .name = "squatter", .on_writer = {}});
  std::deque<wire::Writer<msg::HandoverRequest>> writers;
  for (int i = 0; i < 300; ++i) {
    writers.emplace_back(squatter, wire::EntityOptions{.user_data = "squat-" + std::to_string(i)});
  }
  Client client({.domain = domain, .client_id = {}, .wait = 20s});
  EXPECT_LT(mostTake(client, 3), 5);
  EXPECT_LE(status().clients, 66u);
}

TEST_F(ClientStreams, EndARequestOfAClientThatSleptUntilItsAnswerWasForgotten) {
  start({}, {.retention = 1s});
  Process plan({HANDOVER_BINARY_DIR "/bin/handoverctl", "plan", "--cell", "script", "--task",
                "hold", "--domain", std::to_string(domain)});
  ASSERT_TRUE(plan.waitForOutput("arms"));
  plan.signal(SIGSTOP);
  // Its lease of 3 s ends, which cancels the request; the retention, and with it the answer.
  EXPECT_TRUE(holdsWithin(20s, [&] { return status().counters.cancelled == 1; }));
  std::this_thread::sleep_for(3s);
  plan.signal(SIGCONT);
  const auto code = plan.wait(60s);
  ASSERT_TRUE(code) << "still waits";
  EXPECT_TRUE(*code == 11 || *code == 12 || *code == 13) << *code << plan.err();
}

TEST_F(ClientStreams, RejectAnIdThatIsBeingAnsweredToAnotherClient) {
  start();
  Client one({.domain = domain, .client_id = "one", .wait = 20s});
  Client two({.domain = domain, .client_id = "two", .wait = 20s});
  const auto request = scripted("hold");
  const auto held = one.plan(request);
  const auto again = two.plan(request);
  ASSERT_TRUE(again.waitFor(20s));
  const Outcome outcome = again.wait();
  ASSERT_TRUE(std::holds_alternative<Rejected>(outcome));
  EXPECT_EQ(std::get<Rejected>(outcome).reason, RejectionReason::kAlreadyAnswered);
  held.cancel();
  EXPECT_EQ(held.wait(), Outcome{Cancelled{CancelCause::kAsked}});
}

}  // namespace
}  // namespace handover::test
