// SPDX-License-Identifier: Apache-2.0
#include "runtime/runtime.hpp"

#include "runtime/memory_endpoint.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <latch>
#include <random>
#include <set>
#include <thread>

namespace handover {
namespace {

using namespace std::chrono_literals;

/// Plans what the test says; `prepare` and `plan` may be held back until released or stopped.
class FakeService : public PlanService {
 public:
  std::shared_ptr<const ServedCells> served() const override {
    return std::make_shared<const ServedCells>(
        std::vector<CellInfo>{{"butler", {"serve"}, revision, {}, "0123abcd"}});
  }

  void reload(const Deadline&) override {
    if (!reload_error.empty()) throw std::runtime_error(reload_error);
    ++revision;
  }

  bool prepareNext(const Deadline& deadline) override {
    if (!prepare_error.empty()) throw std::runtime_error(prepare_error);
    waitWhile(holding_prepare, deadline);
    prepared = true;
    return false;
  }

  std::uint64_t prepare(const ServedCells&, const PlanRequest& request,
                        const Deadline& deadline) override {
    if (request.task == "unmakable") throw std::runtime_error("no space for grasps");
    waitWhile(holding_prepare, deadline);
    if (request.task != "never made") made.insert(request.id);
    return 1 << 20;
  }

  std::optional<Outcome> plan(const ServedCells& cells, const PlanRequest& request,
                              PlanEventSink& sink, const Deadline& deadline,
                              const OthersWait& others_wait) override {
    if (!prepared && prepare_error.empty() && !made.contains(request.id)) return std::nullopt;
    if (request.object == "new" && !made.contains(request.id)) return std::nullopt;
    ++plans;
    {
      const std::lock_guard lock(mutex_);
      order.push_back(request.id);
    }
    if (request.task == "others") {
      waitWhile(holding_plans, deadline);
      sink.emit(Note{"others", others_wait() ? "wait" : "none"});
      return Done{0, true};
    }
    if (request.task == "revision") {
      waitWhile(holding_plans, deadline);
      sink.emit(Note{"revision", std::to_string(cells.infos.front().revision)});
      return Done{0, true};
    }
    if (request.task == "throw") throw std::runtime_error("broken promise");
    if (request.task == "nan") sink.emit(Solution{.cost = std::nan("")});
    if (request.task == "bad outcome") return Rejected{};
    sink.emit(ArmSelected{});
    if (request.task == "known early") sink.emit(Failure{FailureReason::kNoPath, {}});
    waitWhile(holding_plans, deadline);
    if (request.task == "slow") {
      for (int poll = 0; poll < 300 && !deadline.over(); ++poll) std::this_thread::sleep_for(10us);
    }
    switch (deadline.state()) {
      case Deadline::State::kCancelled:
        return Cancelled{};
      case Deadline::State::kPassed:
        return Failed{FailureReason::kDeadline, {}};
      case Deadline::State::kOpen:
        break;
    }
    if (request.task == "known early") return Failed{FailureReason::kNoPath, {}};
    return Done{0, true};
  }

  void release() {
    {
      const std::lock_guard lock(mutex_);
      holding_prepare = holding_plans = false;
    }
    changed_.notify_all();
  }

  bool holding_prepare = false, holding_plans = false;
  std::string prepare_error, reload_error;
  std::atomic<std::uint64_t> revision = 5;
  std::atomic<int> plans = 0;
  std::atomic<bool> prepared = false;
  std::vector<RequestId> order;  ///< in which requests were planned
  std::set<RequestId> made;      ///< requests that prepare() was called for

 private:
  /// Planning polls its deadline; so does this.
  void waitWhile(const bool& holding, const Deadline& deadline) {
    std::unique_lock lock(mutex_);
    while (holding && !deadline.over()) changed_.wait_for(lock, 1ms);
  }

  std::mutex mutex_;
  std::condition_variable changed_;
};

class RuntimeTest : public testing::Test {
 protected:
  void start(RuntimeSettings settings = {}) {
    settings.id = {9};
    settings.version = "1.2.3";
    runtime.emplace(service, endpoint, settings);
    runtime->start();
    if (service.holding_prepare || !service.prepare_error.empty()) return;
    ASSERT_TRUE(endpoint.waitForStatus(
        [](const DaemonStatus& s) { return s.state == DaemonState::kReady; }));
  }

