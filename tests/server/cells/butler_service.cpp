// SPDX-License-Identifier: Apache-2.0
#include "butler_service.hpp"

#include "support/verified.hpp"

namespace handover::test {

CellService& butlerService() {
  static CellService instance(HANDOVER_SOURCE_DIR, {"butler"},
                              HANDOVER_BINARY_DIR "/test-cache/handover", {}, false);
  static const bool prepared = [] {
    instance.prepare(Deadline());
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
  const Outcome outcome = butlerService().plan(request, recorder, deadline);
  const Answer answer{std::move(recorder.stages), outcome};
  expectVerified(answer);
  return answer;
}

void expectVerified(const Answer& answer) {
  std::map<std::uint32_t, int> stages;
  for (const auto& stage : answer.all<StageTrajectory>()) ++stages[stage.solution];
  for (const auto& [solution, count] : stages) {
    if (count != kStageCount) continue;  // cut by a cancel or the deadline
    EXPECT_TRUE(verified(answer.stages, Done{solution, true}, HANDOVER_SOURCE_DIR))
        << "solution " << solution;
  }
}

}  // namespace handover::test
