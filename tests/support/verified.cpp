// SPDX-License-Identifier: Apache-2.0
#include "verified.hpp"

#include "temporary_folder.hpp"
#include "verify/unreadable.hpp"
#include "verify/verifier.hpp"

#include <handover/client/answer.hpp>

namespace handover::test {

std::string planText(const std::vector<PlanEventPayload>& events, const Outcome& outcome) {
  client::Answer answer;
  std::uint32_t sequence = 0;
  answer.add({RequestId{}, {}, sequence++, 0.0, Accepted{}});
  for (const PlanEventPayload& payload : events) {
    answer.add({RequestId{}, {}, sequence++, 0.0, payload});
  }
  answer.add({RequestId{}, {}, sequence, 0.0, outcome});
  return answer.text();
}

testing::AssertionResult verifiedFile(const std::filesystem::path& file,
                                      const std::filesystem::path& root) {
  try {
    const verify::Report report = verify::verifyPlan(file, root);
    if (report.valid()) return testing::AssertionSuccess();
    return testing::AssertionFailure() << verify::toText(report);
  } catch (const verify::Unreadable& unreadable) {
    return testing::AssertionFailure() << unreadable.what();
  }
}

testing::AssertionResult verified(const std::vector<PlanEventPayload>& events,
                                  const Outcome& outcome, const std::filesystem::path& root) {
  if (!std::holds_alternative<Done>(outcome)) {
    const auto* failed = std::get_if<Failed>(&outcome);
    return testing::AssertionFailure()
           << "no plan: "
           << (failed != nullptr
                   ? std::string(toString(failed->reason)) + ", " + failed->explanation.text
                   : "outcome " + std::to_string(outcome.index()));
  }
  const TemporaryFolder folder;
  return verifiedFile(folder.write("plan.json", planText(events, outcome)), root);
}

}  // namespace handover::test
