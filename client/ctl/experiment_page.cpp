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

Json moreOf(const PageRun& run, const std::string& command) {
  Json handovers = Json::array();
  for (const HandoverPlace& place : run.handovers) {
    handovers.push_back(
        {{"object", pointOf(place.object)}, {"receiver_tool", pointOf(place.receiver_tool)}});
  }
  return {{"command", command},
          {"lattice", latticeOf(run.lattice)},
          {"handovers", std::move(handovers)},
          {"page", run.page.empty() ? Json() : Json(run.page)}};
}

}  // namespace

std::string repeatCommand(const Json& file, const Json& record, const std::string& task) {
  const auto word = [&](const char* key) { return quoted(file.at(key).get<std::string>()); };
  // Run i asks with the experiment's seed plus i.
  const auto seed = file.at("seed").get<std::uint64_t>() + record.at("index").get<std::uint64_t>();
  std::string text = "handoverctl plan --cell " + word("cell");
  if (!task.empty()) text += " --task " + quoted(task);
  text += " --mode " + word("mode") + " --search " + word("search");
  text += " --objective " + word("objective") + " --seed " + std::to_string(seed);
  for (const Override& change : overridesOf(record.at("drawn"))) {
    text += " --set " + quoted(change.path + "=" + change.value);
  }
  return text;
}

std::string experimentPage(const Json& file, const PageExtras& extras) {
  Json more = Json::array();
  for (const Json& record : file.at("records")) {
    more.push_back(moreOf(extras.runs.at(more.size()), repeatCommand(file, record, extras.task)));
  }
  const Json data = {
      {"experiment", file},
      {"task", extras.task},
      {"versions", {{"handoverctl", HANDOVER_VERSION}, {"handoverd", extras.daemon_version}}},
      {"paper", paperOf(file.at("cell"))},
      {"lattice_edge", kLatticeEdge},
      {"more", std::move(more)}};
  return view::experimentPage(client::compact(data));
}

}  // namespace handover::ctl
