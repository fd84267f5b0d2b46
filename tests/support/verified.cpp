// SPDX-License-Identifier: Apache-2.0
#include "verified.hpp"

#include "temporary_folder.hpp"
#include "verify/unreadable.hpp"
#include "verify/verifier.hpp"

#include <handover/client/plan_file.hpp>

namespace handover::test {

std::string planText(const std::vector<PlanEventPayload>& stages, const Outcome& outcome) {
  client::PlanFile file;
  std::uint32_t sequence = 0;
  file.add({RequestId{}, sequence++, 0.0, Accepted{}});
  for (const PlanEventPayload& payload : stages) file.add({RequestId{}, sequence++, 0.0, payload});
  file.add({RequestId{}, sequence, 0.0, outcome});
  return file.text();
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

testing::AssertionResult verified(const std::vector<PlanEventPayload>& stages, const Outcome& outcome,
                                  const std::filesystem::path& root) {
  if (!std::holds_alternative<Done>(outcome)) {
    const auto* failed = std::get_if<Failed>(&outcome);
    return testing::AssertionFailure()
           << "no plan: "
           << (failed != nullptr
                   ? std::string(toString(failed->reason)) + ", " + failed->explanation.text
                   : "outcome " + std::to_string(outcome.index()));
  }
  const TemporaryFolder folder;
  return verifiedFile(folder.write("plan.json", planText(stages, outcome)), root);
}

}  // namespace handover::test
