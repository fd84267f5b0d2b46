// SPDX-License-Identifier: Apache-2.0
// What the client library makes of answers: of the daemon's parts, and of events that a test
// writes. A program of its own: Fast DDS gives each participant of a process a new id, and those
// beyond 32 find nobody.
#include "dds/dds_endpoint.hpp"
#include "process.hpp"
#include "runtime/runtime.hpp"
#include "scripted_service.hpp"
#include "wire/codec.hpp"
#include "wire/entities.hpp"

#include <handover/client/client.hpp>

#include <fastrtps/xmlparser/XMLProfileManager.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace handover::test {
namespace {

using client::Client;
using client::ClientError;

PlanRequest scripted(const std::string& task) {
  return {.id = RequestId::random(), .client_id = "any", .cell = "script", .task = task};
}

/// A daemon that answers a request with the events of a test.
class EventWriter {
 public:
  EventWriter(int domain, const std::string& client_id, std::vector<PlanEvent> events)
      : events_(std::move(events)),
        participant_({.domain = domain, .name = "events", .on_writer = {}}),
        statuses_(participant_, {}),
        writer_(participant_, {.partition = client_id}),
        cancels_(participant_, {}, [](const auto&) {}),
        requests_(participant_, {}, [this](const wire::Sample<msg::HandoverRequest>& sample) {
          if (sample.message == nullptr) return;
          for (PlanEvent event : events_) {
            event.request_id = RequestId{sample.key};
            (void)writer_.write(wire::encode(event));
          }
        }) {
    DaemonStatus status;
    status.id = RequestId::random().bytes;
    status.version = "test";
    status.state = DaemonState::kReady;
    status.cells = {{"script", {"answer"}, 7, {}, ""}};
    EXPECT_EQ(statuses_.write(wire::encode(status)), wire::WriteResult::kOk);
  }

 private:
  const std::vector<PlanEvent> events_;
  wire::Participant participant_;
  wire::Writer<msg::DaemonStatus> statuses_;
  wire::Writer<msg::PlanEvent> writer_;
  wire::Reader<msg::HandoverCancel> cancels_;
  wire::Reader<msg::HandoverRequest> requests_;
};

constexpr AnswerId kOne{1}, kTwo{2};

class ClientAnswers : public testing::Test {
 public:
  /// As between processes.
  static void SetUpTestSuite() {
    eprosima::fastrtps::LibrarySettingsAttributes settings;
    settings.intraprocess_delivery = eprosima::fastrtps::INTRAPROCESS_OFF;
    eprosima::fastrtps::xmlparser::XMLProfileManager::library_settings(settings);
  }

 protected:
  void start() {
    endpoint.emplace(DdsEndpointSettings{.domain = domain});
    RuntimeSettings settings;
    settings.id = RequestId::random().bytes;
    settings.version = "test";
    runtime.emplace(service, *endpoint, settings);
    runtime->start();
  }

