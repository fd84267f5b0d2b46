// SPDX-License-Identifier: Apache-2.0
#include "experiment_page.hpp"

#include "draw.hpp"
#include "view/page.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

namespace handover::ctl {
namespace {

using client::Json;

/// One word of a shell command.
std::string quoted(const std::string& word) {
  const auto plain = [](unsigned char c) {
    return std::isalnum(c) != 0 ||
           std::string_view("_-./:=+,@").find(static_cast<char>(c)) != std::string_view::npos;
  };
  if (!word.empty() && std::all_of(word.begin(), word.end(), plain)) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

double rounded(double metres) { return std::round(metres * 1e6) / 1e6; }

Json pointOf(const std::array<double, 3>& p) {
  return {rounded(p[0]), rounded(p[1]), rounded(p[2])};
}

Json latticeOf(const std::vector<LatticeCell>& lattice) {
  Json cells = Json::array();
  for (const LatticeCell& cell : lattice) {
    Json entry = pointOf(cell.centre);
    entry.push_back(rounded(cell.score));
    cells.push_back(std::move(entry));
  }
  return cells;
}

Json paperOf(const std::string& cell) {
  const PaperRow* row = paperRow(cell);
  if (row == nullptr) return nullptr;
  return {{"table", row->table},
          {"planning_time_s", row->seconds},
          {"grasps_giver", row->grasps_giver},
          {"grasps_receiver", row->grasps_receiver},
          {"handover_poses", row->handover_poses}};
}

}  // namespace

std::string repeatCommand(const ExperimentRecord& experiment, const RunRecord& run) {
  std::string text = "handoverctl plan --cell " + quoted(experiment.cell);
  if (!experiment.task.empty()) text += " --task " + quoted(experiment.task);
  text += std::string(" --mode ") + toString(experiment.mode) + " --search " +
          toString(experiment.search) + " --seed " + std::to_string(run.seed);
  for (const Override& change : overridesOf(run.drawn)) {
    text += " --set " + quoted(change.path + "=" + change.value);
  }
  return text;
}

std::string experimentPage(const ExperimentRecord& experiment) {
  Json more = Json::array();
  for (const RunRecord& run : experiment.runs) {
    Json entry = {{"command", repeatCommand(experiment, run)},
                  {"lattice", latticeOf(run.lattice)},
                  {"handover", nullptr}};
    if (run.handover) {
      entry["handover"] = {{"object", pointOf(run.handover->object)},
                           {"receiver_tool", pointOf(run.handover->receiver_tool)}};
    }
    more.push_back(std::move(entry));
  }
  const Json data = {
      {"experiment", toJson(experiment)},
      {"task", experiment.task},
      {"versions", {{"handoverctl", HANDOVER_VERSION}, {"handoverd", experiment.daemon_version}}},
      {"paper", paperOf(experiment.cell)},
      {"lattice_edge", kLatticeEdge},
      {"more", std::move(more)}};
  return view::experimentPage(client::compact(data));
}

}  // namespace handover::ctl
