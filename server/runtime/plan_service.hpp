// SPDX-License-Identifier: Apache-2.0
// What the daemon's workers call for a request: the seam between requests and the planning core.
#pragma once

#include "core/planning/plan_event_sink.hpp"

#include <handover/common/deadline.hpp>
#include <handover/common/plan_event.hpp>
#include <handover/common/status.hpp>

#include <vector>

namespace handover {

/// Implementations are safe from any worker thread.
class PlanService {
 public:
  virtual ~PlanService() = default;

  /// Cells served, in a fixed order; available before prepare() has ended.
  virtual std::vector<CellInfo> cells() const = 0;

  /// Builds what is missing (maps, grasp sets). Called once, before the first plan(); stops early
  /// when the deadline is cancelled. @throws std::exception with the reason when it cannot.
  virtual void prepare(const Deadline& deadline) = 0;

  /// Answers a request whose fields were validated and whose cell is one of cells(): checks names,
  /// task, overrides and the expected revision (Rejected with every fault), plans, emits events to
  /// the sink and returns the outcome without emitting it.
  virtual Outcome plan(const PlanRequest& request, PlanEventSink& sink,
                       const Deadline& deadline) = 0;
};

}  // namespace handover