  const int domain = freeDomain();
  ScriptedService service;
  std::optional<DdsEndpoint> endpoint;
  std::optional<Runtime> runtime;
};

TEST_F(ClientAnswers, AreRejectionsForAnIdThatWasAnswered) {
  start();
  Client client({.domain = domain, .client_id = "again", .wait = 20s});
  auto request = scripted("answer");
  AnswerId first{}, second{};
  (void)client.plan(request, [&](const PlanEvent& event) { first = event.answer_id; }).wait();
  const Outcome outcome =
      client.plan(request, [&](const PlanEvent& event) { second = event.answer_id; }).wait();
  ASSERT_TRUE(std::holds_alternative<Rejected>(outcome));
  EXPECT_EQ(std::get<Rejected>(outcome).reason, RejectionReason::kAlreadyAnswered);
  EXPECT_NE(first, second);
}

TEST_F(ClientAnswers, CarryPlansOfOneTwoAndThreeHolders) {
  start();
  Client client({.domain = domain, .client_id = "chains", .wait = 20s});
  for (const auto& [task, stages] : {std::pair{"one", 9}, {"answer", 16}, {"three", 23}}) {
    int last_solution = 0;
    const auto handle = client.plan(scripted(task), [&](const PlanEvent& event) {
      const auto* stage = std::get_if<StageTrajectory>(&event.payload);
      if (stage != nullptr && stage->solution == 1) ++last_solution;
    });
    EXPECT_EQ(handle.wait(), (Outcome{Done{1, true}}));
    EXPECT_EQ(last_solution, stages) << task;
    ASSERT_TRUE(handle.firstPlanTime());
    EXPECT_LE(*handle.firstPlanTime(), handle.answerTime());
    EXPECT_FALSE(handle.failureTime());
  }
}

TEST_F(ClientAnswers, SayWhenTheReasonOfAFailureCame) {
  start();
  Client client({.domain = domain, .client_id = "failure", .wait = 20s});
  const auto handle = client.plan(scripted("fail"));
  EXPECT_EQ(handle.wait(), Outcome{sampleFailure()});
  EXPECT_FALSE(handle.firstPlanTime());
  ASSERT_TRUE(handle.failureTime());
  EXPECT_LE(*handle.failureTime(), handle.answerTime());
}

TEST_F(ClientAnswers, TellOfAMissingEvent) {
  const EventWriter daemon(
      domain, "gaps", {{{}, kOne, 0, 0, Accepted{}}, {{}, kOne, 2, 0, Outcome{Done{1, true}}}});
  Client client({.domain = domain, .client_id = "gaps", .wait = 20s});
  const auto handle = client.plan(scripted("answer"));
  ASSERT_TRUE(handle.waitFor(20s));
  try {
    (void)handle.wait();
    FAIL() << "an answer with a gap was taken for whole";
  } catch (const ClientError& error) {
    EXPECT_EQ(error.code(), ClientError::Code::kBadStream);
    EXPECT_STREQ(error.what(), "event 1 is missing before event 2");
  }
}

TEST_F(ClientAnswers, BeginAnewWithAnotherIdAndAreNeverJoined) {
  // A plan of nine stages: five come from the first answer, all from the second, while the first
  // one's daemon goes on writing to its own outcome.
  const auto plan = sampleAnswer(RequestId{}, 0.001, 1);
  std::vector<PlanEvent> events;
  const auto add = [&](const AnswerId& answer, std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i) {
      events.push_back(plan[i]);
      events.back().answer_id = answer;
    }
  };
  add(kOne, 0, 11);
  add(kTwo, 0, 8);
  add(kOne, 11, plan.size());  // of a daemon that is no longer listened to
  add(kTwo, 8, plan.size());
  const EventWriter daemon(domain, "anew", events);

  Client client({.domain = domain, .client_id = "anew", .wait = 20s});
  std::vector<PlanEvent> seen;
  std::vector<std::size_t> restarts;
  const auto handle = client.plan(
      scripted("answer"), [&](const PlanEvent& event) { seen.push_back(event); },
      [&] { restarts.push_back(seen.size()); });
  ASSERT_TRUE(handle.waitFor(20s));
  EXPECT_EQ(handle.wait(), (Outcome{Done{1, true}}));
  EXPECT_THAT(restarts, testing::ElementsAre(11u));
  ASSERT_EQ(seen.size(), 11 + plan.size());
  for (std::size_t i = 0; i < plan.size(); ++i) {
    EXPECT_EQ(seen[11 + i].answer_id, kTwo);
    EXPECT_EQ(seen[11 + i].sequence, i);
    EXPECT_EQ(seen[11 + i].payload, plan[i].payload);
  }
}

TEST_F(ClientAnswers, AreNoneWhenTheyBeginInTheirMiddle) {
  const EventWriter daemon(
      domain, "middle", {{{}, kOne, 0, 0, Accepted{}}, {{}, kTwo, 1, 0, Outcome{Done{1, true}}}});
  Client client({.domain = domain, .client_id = "middle", .wait = 20s});
  const auto handle = client.plan(scripted("answer"));
  ASSERT_TRUE(handle.waitFor(20s));
  EXPECT_THROW((void)handle.wait(), ClientError);
}

TEST_F(ClientAnswers, EndWithWhatLeavesACallback) {
  start();
  Client client({.domain = domain, .client_id = "throws", .wait = 20s});
  const auto handle = client.plan(scripted("hold"), [](const PlanEvent& event) {
    if (event.sequence == 1) throw std::runtime_error("of the user's own");
  });
  ASSERT_TRUE(handle.waitFor(20s));
  try {
    (void)handle.wait();
    FAIL() << "nothing came out";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "of the user's own");
  }
  // The request is over for the daemon too, and the client goes on.
  EXPECT_TRUE(std::holds_alternative<Done>(client.plan(scripted("answer")).wait()));
}

}  // namespace
}  // namespace handover::test
