// SPDX-License-Identifier: Apache-2.0
// What `handoverd check --scene` says of a cell: what touches, floats or is out of reach, and how
// many grasps each hand has.
#pragma once

#include "cells/cell_service.hpp"

#include <string>
#include <vector>

namespace handover {

struct SceneFinding {
  enum class Grade { kFact, kWarning, kFault };

  Grade grade = Grade::kFact;
  std::string task, text;
};

/// Every finding of every task of a cell that the service has loaded. Makes maps and grasp sets
/// that are missing. @throws std::runtime_error with the reason when it cannot.
std::vector<SceneFinding> sceneFindings(CellService& service, const std::string& cell,
                                        const Deadline& deadline);

}  // namespace handover
