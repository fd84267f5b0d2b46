// SPDX-License-Identifier: Apache-2.0
// Planning that does what the task's name says: for tests of everything around planning.
#pragma once

#include "runtime/plan_service.hpp"
#include "sample_events.hpp"

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <stdexcept>

namespace handover::test {

class ScriptedService : public PlanService {
 public:
  std::shared_ptr<const ServedCells> served() const override {
    CellInfo cell{.name = "script", .tasks = kTasks, .revision = revision_, .variations = {}};
    cell.variations = {{"number", {0}, {1}, {}, {}}, {"word", {}, {}, {}, {"low", "high"}}};
    cell.scene_hash = "0123abcd";
    return std::make_shared<const ServedCells>(std::vector<CellInfo>{cell});
  }

  void reload(const Deadline&) override { ++revision_; }

  bool prepareNext(const Deadline&) override { return false; }

  std::uint64_t prepare(const ServedCells&, const PlanRequest&, const Deadline&) override {
    return 0;
  }

  std::optional<Outcome> plan(const ServedCells&, const PlanRequest& request, PlanEventSink& sink,
                              const Deadline& deadline, const OthersWait&) override {
    if (request.task == "throw") throw std::runtime_error("thrown as asked");
    if (request.task == "fail") return play(sampleFailedAnswer(request.id), sink);
    if (request.task == "hold") return hold(sink, deadline);
    if (request.task == "stuck") return hold(sink, Deadline());
    if (request.task == "paced") return pace(sink);
    if (request.task == "echo") return echo(request, sink);
    if (request.task == "talk") return talk(sink, deadline);
    if (request.task == "touch" || (request.task == "touch_low" && numberOf(request) < 0.04)) {
      Explanation why{.filter = "start", .text = "a touches b"};
      why.causes = {{Cause::kCollision, {"a", "b"}, {}, 1}};
      return Failed{FailureReason::kStartInCollision, why};
    }
    if (request.task == "refuse_low" && numberOf(request) < 0.5) {
      return Rejected{RejectionReason::kBadRequest, {{"number", "is low"}}};
    }
    const std::uint32_t holders = request.task == "one" ? 1 : request.task == "three" ? 3 : 2;
    return play(sampleAnswer(request.id, 0.001, holders), sink);
  }

 private:
  inline static const std::vector<std::string> kTasks{"answer", "one",       "three",     "fail",
                                                      "echo",   "hold",      "paced",     "throw",
                                                      "touch",  "touch_low", "refuse_low"};

  static double numberOf(const PlanRequest& request) {
    for (const Override& change : request.overrides) {
      if (change.path == "number") return std::stod(change.value);
    }
    return 1;
  }

  /// Emits all but the first event, which the runtime sends, and the outcome.
  static Outcome play(const std::vector<PlanEvent>& events, PlanEventSink& sink) {
    for (std::size_t i = 1; i + 1 < events.size(); ++i) sink.emit(events[i].payload);
    return std::get<Outcome>(events.back().payload);
  }

  /// Says what was asked, as rejections' faults.
  static Outcome echo(const PlanRequest& request, PlanEventSink& sink) {
    sink.emit(Note{"echo", "what arrived"});
    std::string chain;
    for (const auto& holder : request.chain) chain += (chain.empty() ? "" : ",") + holder;
    return Rejected{RejectionReason::kBadRequest,
                    {{"chain", chain},
                     {"objective", toString(request.objective)},
                     {"slack_s", std::to_string(request.slack_s)},
                     {"wants_fix", request.wants_fix ? "true" : "false"}}};
  }

  /// Emits more events than a reader that does not take lets an answer have.
  static Outcome talk(PlanEventSink& sink, const Deadline& deadline) {
    for (int i = 0; i < 5000 && !deadline.over(); ++i) sink.emit(Note{"talk", "on"});
    return Cancelled{CancelCause::kAsked};
  }

  /// Emits events 7 ms apart, as a search does.
  static Outcome pace(PlanEventSink& sink) {
    std::mutex mutex;
    std::condition_variable never;
    std::unique_lock lock(mutex);
    for (int i = 0; i < 20; ++i) {
      never.wait_for(lock, std::chrono::milliseconds(7), [] { return false; });
      sink.emit(sampleArms());
    }
    return Cancelled{CancelCause::kAsked};
  }

  /// Emits an event and searches until it is stopped.
  static Outcome hold(PlanEventSink& sink, const Deadline& deadline) {
    sink.emit(sampleArms());
    std::mutex mutex;
    std::condition_variable never;
    std::unique_lock lock(mutex);
    while (!deadline.over()) never.wait_for(lock, std::chrono::milliseconds(1));
    if (deadline.state() == Deadline::State::kCancelled) return Cancelled{};
    return Failed{FailureReason::kDeadline, {.filter = "search", .text = "the deadline passed"}};
  }

  std::atomic<std::uint64_t> revision_ = 7;
};

}  // namespace handover::test
