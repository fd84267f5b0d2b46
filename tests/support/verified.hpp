// SPDX-License-Identifier: Apache-2.0
// Every plan that a test makes goes through here: written as the client writes it, checked by the
// verifier, which shares no code with the planner.
#pragma once

#include <handover/common/plan_event.hpp>

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

namespace handover::test {

/// The text of the plan file for what planning emitted and answered.
/// @throws std::logic_error unless the outcome is a whole plan or a failure.
std::string planText(const std::vector<PlanEventPayload>& events, const Outcome& outcome);

/// Success when the outcome is a plan that the verifier finds valid. `root`: what the scene's paths
/// are relative to.
testing::AssertionResult verified(const std::vector<PlanEventPayload>& events,
                                  const Outcome& outcome, const std::filesystem::path& root);
testing::AssertionResult verifiedFile(const std::filesystem::path& file,
                                      const std::filesystem::path& root);

}  // namespace handover::test
