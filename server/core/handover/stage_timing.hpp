// SPDX-License-Identifier: Apache-2.0
// Stage paths -> timed stages: timing under the joints' limits, and the timed curve checked again.
#pragma once

#include "core/handover/exchange.hpp"

#include <handover/common/plan_event.hpp>

#include <string>
#include <variant>
#include <vector>

namespace handover {

/// Why an exchange could not be timed: the stage, and what touched on its timed curve.
struct TimingFailure {
  std::string stage, detail;
};

/// Times all stages. Every curve is proven free in the world of its stage (StateChecker::hitAlong);
/// a stage that touches is timed again with tighter corners before it is given up. Then stages of
/// the two robots are let overlap (startTimes()).
std::variant<std::vector<StageTrajectory>, TimingFailure> timeStages(
    const HandoverProblem& problem, const CollisionContext& checkers, const Exchange& exchange,
    std::uint32_t solution);

}  // namespace handover
