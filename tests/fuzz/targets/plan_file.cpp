// SPDX-License-Identifier: Apache-2.0
#include "support/sample_events.hpp"
#include "target.hpp"

#include <handover/client/answer.hpp>
#include <handover/client/plan_file.hpp>

namespace handover::fuzz {

std::vector<std::string> seeds() {
  const RequestId id = RequestId::fromHex("00112233445566778899aabbccddeeff").value();
  std::vector<std::string> all;
  for (const auto& events : {test::sampleAnswer(id), test::sampleFailedAnswer(id)}) {
    client::Answer answer;
    for (const PlanEvent& event : events) answer.add(event);
    all.push_back(answer.text());
  }
  return all;
}

void run(std::string_view input) {
  try {
    (void)client::parsePlanFile(input);
  } catch (const client::PlanFileError&) {  // refused
  }
}

}  // namespace handover::fuzz
