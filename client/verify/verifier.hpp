// SPDX-License-Identifier: Apache-2.0
// The whole check of one plan file. Nothing here is shared with the planner: reader, kinematics,
// geometry and rules are the verifier's own, written from the contract.
#pragma once

#include "verify/report.hpp"

#include <filesystem>

namespace handover::verify {

/// @param root folder that the plan's paths are relative to.
/// @param measure the report's quality is filled in even where the file claims none.
/// @throws Unreadable when the plan, or a file that it names, cannot be understood, or when the
/// file has no plan.
Report verifyPlan(const std::filesystem::path& plan_file, const std::filesystem::path& root,
                  bool measure = false);

}  // namespace handover::verify
