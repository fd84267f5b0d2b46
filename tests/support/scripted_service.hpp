// SPDX-License-Identifier: Apache-2.0
// Planning that does what the task's name says: for tests of everything around planning.
#pragma once

#include "runtime/plan_service.hpp"
#include "sample_events.hpp"

#include <condition_variable>
#include <mutex>
#include <stdexcept>

namespace handover::test {

class ScriptedService : public PlanService {
 public:
  std::vector<CellInfo> cells() const override {
    return {{"script",
             {"answer", "fail", "hold", "paced", "throw", "touch", "touch_low", "refuse_low"},
             7,
             {{"number", {0}, {1}, {}, {}}, {"word", {}, {}, {}, {"low", "high"}}}}};
  }

  void prepare(const Deadline&) override {}

  Outcome plan(const PlanRequest& request, PlanEventSink& sink, const Deadline& deadline) override {
    if (request.task == "throw") throw std::runtime_error("thrown as asked");
    if (request.task == "fail") return sampleFailure();
    if (request.task == "hold") return hold(sink, deadline);
    if (request.task == "paced") return pace(sink);
    if (request.task == "touch" || (request.task == "touch_low" && numberOf(request) < 0.04)) {
      return Failed{FailureReason::kStartInCollision,
                    {.filter = "start",
                     .text = "a touches b",
                     .causes = {{"collision", {"a", "b"}, 1}},
                     .nearest_fix = {},
                     .fix_text = ""}};
    }
    if (request.task == "refuse_low" && numberOf(request) < 0.5) {
      return Rejected{"bad_request", {{"number", "is low"}}};
    }
    auto stages = sampleAnswer(request.id);
    for (std::size_t i = 1; i + 1 < stages.size(); ++i) sink.emit(stages[i].payload);
    return std::get<Outcome>(stages.back().payload);
  }

 private:
  static double numberOf(const PlanRequest& request) {
    for (const Override& change : request.overrides) {
      if (change.path == "number") return std::stod(change.value);
    }
    return 1;
  }

  /// Emits stages 7 ms apart, as a search does.
  static Outcome pace(PlanEventSink& sink) {
    std::mutex mutex;
    std::condition_variable never;
    std::unique_lock lock(mutex);
    for (int i = 0; i < 20; ++i) {
      never.wait_for(lock, std::chrono::milliseconds(7), [] { return false; });
      sink.emit(ArmSelected{"left", "right", {}});
    }
    return Cancelled{};
  }

  /// Emits a stage and searches until it is stopped.
  static Outcome hold(PlanEventSink& sink, const Deadline& deadline) {
    sink.emit(ArmSelected{"left", "right", {}});
    std::mutex mutex;
    std::condition_variable never;
    std::unique_lock lock(mutex);
    while (!deadline.over()) never.wait_for(lock, std::chrono::milliseconds(1));
    if (deadline.state() == Deadline::State::kCancelled) return Cancelled{};
    return Failed{FailureReason::kDeadline, {.filter = "search", .text = "the deadline passed"}};
  }
};

}  // namespace handover::test
