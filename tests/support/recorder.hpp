// SPDX-License-Identifier: Apache-2.0
// Keeps what planning emits.
#pragma once

#include "core/planning/plan_event_sink.hpp"

#include <vector>

namespace handover::test {

/// Those of one sort.
template <typename T>
std::vector<T> allOf(const std::vector<PlanEventPayload>& events) {
  std::vector<T> found;
  for (const auto& event : events) {
    if (const auto* payload = std::get_if<T>(&event)) found.push_back(*payload);
  }
  return found;
}

class Recorder : public PlanEventSink {
 public:
  void emit(PlanEventPayload payload) override { events.push_back(std::move(payload)); }

  template <typename T>
  std::vector<T> all() const {
    return allOf<T>(events);
  }

  std::vector<PlanEventPayload> events;
};

}  // namespace handover::test
