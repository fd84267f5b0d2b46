// SPDX-License-Identifier: Apache-2.0
// Stage paths -> timed stages: timing under the joints' limits, and the timed curve checked again.
#pragma once

#include "core/motion/timing.hpp"
#include "core/planning/transport_motions.hpp"

#include <variant>
#include <vector>

namespace handover {

/// A stage timed by itself.
struct TimedStage {
  const StagePath* stage = nullptr;
  std::vector<DofId> dofs;  ///< as the path lists them: the stage's, then its fingers'
  TimedPath path;
  /// Of a retreat: when the tool's origin is kClearDistance away for the first time [s], to 1 us.
  double clear = 0;
  bool goes_on = false;  ///< begins without a stop where the stage before it ends
};

/// Times all stages. Every curve is proven free in the world of its stage (StateChecker::hitAlong)
/// and, where the tool has to go straight, measured. Stages that may be joined are timed as one;
/// where that touches or leaves the line, by themselves; a stage that touches is timed again with
/// tighter corners before it is given up. Once the deadline is over what comes back means nothing.
std::variant<std::vector<TimedStage>, MotionFailure> timeStages(const TransportProblem& problem,
                                                                CollisionContext& context,
                                                                const TransportPath& path,
                                                                const Deadline& deadline);

}  // namespace handover
