// SPDX-License-Identifier: Apache-2.0
// Keeps what planning emits.
#pragma once

#include "core/planning/plan_event_sink.hpp"

#include <vector>

namespace handover::test {

/// Those of one sort.
template <typename T>
std::vector<T> allOf(const std::vector<PlanEventPayload>& stages) {
  std::vector<T> found;
  for (const auto& stage : stages) {
    if (const auto* payload = std::get_if<T>(&stage)) found.push_back(*payload);
  }
  return found;
}

class Recorder : public PlanEventSink {
 public:
  void emit(PlanEventPayload payload) override { stages.push_back(std::move(payload)); }

  template <typename T>
  std::vector<T> all() const {
    return allOf<T>(stages);
  }

  std::vector<PlanEventPayload> stages;
};

}  // namespace handover::test
