// SPDX-License-Identifier: Apache-2.0
// Lists the cells of config/cells and plans nothing: requests fail with the reason `internal` and
// say so.
#pragma once

#include "runtime/plan_service.hpp"

#include <filesystem>

namespace handover {

class ListedCells : public PlanService {
 public:
  /// Names of files in <root>/config/cells, or files; none: all of the folder. @throws
  /// std::runtime_error.
  ListedCells(const std::filesystem::path& root, const std::vector<std::string>& cells);

  std::vector<CellInfo> cells() const override { return cells_; }

  void prepare(const Deadline&) override {}

  Outcome plan(const PlanRequest& request, StageSink& sink, const Deadline& deadline) override;

 private:
  std::vector<CellInfo> cells_;
};

}  // namespace handover
