// SPDX-License-Identifier: Apache-2.0
// The same request gets the same answer: whatever the daemon is asked before, at the same time or
// after, and whatever of that is cancelled.
#include "butler_service.hpp"
#include "runtime/memory_endpoint.hpp"
#include "runtime/runtime.hpp"
#include "support/recorder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <thread>
#include <tuple>

namespace handover::test {
namespace {

/// Scenes that differ in what planning keeps between requests: a base, a posture, the object, the
/// furniture, the goal.
const std::vector<std::vector<Override>> kOthers{{{"robots.hubo.base.xyz", "[1.18, -0.1, 0.98]"}},
                                                 {{"objects.cup.pose.xyz", "[-0.25, -0.75, 0.903]"},
                                                  {"tasks.serve.goal.xyz", "[0, 0.03, 0.077]"}},
                                                 {{"robots.hubo.base.xyz", "[1.18, -1.1, 0.98]"}},
                                                 {{"robots.hubo.base.xyz", "[6, -0.3, 0.98]"}},
                                                 {{"robots.hubo.base.xyz", "[.nan, 0, 0]"}}};

const Answer& nominal() {
  static const Answer answer = ask(butlerRequest());
  return answer;
}

class Repeatability : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(std::holds_alternative<Done>(nominal().outcome)) << nominal().outcome.index();
  }
};

class EveryMode : public testing::TestWithParam<std::tuple<SearchMode, SearchWidth>> {};

INSTANTIATE_TEST_SUITE_P(
    Repeatability, EveryMode,
    testing::Combine(testing::Values(SearchMode::kFirst, SearchMode::kBest, SearchMode::kAll),
                     testing::Values(SearchWidth::kPaper, SearchWidth::kWide)));

TEST_P(EveryMode, AnswersTheSameTwice) {
  PlanRequest request = butlerRequest();
  std::tie(request.mode, request.search) = GetParam();
  const Answer first = ask(request);
  EXPECT_TRUE(std::holds_alternative<Done>(first.outcome)) << first.outcome.index();
  // Another request by its id only.
  request.id = RequestId::random();
  Recorder again;
  EXPECT_EQ(butlerService().planAlone(request, again, Deadline()), first.outcome);
  EXPECT_EQ(again.events, first.events);
}

TEST_F(Repeatability, OverridesLeaveNothingBehind) {
  for (const auto& overrides : kOthers) {
    PlanRequest other = butlerRequest(overrides);
    other.wants_fix = false;
    EXPECT_NE(ask(other).events, nominal().events) << overrides[0].value;
    EXPECT_EQ(ask(butlerRequest()), nominal()) << "after " << overrides[0].value;
  }
}

/// Two workers, requests of the test's own.
class Interleaved : public Repeatability {
 protected:
  void SetUp() override {
    Repeatability::SetUp();
    RuntimeSettings settings{.threads = 2, .queue_capacity = 1000, .id = {9}};
    settings.sharing = CellSharing::kShared;
    runtime_.emplace(butlerService(), endpoint_, settings);
    runtime_->start();
    ASSERT_TRUE(endpoint_.waitForStatus(
        [](const DaemonStatus& status) { return status.state == DaemonState::kReady; }));
  }

  RequestId send(PlanRequest request) {
    endpoint_.send(request);
    return request.id;
  }

  /// The whole answer, without what the runtime adds. Fails unless it has one outcome, at its end.
  Answer answerTo(const RequestId& id) {
    Answer answer;
    const auto outcome = endpoint_.outcome(id);
    EXPECT_TRUE(outcome.has_value());
    answer.outcome = outcome.value_or(Cancelled{});
    const auto events = endpoint_.events(id);
    for (std::size_t i = 0; i < events.size(); ++i) {
      EXPECT_EQ(events[i].sequence, i);
      EXPECT_EQ(events[i].answer_id, events.front().answer_id);
      EXPECT_EQ(std::holds_alternative<Outcome>(events[i].payload), i + 1 == events.size());
      if (i > 0 && i + 1 < events.size()) answer.events.push_back(events[i].payload);
    }
    return answer;
  }

  MemoryEndpoint endpoint_;
  std::optional<Runtime> runtime_;
};

