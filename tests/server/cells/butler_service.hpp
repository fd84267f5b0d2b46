// SPDX-License-Identifier: Apache-2.0
// The butler cell served without DDS, and its answers.
#pragma once

#include "cells/cell_service.hpp"
#include "support/recorder.hpp"

#include <vector>

namespace handover::test {

/// One service for all tests of a program; its cache lies in the build folder.
CellService& butlerService();

PlanRequest butlerRequest(std::vector<Override> overrides = {});

struct Answer {
  std::vector<PlanEventPayload> events;
  Outcome outcome;

  bool operator==(const Answer&) const = default;

  template <typename T>
  std::vector<T> all() const {
    return allOf<T>(events);
  }
};

/// What the service answers. Every plan in it, not only the final one, has to pass the verifier.
Answer ask(const PlanRequest& request, const Deadline& deadline = Deadline());

/// Fails the running test unless the verifier finds every whole plan of the answer valid.
void expectVerified(const Answer& answer);

}  // namespace handover::test
