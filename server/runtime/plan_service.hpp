// SPDX-License-Identifier: Apache-2.0
// What the daemon's workers call for a request: the seam between requests and the planning core.
#pragma once

#include "core/planning/plan_event_sink.hpp"

#include <handover/common/deadline.hpp>
#include <handover/common/plan_event.hpp>
#include <handover/common/status.hpp>

#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace handover {

/// Whether other requests wait for the worker that answers this one.
using OthersWait = std::function<bool()>;

/// Cells as they are at one moment; services keep more in it. Immutable.
struct ServedCells {
  explicit ServedCells(std::vector<CellInfo> cells) : infos(std::move(cells)) {}

  virtual ~ServedCells() = default;
  ServedCells(const ServedCells&) = delete;
  ServedCells& operator=(const ServedCells&) = delete;

  const std::vector<CellInfo> infos;  ///< in a fixed order
};

/// plan() is safe from any worker thread, beside one thread that prepares and one that reloads.
class PlanService {
 public:
  virtual ~PlanService() = default;

  /// Cells served; available before any is prepared. A request is answered from those that were
  /// there when it was accepted.
  virtual std::shared_ptr<const ServedCells> served() const = 0;

  /// Reads the cells again, as a new revision each; requests that were accepted keep the old ones.
  /// @throws std::exception with the reason when it cannot, or past the deadline: nothing has
  /// changed then.
  virtual void reload(const Deadline& deadline) = 0;

  /// Makes what one more cell needs (maps, grasp sets); false when no cell lacks anything. Stops
  /// early when the deadline is over. @throws std::exception with the reason when it cannot.
  virtual bool prepareNext(const Deadline& deadline) = 0;

  /// Makes what a request needs whose cell is not prepared, or that changes robots or objects.
  /// @throws std::exception with the reason when it cannot.
  virtual void prepare(const ServedCells& cells, const PlanRequest& request,
                       const Deadline& deadline) = 0;

  /// Answers a request whose fields were validated and whose cell is one of `cells`: checks names,
  /// task, overrides and the expected revision (Rejected with every fault), plans, emits events to
  /// the sink and returns the outcome without emitting it. nullopt: something has to be made first,
  /// which takes long; nothing was emitted. What would help a failed request is sought only while
  /// nobody else waits.
  virtual std::optional<Outcome> plan(const ServedCells& cells, const PlanRequest& request,
                                      PlanEventSink& sink, const Deadline& deadline,
                                      const OthersWait& others_wait) = 0;
};

}  // namespace handover
