// SPDX-License-Identifier: Apache-2.0
// A daemon whose planning does what the task's name says: for system tests of everything around
// planning. usage: scripted_daemon DOMAIN
#include "daemon.hpp"
#include "sample_stages.hpp"

#include <handover/common/domain.hpp>

#include <condition_variable>
#include <iostream>
#include <mutex>

namespace handover {
namespace {

class ScriptedService : public PlanService {
 public:
  std::vector<CellInfo> cells() const override {
    return {{"script", {"answer", "fail", "hold", "throw"}, 7}};
  }

  void prepare(const Deadline&) override {}

  Outcome plan(const PlanRequest& request, StageSink& sink, const Deadline& deadline) override {
    if (request.task == "throw") throw std::runtime_error("thrown as asked");
    if (request.task == "fail") return test::sampleFailure();
    if (request.task == "hold") return hold(sink, deadline);
    auto stages = test::sampleAnswer(request.id);
    for (std::size_t i = 1; i + 1 < stages.size(); ++i) sink.emit(stages[i].payload);
    return std::get<Outcome>(stages.back().payload);
  }

 private:
  /// Emits a stage and searches until it is stopped.
  static Outcome hold(StageSink& sink, const Deadline& deadline) {
    sink.emit(ArmSelected{"left", "right", {}});
    std::mutex mutex;
    std::condition_variable never;
    std::unique_lock lock(mutex);
    while (!deadline.over()) never.wait_for(lock, std::chrono::milliseconds(1));
    if (deadline.state() == Deadline::State::kCancelled) return Cancelled{};
    return Failed{FailureReason::kDeadline, {.filter = "search", .text = "the deadline passed"}};
  }
};

}  // namespace
}  // namespace handover

int main(int argc, char** argv) {
  const auto domain = handover::parseDomain(argc == 2 ? argv[1] : "");
  if (!domain) {
    std::cerr << "usage: scripted_daemon DOMAIN\n";
    return 2;
  }
  const handover::StopSignals signals;
  handover::ScriptedService service;
  return handover::runDaemon(service, {.domain = *domain, .threads = 1}, signals) ? 0 : 3;
}
