// SPDX-License-Identifier: Apache-2.0
// Values as the members of a plan file (design §5) and of JSON lines.
#pragma once

#include "plan_file/json_writer.hpp"

#include <handover/common/plan_event.hpp>

#include <vector>

namespace handover::client {

/// What a cause is about that is the sum of all pairs not listed.
constexpr const char* kOtherPairs = "other pairs";
/// True for such a cause: a collision without names.
bool sumsOtherPairs(const CauseCount& cause);

Json toJson(const SceneSnapshot& scene);
Json toJson(const Quality& quality);
/// As `explanation`: with the reason, and never without a cause.
Json toJson(const Failure& failure);
/// As `plan`, of a solution and its stages in order.
Json planJson(const Solution& solution, const std::vector<const StageTrajectory*>& stages);

Json toJson(const Accepted& accepted);
Json toJson(const ArmSelected& arms);
Json toJson(const GraspsPruned& pruned);
Json toJson(const HandoverCandidates& candidates);
Json toJson(const Solution& solution);
Json toJson(const StageTrajectory& stage);
Json toJson(const Note& note);
Json toJson(const Fix& fix);
Json toJson(const Outcome& outcome);
Json toJson(const Workspaces& workspaces);

}  // namespace handover::client
