// SPDX-License-Identifier: Apache-2.0
#include "listed_cells.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <stdexcept>

namespace handover {
namespace {

namespace fs = std::filesystem;

CellInfo readInfo(const fs::path& file) {
  try {
    const YAML::Node cell = YAML::LoadFile(file.string());
    CellInfo info{cell["name"].as<std::string>(file.stem().string()), {}, 1};
    for (const auto& task : cell["tasks"]) info.tasks.push_back(task.first.as<std::string>());
    return info;
  } catch (const YAML::Exception& error) {
    throw std::runtime_error(file.string() + ": " + error.what());
  }
}

}  // namespace

ListedCells::ListedCells(const fs::path& root, const std::vector<std::string>& cells) {
  const fs::path folder = root / "config" / "cells";
  std::vector<fs::path> files;
  for (const auto& cell : cells) {
    files.push_back(cell.ends_with(".yaml") ? fs::path(cell) : folder / (cell + ".yaml"));
  }
  if (cells.empty() && fs::is_directory(folder)) {
    for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
  }
  for (const auto& file : files) cells_.push_back(readInfo(file));
}

Outcome ListedCells::plan(const PlanRequest&, StageSink&, const Deadline&) {
  Failed failed;
  failed.reason = FailureReason::kInternal;
  failed.explanation.filter = "planning";
  failed.explanation.text = "not implemented: planning";
  return failed;
}

}  // namespace handover
