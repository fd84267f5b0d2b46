// SPDX-License-Identifier: Apache-2.0
// No client holds up another, whatever it does or does not do.
#include "bare_client.hpp"
#include "wire/codec.hpp"
#include "wire/entities.hpp"
#include "wire_daemon.hpp"

#include <handover/client/client.hpp>

#include <gmock/gmock.h>

#include <algorithm>
#include <deque>
#include <latch>

namespace handover::test {
namespace {

using client::Client;

/// Reads the events of everybody and never returns from the first one until the test does.
class DeadlyReader {
 public:
  explicit DeadlyReader(int domain)
      : participant_({.domain = domain, .name = "reader", .on_writer = {}}),
        reader_(participant_, {.partition = "*"}, [this](const auto&) { end_.wait(); }) {}

  ~DeadlyReader() { end_.count_down(); }

 private:
  std::latch end_{1};
  wire::Participant participant_;
  wire::Reader<msg::PlanEvent> reader_;
};

class ClientStreams : public WireDaemonTest {
 protected:
  /// Plans again and again; the slowest answer's time [s].
  double slowest(Client& client, int plans) {
    double most = 0;
    for (int i = 0; i < plans; ++i) {
      const auto handle = client.plan(scripted("answer"));
      EXPECT_TRUE(handle.waitFor(20s));
      EXPECT_TRUE(std::holds_alternative<Done>(handle.wait()));
      most = std::max(most, handle.answerTime().count());
    }
    return most;
  }

  DaemonStatus status() {
    Client client({.domain = domain, .client_id = {}, .wait = 20s});
    return client.daemons().at(0);
  }
};

TEST_F(ClientStreams, GoOnToAnotherWriterWhenOneIsFull) {
  start();
  Client client({.domain = domain, .client_id = "often", .wait = 20s});
  EXPECT_LT(slowest(client, 3 * wire::kAnswersPerWriter), 0.5);
}

TEST_F(ClientStreams, AreNotHeldUpByAReaderThatDoesNotTake) {
  start();
  const DeadlyReader reader(domain);
  Client client({.domain = domain, .client_id = "healthy", .wait = 20s});
  EXPECT_LT(slowest(client, 2 * wire::kAnswersPerWriter), 0.5);
}

TEST_F(ClientStreams, EndAnAnswerThatIsTooLongForAReaderThatDoesNotTake) {
  start();
  const DeadlyReader reader(domain);
  Client client({.domain = domain, .client_id = "talks", .wait = 20s});
  bool restarted = false;
  const auto handle = client.plan(scripted("talk"), {}, [&] { restarted = true; });
  ASSERT_TRUE(handle.waitFor(20s));
  const Outcome outcome = handle.wait();
  ASSERT_TRUE(std::holds_alternative<Failed>(outcome));
  EXPECT_EQ(std::get<Failed>(outcome).reason, FailureReason::kInternal);
  EXPECT_TRUE(restarted);
  EXPECT_LT(slowest(client, 3), 0.5);
}

TEST_F(ClientStreams, AreNoneForRequestsOfAnotherDaemonsCell) {
  start();
  wire::Participant other({.domain = domain, .name = "other", .on_writer = {}});
  wire::Writer<msg::DaemonStatus> statuses(other, {});
  DaemonStatus elsewhere{.id = RequestId::random().bytes, .version = "test"};
  elsewhere.state = DaemonState::kReady;
  elsewhere.cells = {{"elsewhere", {"answer"}, 1, {}, ""}};
  ASSERT_EQ(statuses.write(wire::encode(elsewhere)), wire::WriteResult::kOk);
  {
    Client client({.domain = domain, .client_id = {}, .wait = 20s});
    ASSERT_EQ(client.daemons().size(), 2u);
  }
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
  EXPECT_LT(slowest(client, 3), 0.5);
  EXPECT_LE(status().clients, 66u);
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