  static PlanRequest request(const std::string& task = "serve") {
    PlanRequest request;
    request.id = RequestId::random();
    request.client_id = "test";
    request.cell = "butler";
    request.task = task;
    return request;
  }

  PlanRequest send(PlanRequest r) {
    endpoint.send(r);
    return r;
  }

  bool waitForEvents(const RequestId& id, std::size_t count) {
    return endpoint.waitFor(id, [&](const auto& s) { return s.size() >= count; }).has_value();
  }

  /// Why a request was turned away; empty when it was not.
  std::string busyText(const RequestId& id) {
    const auto outcome = endpoint.outcome(id);
    const auto* rejected = outcome ? std::get_if<Rejected>(&*outcome) : nullptr;
    if (rejected == nullptr || rejected->reason != RejectionReason::kBusy) return "";
    return rejected->faults.at(0).message;
  }

  FakeService service;
  MemoryEndpoint endpoint;
  std::optional<Runtime> runtime;
};

template <typename T>
bool is(const std::optional<Outcome>& outcome) {
  return outcome && std::holds_alternative<T>(*outcome);
}

TEST_F(RuntimeTest, AnswersWithEventsInSequenceAndOneOutcome) {
  start();
  const auto r = send(request());
  EXPECT_TRUE(is<Done>(endpoint.outcome(r.id)));
  runtime->stop();
  const auto events = endpoint.events(r.id);
  ASSERT_EQ(events.size(), 3u);
  EXPECT_EQ(std::get<Accepted>(events[0].payload), (Accepted{{9}, 0, "1.2.3", 5, "0123abcd", 0}));
  EXPECT_TRUE(std::holds_alternative<ArmSelected>(events[1].payload));
  for (std::uint32_t i = 0; i < 3; ++i) {
    EXPECT_EQ(events[i].sequence, i);
    EXPECT_EQ(events[i].answer_id, events[0].answer_id);
  }
  EXPECT_NE(events[0].answer_id, AnswerId{});
  EXPECT_LE(events[0].elapsed_s, events[2].elapsed_s);
}

TEST_F(RuntimeTest, EventsLeaveWhilePlanningGoesOn) {
  service.holding_plans = true;
  start();
  const auto r = send(request());
  EXPECT_TRUE(waitForEvents(r.id, 2));  // accepted and arm_selected, planning still held
  EXPECT_FALSE(std::holds_alternative<Outcome>(endpoint.events(r.id).back().payload));
  service.release();
  EXPECT_TRUE(is<Done>(endpoint.outcome(r.id)));
}

TEST_F(RuntimeTest, AcceptsWhilePreparingAndPlansAfterwards) {
  service.holding_prepare = true;
  start();
  const auto r = send(request());
  EXPECT_TRUE(waitForEvents(r.id, 1));
  EXPECT_TRUE(endpoint.waitForStatus(
      [](const DaemonStatus& s) { return s.state == DaemonState::kPreparing && s.queued == 1; }));
  EXPECT_EQ(service.plans, 0);
  service.release();
  EXPECT_TRUE(is<Done>(endpoint.outcome(r.id)));
  EXPECT_TRUE(endpoint.waitForStatus([](const DaemonStatus& s) {
    return s.state == DaemonState::kReady && s.queued == 0 && s.counters.done == 1;
  }));
}

TEST_F(RuntimeTest, IgnoresAnIdThatIsBeingAnsweredAndRejectsOneThatWas) {
  service.holding_plans = true;
  start();
  const auto r = send(request());
  ASSERT_TRUE(waitForEvents(r.id, 2));
  send(r);
  EXPECT_EQ(endpoint.events(r.id).size(), 2u);
  service.release();
  EXPECT_TRUE(is<Done>(endpoint.outcome(r.id)));
  send(r);
  endpoint.sendInvalid(r.id, "test", {{"a", "x"}});
  const auto events = endpoint.events(r.id);
  ASSERT_EQ(events.size(), 5u);
  for (std::size_t i = 3; i < 5; ++i) {
    EXPECT_EQ(events[i].sequence, 0u);
    const auto& rejected = std::get<Rejected>(std::get<Outcome>(events[i].payload));
    EXPECT_EQ(rejected.reason, RejectionReason::kAlreadyAnswered);
    EXPECT_EQ(rejected.faults.at(0).field, "request_id");
  }
  EXPECT_NE(events[3].answer_id, events[0].answer_id);
  EXPECT_NE(events[4].answer_id, events[3].answer_id);
  EXPECT_EQ(service.plans, 1);
}

TEST_F(RuntimeTest, AnswersAnIdAnewOnceItIsForgotten) {
  start({.remembered = 2});
  const auto first = send(request());
  EXPECT_TRUE(is<Done>(endpoint.outcome(first.id)));
  for (int i = 0; i < 2; ++i) {
    send(first);  // rejected, and remembered no longer for it
    EXPECT_TRUE(is<Done>(endpoint.outcome(send(request()).id)));
  }
  send(first);
  EXPECT_TRUE(is<Done>(endpoint.outcome(first.id)));
  EXPECT_TRUE(
      endpoint.waitFor(first.id, [](const auto& events) { return events.size() == 3 + 2 + 3; })
          .has_value());
}

TEST_F(RuntimeTest, AFailureIsToldBeforeItsOutcome) {
  start();
  const auto r = send(request("known early"));
  EXPECT_TRUE(is<Failed>(endpoint.outcome(r.id)));
  const auto events = endpoint.events(r.id);
  ASSERT_EQ(events.size(), 4u);
  EXPECT_EQ(std::get<Failure>(events[2].payload).reason, FailureReason::kNoPath);
}

TEST_F(RuntimeTest, ACancelSaysItsFirstCause) {
  service.holding_plans = true;
  start();
  const auto cancelled = [this](const RequestId& id) {
    return std::get<Cancelled>(endpoint.outcome(id).value());
  };
  const auto running = send(request());
  ASSERT_TRUE(waitForEvents(running.id, 2));
  const auto queued = send(request()), left = send(request());
  endpoint.cancel(queued.id, CancelCause::kDisposed);
  EXPECT_EQ(cancelled(queued.id).cause, CancelCause::kDisposed);
  endpoint.cancel(running.id, CancelCause::kClientLost);
  endpoint.cancel(running.id, CancelCause::kAsked);
  EXPECT_EQ(cancelled(running.id).cause, CancelCause::kClientLost);
  runtime->stop();
  EXPECT_EQ(cancelled(left.id).cause, CancelCause::kDaemonStopping);
}

TEST_F(RuntimeTest, SaysTheQueuePlaceAndRejectsWhenFull) {
  service.holding_plans = true;
  start({.queue_capacity = 2});
  const auto running = send(request());
  ASSERT_TRUE(waitForEvents(running.id, 2));
  const auto second = send(request()), third = send(request()), fourth = send(request());
  EXPECT_EQ(std::get<Accepted>(endpoint.events(second.id).at(0).payload).queue_place, 1u);
  EXPECT_EQ(std::get<Accepted>(endpoint.events(third.id).at(0).payload).queue_place, 2u);
  const auto events = endpoint.events(fourth.id);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(std::get<Rejected>(std::get<Outcome>(events[0].payload)).reason,
            RejectionReason::kBusy);
  service.release();
  for (const auto& r : {running, second, third}) EXPECT_TRUE(is<Done>(endpoint.outcome(r.id)));
}

TEST_F(RuntimeTest, AClientTakesTurnsWithOneThatHasManyRequests) {
  service.holding_plans = true;
  start();
  const auto running = send(request());
  ASSERT_TRUE(waitForEvents(running.id, 2));
  std::vector<PlanRequest> many;
  for (int i = 0; i < 20; ++i) many.push_back(send(request()));
  auto other = request();
  other.client_id = "other";
  send(other);
  service.release();
  EXPECT_TRUE(is<Done>(endpoint.outcome(other.id)));
  for (const auto& r : many) EXPECT_TRUE(is<Done>(endpoint.outcome(r.id)));
  EXPECT_EQ(service.order.at(1), other.id);  // next after the one that ran as it came
  EXPECT_EQ(std::get<Accepted>(endpoint.events(other.id).at(0).payload).queue_place, 1u);
  EXPECT_EQ(std::get<Accepted>(endpoint.events(many[19].id).at(0).payload).queue_place, 20u);
}

TEST_F(RuntimeTest, AClientsWaitingRequestsAreLimitedAndItIsToldSo) {
  service.holding_plans = true;
  start({.client_queue = 2});
  const auto running = send(request());
  ASSERT_TRUE(waitForEvents(running.id, 2));
  send(request());
  send(request());
  EXPECT_THAT(busyText(send(request()).id), testing::HasSubstr("2 requests of this client wait"));
  auto other = request();
  other.client_id = "other";
  send(other);
  service.release();
  EXPECT_TRUE(is<Done>(endpoint.outcome(other.id)));
}

TEST_F(RuntimeTest, AClientsTimeIsLimitedAndItIsToldSo) {
  start({.client_limits = {.cpu_s = 1e-9}});
  EXPECT_TRUE(is<Done>(endpoint.outcome(send(request()).id)));
  EXPECT_THAT(busyText(send(request()).id), testing::HasSubstr("s of planning within an hour"));
  auto other = request();
  other.client_id = "other";
  EXPECT_TRUE(is<Done>(endpoint.outcome(send(other).id)));
}

TEST_F(RuntimeTest, WhatAClientHasMadeIsLimitedAndItIsToldSo) {
  start({.client_limits = {.cache_bytes = 2 << 20}});
  for (int i = 0; i < 2; ++i) {
    auto needy = request();
    needy.object = "new";
    EXPECT_TRUE(is<Done>(endpoint.outcome(send(needy).id)));
  }
  EXPECT_THAT(busyText(send(request()).id), testing::HasSubstr("2 MiB of maps, grasp sets"));
}

TEST_F(RuntimeTest, RequestsWithoutADeadlineGetTheDaemons) {
  service.holding_plans = true;
  start({.deadline_s = 0.02});
  const auto outcome = endpoint.outcome(send(request()).id);
  ASSERT_TRUE(is<Failed>(outcome));
  EXPECT_EQ(std::get<Failed>(*outcome).reason, FailureReason::kDeadline);
  auto patient = request();
  patient.deadline_s = 60;
  send(patient);
  ASSERT_TRUE(waitForEvents(patient.id, 2));
  service.release();
  EXPECT_TRUE(is<Done>(endpoint.outcome(patient.id)));
}

TEST_F(RuntimeTest, CancelsQueuedAndRunningRequests) {
  service.holding_plans = true;
  start();
  const auto running = send(request());
  ASSERT_TRUE(waitForEvents(running.id, 2));
  const auto queued = send(request());
  endpoint.cancel(queued.id);
  EXPECT_TRUE(is<Cancelled>(endpoint.outcome(queued.id)));
  EXPECT_EQ(endpoint.events(running.id).size(), 2u);
  endpoint.cancel(running.id);
  EXPECT_TRUE(is<Cancelled>(endpoint.outcome(running.id)));
  endpoint.cancel(running.id);
  endpoint.cancel(RequestId::random());
  runtime->stop();
  EXPECT_EQ(endpoint.events(running.id).size(), 3u);
  EXPECT_EQ(endpoint.events(queued.id).size(), 2u);
}

TEST_F(RuntimeTest, DeadlineCountsInTheQueue) {
  service.holding_plans = true;
  start();
  const auto running = send(request());
  ASSERT_TRUE(waitForEvents(running.id, 2));
  auto late = request();
  late.deadline_s = 0.02;
  send(late);
  const auto outcome = endpoint.outcome(late.id);
  ASSERT_TRUE(is<Failed>(outcome));
  EXPECT_EQ(std::get<Failed>(*outcome).reason, FailureReason::kDeadline);
  EXPECT_EQ(endpoint.events(running.id).size(), 2u);  // the worker was never free
}

TEST_F(RuntimeTest, DeadlineReachesThePlanner) {
  service.holding_plans = true;
  start();
  auto r = request();
  r.deadline_s = 0.02;
  send(r);
  const auto outcome = endpoint.outcome(r.id);
  ASSERT_TRUE(is<Failed>(outcome));
  EXPECT_EQ(std::get<Failed>(*outcome).reason, FailureReason::kDeadline);
}

TEST_F(RuntimeTest, AnAbsurdDeadlineIsNone) {
  start();
  auto r = request();
  r.deadline_s = 1e300;
  send(r);
  EXPECT_TRUE(is<Done>(endpoint.outcome(r.id)));
}

TEST_F(RuntimeTest, RejectsUnknownCellsWhenItsIdIsLowest) {
  start();
  endpoint.announceOther({.id = {10}, .cells = {{"stool", {}, 1}}});
  auto r = request();
  r.cell = "nowhere";
  send(r);
  const auto outcome = endpoint.outcome(r.id);
  ASSERT_TRUE(is<Rejected>(outcome));
  EXPECT_EQ(std::get<Rejected>(*outcome).reason, RejectionReason::kUnknownCell);
  EXPECT_EQ(std::get<Rejected>(*outcome).faults.at(0).field, "cell");
}

TEST_F(RuntimeTest, NamesTheNearestCellOfAllDaemonsForOneThatNobodyServes) {
  start();
  endpoint.announceOther({.id = {10}, .cells = {{"stool", {}, 1}}});
  for (const auto& [asked, nearest] : {std::pair("butlr", "butler"), std::pair("stol", "stool")}) {
    auto r = request();
    r.cell = asked;
    const auto outcome = endpoint.outcome(send(r).id);
    ASSERT_TRUE(is<Rejected>(outcome));
    EXPECT_EQ(std::get<Rejected>(*outcome).faults.at(0).message,
              std::string("no daemon serves a cell named '") + asked +
                  "'; the nearest known one is '" + nearest + "'");
  }
}

TEST_F(RuntimeTest, LeavesUnknownCellsToTheLowestIdAndCellsToThoseThatServeThem) {
  start();
  endpoint.announceOther({.id = {10}, .cells = {{"stool", {}, 1}}});
  auto stool = request();
  stool.cell = "stool";
  send(stool);
  endpoint.announceOther({.id = {1}});
  auto nowhere = request();
  nowhere.cell = "nowhere";
  send(nowhere);
  const auto ours = send(request());
  EXPECT_TRUE(is<Done>(endpoint.outcome(ours.id)));
  EXPECT_TRUE(endpoint.events(stool.id).empty());
  EXPECT_TRUE(endpoint.events(nowhere.id).empty());
}

TEST_F(RuntimeTest, RejectsInvalidRequestsWithEveryFault) {
  start();
  const RequestId id = RequestId::random();
  const std::vector<Fault> faults{{"a", "x"}, {"b", "y"}};
  endpoint.sendInvalid(id, "test", faults);
  const auto outcome = endpoint.outcome(id);
  ASSERT_TRUE(is<Rejected>(outcome));
  EXPECT_EQ(std::get<Rejected>(*outcome), (Rejected{RejectionReason::kBadRequest, faults}));
}

TEST_F(RuntimeTest, LeavesInvalidRequestsToTheLowestId) {
  start();
  const RequestId first = RequestId::random(), second = RequestId::random();
  endpoint.announceOther({.id = {10}});
  endpoint.sendInvalid(first, "test", {{"a", "x"}});
  EXPECT_TRUE(is<Rejected>(endpoint.outcome(first)));
  endpoint.announceOther({.id = {1}});
  endpoint.sendInvalid(second, "test", {{"a", "x"}});
  const auto ours = send(request());
  EXPECT_TRUE(is<Done>(endpoint.outcome(ours.id)));
  EXPECT_TRUE(endpoint.events(second).empty());
}

TEST_F(RuntimeTest, ALineTellsWhatARequestAskedAndHowItEnded) {
  start();
  testing::internal::CaptureStderr();
  auto r = request("known early");
  r.seed = 42;
  endpoint.outcome(send(r).id);
  const RequestId bad = RequestId::random();
  endpoint.sendInvalid(bad, "me\n\x1B[2J", {{"seed", "is\nodd"}, {"", "b"}});
  runtime->stop();
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_THAT(log, testing::HasSubstr("request " + r.id.hex() +
                                      " of test: cell butler, task known early, seed 42, scene "
                                      "0123abcd: failed: no_path ()"));
  EXPECT_THAT(log, testing::HasSubstr("request " + bad.hex() + " of me\\n\\x1b[2J: cell "));
  EXPECT_THAT(log, testing::HasSubstr("rejected: bad_request (seed: is\\nodd; b)"));
  EXPECT_EQ(std::count(log.begin(), log.end(), '\n'), 2);
}

TEST_F(RuntimeTest, SurvivesExceptionsAndEventsThatMustNotBeSent) {
  start();
  for (const char* task : {"throw", "nan", "bad outcome"}) {
    const auto r = send(request(task));
    const auto outcome = endpoint.outcome(r.id);
    ASSERT_TRUE(is<Failed>(outcome)) << task;
    EXPECT_EQ(std::get<Failed>(*outcome).reason, FailureReason::kInternal) << task;
  }
  EXPECT_TRUE(is<Done>(endpoint.outcome(send(request()).id)));
}

TEST_F(RuntimeTest, StopGivesEveryOpenRequestItsOutcome) {
  service.holding_plans = true;
  start();
  std::vector<RequestId> ids;
  for (int i = 0; i < 10; ++i) ids.push_back(send(request()).id);
  ASSERT_TRUE(waitForEvents(ids[0], 2));
  runtime->stop();
  for (const auto& id : ids) {
    const auto events = endpoint.events(id);
    ASSERT_FALSE(events.empty());
    EXPECT_EQ(std::get<Outcome>(events.back().payload),
              Outcome{Cancelled{CancelCause::kDaemonStopping}});
    const auto outcomes = std::count_if(events.begin(), events.end(), [](const PlanEvent& event) {
      return std::holds_alternative<Outcome>(event.payload);
    });
    EXPECT_EQ(outcomes, 1);
  }
  const auto late = send(request());
  EXPECT_TRUE(endpoint.events(late.id).empty());
}

TEST_F(RuntimeTest, StopEndsPreparation) {
  service.holding_prepare = true;
  start();
  const auto r = send(request());
  ASSERT_TRUE(waitForEvents(r.id, 1));
  runtime->stop();
  EXPECT_TRUE(is<Cancelled>(endpoint.outcome(r.id)));
  EXPECT_EQ(service.plans, 0);
}

TEST_F(RuntimeTest, ARequestThatNeedsSomethingMadeHoldsUpNobody) {
  start();
  ASSERT_TRUE(
      endpoint.waitForStatus([](const DaemonStatus& s) { return s.state == DaemonState::kReady; }));
  service.holding_prepare = true;
  PlanRequest needy = request();
  needy.object = "new";
  send(needy);
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(is<Done>(endpoint.outcome(send(request()).id)));
  EXPECT_FALSE(std::holds_alternative<Outcome>(endpoint.events(needy.id).back().payload));
  service.release();
  EXPECT_TRUE(is<Done>(endpoint.outcome(needy.id)));
}

TEST_F(RuntimeTest, ARequestIsCancelledWhileWhatItNeedsIsMade) {
  start();
  ASSERT_TRUE(
      endpoint.waitForStatus([](const DaemonStatus& s) { return s.state == DaemonState::kReady; }));
  service.holding_prepare = true;
  std::vector<RequestId> ids;
  for (int i = 0; i < 3; ++i) {
    PlanRequest needy = request();
    needy.object = "new";
    ids.push_back(send(needy).id);
  }
  for (const RequestId& id : ids) endpoint.cancel(id);
  for (const RequestId& id : ids) EXPECT_TRUE(is<Cancelled>(endpoint.outcome(id)));
  PlanRequest late = request();
  late.object = "new";
  late.deadline_s = 0.01;
  const auto outcome = endpoint.outcome(send(late).id);
  ASSERT_TRUE(is<Failed>(outcome));
  EXPECT_EQ(std::get<Failed>(*outcome).reason, FailureReason::kDeadline);
}

TEST_F(RuntimeTest, ARequestCancelledWhileInNoQueueHasNotMissedADeadline) {
  start();
  service.holding_prepare = true;
  PlanRequest needy = request();
  needy.object = "new";
  send(needy);
  ASSERT_TRUE(waitForEvents(needy.id, 1));
  ASSERT_TRUE(endpoint.waitForStatus(
      [](const DaemonStatus& s) { return s.queued == 1 && s.running == 0; }));
  service.holding_plans = true;
  const PlanRequest busy = send(request());  // keeps the worker from what comes back
  ASSERT_TRUE(waitForEvents(busy.id, 2));
  endpoint.cancel(needy.id);
  EXPECT_TRUE(is<Cancelled>(endpoint.outcome(needy.id)));
  EXPECT_FALSE(std::holds_alternative<Outcome>(endpoint.events(busy.id).back().payload));
  service.release();
}

TEST_F(RuntimeTest, WhatCannotBeMadeFailsItsRequestOnly) {
  start();
  for (const char* task : {"unmakable", "never made"}) {
    PlanRequest needy = request();
    needy.object = "new";
    needy.task = task;
    const auto outcome = endpoint.outcome(send(needy).id);
    ASSERT_TRUE(is<Failed>(outcome)) << task;
    EXPECT_EQ(std::get<Failed>(*outcome).reason, FailureReason::kInternal);
  }
  EXPECT_TRUE(is<Done>(endpoint.outcome(send(request()).id)));
}

TEST_F(RuntimeTest, PlanningIsToldWhetherOthersWait) {
  service.holding_plans = true;
  start();
  PlanRequest first = request(), second = request();
  first.task = second.task = "others";
  send(first);
  send(second);
  EXPECT_TRUE(endpoint.waitForStatus([](const DaemonStatus& s) { return s.queued == 1; }));
  service.release();
  const auto noteOf = [&](const RequestId& id) {
    EXPECT_TRUE(is<Done>(endpoint.outcome(id)));
    return std::get<Note>(endpoint.events(id).at(1).payload).text;
  };
  EXPECT_EQ(noteOf(first.id), "wait");
  EXPECT_EQ(noteOf(second.id), "none");
}

TEST_F(RuntimeTest, AFailedPreparationIsReportedAndFailsRequests) {
  service.prepare_error = "no space for maps";
  std::latch told{1};
  RuntimeSettings settings;
  settings.on_prepare_failed = [&](const std::string& reason) {
    EXPECT_EQ(reason, "no space for maps");
    told.count_down();
  };
  start(settings);
  told.wait();
  const auto outcome = endpoint.outcome(send(request()).id);
  ASSERT_TRUE(is<Failed>(outcome));
  EXPECT_THAT(std::get<Failed>(*outcome).explanation.text, testing::HasSubstr("no space for maps"));
}

TEST_F(RuntimeTest, RequestsKeepTheCellsThatTheyWereAcceptedWith) {
  service.holding_plans = true;
  start();
  const auto running = send(request("revision"));
  ASSERT_TRUE(waitForEvents(running.id, 1));
  const auto queued = send(request("revision"));
  runtime->reload(Deadline());
  const auto later = send(request("revision"));
  service.release();
  const auto revisions = [&](const RequestId& id) {
    EXPECT_TRUE(is<Done>(endpoint.outcome(id)));
    const auto events = endpoint.events(id);
    return std::pair(std::get<Accepted>(events.at(0).payload).scene_revision,
                     std::get<Note>(events.at(1).payload).text);
  };
  EXPECT_EQ(revisions(running.id), std::pair(std::uint64_t{5}, std::string("5")));
  EXPECT_EQ(revisions(queued.id), std::pair(std::uint64_t{5}, std::string("5")));
  EXPECT_EQ(revisions(later.id), std::pair(std::uint64_t{6}, std::string("6")));
}

TEST_F(RuntimeTest, CellsThatCannotBeReadAgainStayAsTheyAre) {
  bool ended = false;
  RuntimeSettings settings;
  settings.on_prepare_failed = [&](const std::string&) { ended = true; };
  start(settings);
  service.reload_error = "butler.yaml:3: no such robot";
  runtime->reload(Deadline());
  EXPECT_TRUE(is<Done>(endpoint.outcome(send(request()).id)));
  service.reload_error.clear();
  service.prepare_error = "no space for maps";
  runtime->reload(Deadline());
  ASSERT_TRUE(endpoint.waitForStatus([](const DaemonStatus& s) {
    return s.state == DaemonState::kReady && s.cells.front().revision == 6;
  }));
  EXPECT_TRUE(is<Done>(endpoint.outcome(send(request()).id)));
  EXPECT_FALSE(ended);
}

TEST_F(RuntimeTest, ManyRequestsOnManyWorkersAreAnsweredOnceEach) {
  start({.threads = 4, .queue_capacity = 1000, .client_queue = 1000});
  std::vector<RequestId> ids;
  for (int i = 0; i < 300; ++i) {
    ids.push_back(send(request()).id);
    if (i % 3 == 0) endpoint.cancel(ids.back());
  }
  for (const auto& id : ids) ASSERT_TRUE(endpoint.outcome(id).has_value());
  runtime->stop();
  for (const auto& id : ids) {
    const auto events = endpoint.events(id);
    for (std::uint32_t i = 0; i < events.size(); ++i) {
      EXPECT_EQ(events[i].sequence, i);
      EXPECT_EQ(std::holds_alternative<Outcome>(events[i].payload), i + 1 == events.size());
    }
  }
}

/// The seed of what is sent and when; threads and places in the queue.
struct Storm {
  unsigned seed;
  int threads;
  std::size_t capacity;
  bool stopped_midway;
};

class RuntimeStorm : public RuntimeTest, public testing::WithParamInterface<Storm> {
 protected:
  /// One more request, or a word about an earlier one.
  void act() {
    const auto any = [&] { return ids[bits() % ids.size()]; };
    switch (bits() % 8) {
      case 0:
        endpoint.cancel(any());
        return;
      case 1:
        endpoint.cancel(ids.back());
        return;
      case 2:
        endpoint.cancel(RequestId::random());
        return;
      case 3: {
        auto again = request("slow");
        again.id = any();
        send(again);
        return;
      }
      case 4: {
        const RequestId early = RequestId::random();
        endpoint.cancel(early);
        auto r = request();
        r.id = early;
        ids.push_back(send(r).id);
        return;
      }
      case 5:
        std::this_thread::sleep_for(std::chrono::microseconds(bits() % 500));
        return;
      default: {
        static const char* const kTasks[] = {"serve", "slow", "slow",
                                             "throw", "nan",  "bad outcome"};
        auto r = request(kTasks[bits() % std::size(kTasks)]);
        if (bits() % 4 == 0) r.deadline_s = 1e-5 * static_cast<double>(bits() % 300 + 1);
        ids.push_back(send(r).id);
      }
    }
  }

