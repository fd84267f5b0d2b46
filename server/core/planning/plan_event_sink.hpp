// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <handover/common/plan_event.hpp>

namespace handover {

/// Takes the events of an answer as they become known. Called from the planning thread.
class PlanEventSink {
 public:
  virtual ~PlanEventSink() = default;
  virtual void emit(PlanEventPayload payload) = 0;
};

}  // namespace handover
