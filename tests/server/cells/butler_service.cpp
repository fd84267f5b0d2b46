// SPDX-License-Identifier: Apache-2.0
#include "butler_service.hpp"

#include "support/verified.hpp"

#include <map>

namespace handover::test {

CellService& butlerService() {
  static CellService instance(HANDOVER_SOURCE_DIR, {"butler"},
                              std::filesystem::path(HANDOVER_BINARY_DIR "/test-cache/handover"), {},
                              false);
  static const bool prepared = [] {
    instance.prepareAll(Deadline());
    return true;
  }();
  (void)prepared;
  return instance;
}

PlanRequest butlerRequest(std::vector<Override> overrides) {
  PlanRequest request;
  request.id = RequestId::random();
  request.client_id = "test";
  request.cell = "butler";
  request.overrides = std::move(overrides);
  return request;
}

Answer ask(const PlanRequest& request, const Deadline& deadline) {
  Recorder recorder;
  const Outcome outcome = butlerService().planAlone(request, recorder, deadline);
  const Answer answer{std::move(recorder.events), outcome};
  expectVerified(answer);
  return answer;
}

void expectVerified(const Answer& answer) {
  std::map<std::uint32_t, std::uint32_t> stages;
  for (const auto& stage : answer.all<StageTrajectory>()) ++stages[stage.solution];
  for (const Solution& solution : answer.all<Solution>()) {
    // Fewer: cut by a cancel or the deadline.
    if (stages[solution.index] != solution.stage_count) continue;
    EXPECT_TRUE(verified(answer.events, Done{solution.index, true}, HANDOVER_SOURCE_DIR))
        << "solution " << solution.index;
  }
}

}  // namespace handover::test