TEST_F(Interleaved, OrderAndNeighboursDoNotMatter) {
  // The nominal request at either end and in the middle of others, forwards and backwards.
  std::vector<std::vector<Override>> order{{}};
  for (const auto& overrides : kOthers) order.push_back(overrides);
  order.insert(order.begin() + 3, std::vector<Override>{});
  order.push_back({});
  std::map<std::string, Answer> answers;  // by the first override's value
  for (const bool backwards : {false, true}) {
    if (backwards) std::reverse(order.begin(), order.end());
    std::vector<RequestId> ids;
    for (const auto& overrides : order) {
      PlanRequest request = butlerRequest(overrides);
      // Where there is no plan, no search for what would help.
      request.wants_fix = overrides.empty();
      ids.push_back(send(request));
    }
    for (std::size_t i = 0; i < order.size(); ++i) {
      const std::string name = order[i].empty() ? "" : order[i][0].value;
      const Answer answer = answerTo(ids[i]);
      const auto [known, is_new] = answers.emplace(name, answer);
      if (is_new) expectVerified(answer);
      EXPECT_EQ(answer, known->second) << name << (backwards ? " backwards" : " forwards");
    }
  }
  EXPECT_EQ(answers.at(""), nominal());
  EXPECT_TRUE(std::holds_alternative<Done>(answers.at(kOthers[0][0].value).outcome));
  EXPECT_TRUE(std::holds_alternative<Done>(answers.at(kOthers[1][0].value).outcome));
  EXPECT_TRUE(std::holds_alternative<Failed>(answers.at(kOthers[3][0].value).outcome));
  EXPECT_TRUE(std::holds_alternative<Rejected>(answers.at(kOthers[4][0].value).outcome));
}

/// What was being counted when the deadline passed is told as far as it was.
void dropCountsUnderWay(std::vector<PlanEventPayload>& events) {
  const std::vector<PlanEventPayload>& whole = nominal().events;
  const auto funnel = [](const PlanEventPayload& event) {
    return std::holds_alternative<GraspsPruned>(event) ||
           std::holds_alternative<HandoverCandidates>(event);
  };
  while (!events.empty() && funnel(events.back()) &&
         (events.size() > whole.size() || events.back() != whole[events.size() - 1])) {
    events.pop_back();
  }
}

bool isSolution(const PlanEventPayload& event) { return std::holds_alternative<Solution>(event); }

bool isFailure(const PlanEventPayload& event) { return std::holds_alternative<Failure>(event); }

TEST_F(Interleaved, CancelsEndTheirOwnRequestOnly) {
  std::mt19937_64 bits(1);
  std::map<RequestId, bool> cancelled;  // or with a deadline
  std::vector<RequestId> ids;
  for (int i = 0; i < 40; ++i) {
    PlanRequest request = butlerRequest();
    const bool ends = bits() % 2 == 0;
    if (ends && bits() % 2 == 0) request.deadline_s = 1e-3 * static_cast<double>(bits() % 100 + 1);
    ids.push_back(send(request));
    cancelled[ids.back()] = ends;
    if (ends && !request.deadline_s) {
      std::this_thread::sleep_for(std::chrono::microseconds(bits() % 20'000));
      endpoint_.cancel(ids[bits() % 3 == 0 ? 0 : ids.size() - 1]);
      cancelled[ids[0]] = true;
    }
  }
  int stopped = 0;
  for (const RequestId& id : ids) {
    Answer answer = answerTo(id);
    if (const auto* done = std::get_if<Done>(&answer.outcome); done != nullptr && done->complete) {
      EXPECT_EQ(answer, nominal());
      continue;
    }
    ++stopped;
    EXPECT_TRUE(cancelled[id]);
    if (std::holds_alternative<Done>(answer.outcome)) {
      // The plan that was in hand when the deadline passed.
      EXPECT_TRUE(std::any_of(answer.events.begin(), answer.events.end(), isSolution));
      continue;
    }
    const auto failure = std::find_if(answer.events.begin(), answer.events.end(), isFailure);
    if (failure != answer.events.end()) {
      // Of the outcome itself.
      EXPECT_EQ(std::get<Failure>(*failure).reason, FailureReason::kDeadline);
      EXPECT_TRUE(std::holds_alternative<Failed>(answer.outcome));
      answer.events.erase(failure, answer.events.end());
      dropCountsUnderWay(answer.events);
    }
    // What had left before is the beginning of the same answer.
    ASSERT_LE(answer.events.size(), nominal().events.size());
    EXPECT_TRUE(std::equal(answer.events.begin(), answer.events.end(), nominal().events.begin()));
    const auto* failed = std::get_if<Failed>(&answer.outcome);
    EXPECT_TRUE(std::holds_alternative<Cancelled>(answer.outcome) ||
                (failed != nullptr && failed->reason == FailureReason::kDeadline));
  }
  EXPECT_GE(stopped, 5);
  EXPECT_LT(stopped, 40);
  runtime_->stop();
  for (const RequestId& id : ids) answerTo(id);  // nothing came after
}

}  // namespace
}  // namespace handover::test
