// SPDX-License-Identifier: Apache-2.0
// The whole check of one plan file. Nothing here is shared with the planner: reader, kinematics,
// geometry and rules are the verifier's own, written from the contract.
#pragma once

#include "verify/report.hpp"

#include <filesystem>

namespace handover::verify {

/// @param root folder that the plan's paths are relative to.
/// @throws Unreadable when the plan, or a file that it names, cannot be understood.
Report verifyPlan(const std::filesystem::path& plan_file, const std::filesystem::path& root);

}  // namespace handover::verify