  /// Each from its first event to its last: an answer's events are together only by their id.
  static std::vector<std::vector<PlanEvent>> answersOf(const std::vector<PlanEvent>& events) {
    std::vector<std::vector<PlanEvent>> answers;
    for (const PlanEvent& event : events) {
      const auto same = [&](const auto& answer) {
        return answer.front().answer_id == event.answer_id;
      };
      const auto found = std::find_if(answers.begin(), answers.end(), same);
      if (found == answers.end()) {
        answers.push_back({event});
      } else {
        found->push_back(event);
      }
    }
    return answers;
  }

  /// Answers beyond the first of each request.
  std::size_t repeated() const {
    std::size_t answers = 0;
    for (const auto& id : ids) answers += answersOf(endpoint.events(id)).size();
    return answers - ids.size();
  }

  std::mt19937_64 bits{GetParam().seed};
  std::vector<RequestId> ids;
};

INSTANTIATE_TEST_SUITE_P(Seeded, RuntimeStorm,
                         testing::Values(Storm{1, 1, 1000, false}, Storm{2, 3, 1000, false},
                                         Storm{3, 4, 5, false}, Storm{4, 1, 2, false},
                                         Storm{5, 2, 1000, true}, Storm{6, 4, 8, true}));

TEST_P(RuntimeStorm, EveryRequestHasOneOutcomeAtItsEnd) {
  start({.threads = GetParam().threads,
         .queue_capacity = GetParam().capacity,
         .client_queue = GetParam().capacity});
  ids.push_back(send(request()).id);
  while (ids.size() < 300) act();
  if (GetParam().stopped_midway) {
    runtime->stop();
  } else {
    for (const auto& id : ids) ASSERT_TRUE(endpoint.outcome(id).has_value());
    const std::size_t answers = ids.size() + repeated();
    const auto answered = [&](const DaemonStatus& s) {
      const OutcomeCounters& c = s.counters;
      return c.done + c.failed + c.cancelled + c.rejected == answers && s.queued == 0 &&
             s.running == 0;
    };
    EXPECT_TRUE(endpoint.waitForStatus(answered));
    runtime->stop();
  }
  std::array<int, std::variant_size_v<Outcome>> outcomes{};
  int again = 0;
  for (const auto& id : ids) {
    const auto answers = answersOf(endpoint.events(id));
    ASSERT_FALSE(answers.empty());
    for (const auto& events : answers) {
      for (std::uint32_t i = 0; i < events.size(); ++i) {
        EXPECT_EQ(events[i].sequence, i);
        EXPECT_EQ(std::holds_alternative<Outcome>(events[i].payload), i + 1 == events.size());
      }
      const auto& outcome = std::get<Outcome>(events.back().payload);
      EXPECT_NE(std::holds_alternative<Accepted>(events[0].payload),
                std::holds_alternative<Rejected>(outcome));
      if (&events == &answers.front()) {
        ++outcomes[outcome.index()];
      } else {
        ++again;
        EXPECT_EQ(std::get<Rejected>(outcome).reason, RejectionReason::kAlreadyAnswered);
      }
    }
  }
  EXPECT_GT(again, 0);
  // The storm is of use only while it meets every kind of outcome that it can.
  EXPECT_GT(outcomes[Outcome(Done{}).index()], 0);
  EXPECT_GT(outcomes[Outcome(Failed{}).index()], 0);
  EXPECT_GT(outcomes[Outcome(Cancelled{}).index()], 0);
  EXPECT_EQ(outcomes[Outcome(Rejected{}).index()] > 0, GetParam().capacity < 100);
}

}  // namespace
}  // namespace handover
