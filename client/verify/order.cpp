// SPDX-License-Identifier: Apache-2.0
#include "verify/order.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace handover::verify {
namespace {

constexpr double kNone = -std::numeric_limits<double>::infinity();
constexpr double kEarlyLeave = 1e-3;  // [s] before the tool link is 5 mm away

std::vector<double> offsetsInRuns(const Scene& scene, const Task& task) {
  std::vector<double> offsets(scene.plan.stages.size(), 0.0);
  for (const std::vector<int>& run : task.runs) {
    double at = 0;
    for (const int s : run) {
      offsets[static_cast<std::size_t>(s)] = at;
      at += scene.stage(s).duration();
    }
  }
  return offsets;
}

/// The file's edges between runs, and the box of starts that are late by at most `slack`.
std::vector<Precedence> edgesOfRuns(const Scene& scene, const Task& task, double slack) {
  const std::vector<double> offsets = offsetsInRuns(scene, task);
  const auto offset = [&](int s) { return offsets[static_cast<std::size_t>(s)]; };
  const auto run = [&](int s) { return task.run_of[static_cast<std::size_t>(s)]; };
  const int source = static_cast<int>(task.runs.size());
  std::vector<Precedence> edges;
  for (std::size_t r = 0; r < task.runs.size(); ++r) {
    const double planned = scene.stage(task.runs[r].front()).start;
    edges.push_back({source, static_cast<int>(r), planned});
    edges.push_back({static_cast<int>(r), source, -(planned + slack)});
  }
  for (int s = 0; s < scene.stageCount(); ++s) {
    for (const After& after : scene.stage(s).after) {
      if (run(after.stage) == run(s)) continue;
      edges.push_back({run(after.stage), run(s), offset(after.stage) + after.progress - offset(s)});
    }
  }
  return edges;
}

}  // namespace

LongestPaths::LongestPaths(int nodes, const std::vector<Precedence>& edges) : nodes_(nodes) {
  const auto n = static_cast<std::size_t>(nodes);
  longest_.assign(n * n, kNone);
  for (std::size_t i = 0; i < n; ++i) longest_[i * n + i] = 0;
  for (const Precedence& edge : edges) {
    double& entry =
        longest_[static_cast<std::size_t>(edge.from) * n + static_cast<std::size_t>(edge.to)];
    entry = std::max(entry, edge.gap);
  }
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t i = 0; i < n; ++i) {
      if (longest_[i * n + k] == kNone) continue;
      for (std::size_t j = 0; j < n; ++j) {
        longest_[i * n + j] =
            std::max(longest_[i * n + j], longest_[i * n + k] + longest_[k * n + j]);
      }
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (longest_[i * n + i] > 1e-6) contradictory_ = true;
  }
}

std::optional<double> LongestPaths::between(int from, int to) const {
  const double sum = longest_[static_cast<std::size_t>(from) * static_cast<std::size_t>(nodes_) +
                              static_cast<std::size_t>(to)];
  if (sum == kNone) return std::nullopt;
  return sum;
}

LongestPaths listedOrder(const Scene& scene, const Task& task) {
  std::vector<Precedence> edges;
  for (int s = 0; s < scene.stageCount(); ++s) {
    for (const After& after : scene.stage(s).after) {
      edges.push_back({after.stage, s, after.progress});
    }
    if (!task.joined[static_cast<std::size_t>(s)]) continue;
    const int before = task.previous[static_cast<std::size_t>(s)];
    edges.push_back({before, s, scene.stage(before).duration()});
    edges.push_back({s, before, -scene.stage(before).duration()});
  }
  return {scene.stageCount(), edges};
}

std::vector<RequiredEdge> requiredEdges(const Scene& scene, const Task& task) {
  std::vector<RequiredEdge> required;
  const auto whole = [&](int stage, int before, const char* why) {
    required.push_back({stage, before, scene.stage(before).duration(), why});
  };
  for (int s = 0; s < scene.stageCount(); ++s) {
    const int before = task.previous[static_cast<std::size_t>(s)];
    if (before >= 0) whole(s, before, "the arm's own order");
  }
  for (int k = 0; k < task.last(); ++k) {
    const HolderStages& gives = task.of[static_cast<std::size_t>(k)];
    const HolderStages& takes = task.of[static_cast<std::size_t>(k) + 1];
    whole(takes.grasp, gives.carry, "the object must have been brought");
    whole(gives.release, takes.grasp, "the next holder must have the object");
    whole(takes.carry, gives.release, "the hand before must be open");
    const double away = task.first_5mm[static_cast<std::size_t>(k)] - kEarlyLeave;
    required.push_back({takes.carry, gives.retreat, std::max(0.0, away),
                        "the hand before must have left by 5 mm"});
  }
  return required;
}

LateStarts::LateStarts(const Scene& scene, const Task& task, double slack)
    : task_(task),
      source_(static_cast<int>(task.runs.size())),
      offset_(offsetsInRuns(scene, task)),
      edges_(edgesOfRuns(scene, task, slack)),
      paths_(source_ + 1, edges_) {}

int LateStarts::node(int stage) const { return task_.run_of[static_cast<std::size_t>(stage)]; }

double LateStarts::least(int a, int b) const {
  return paths_.between(node(a), node(b)).value_or(kNone) + offset(b) - offset(a);
}

double LateStarts::greatest(int a, int b) const { return -least(b, a); }

std::optional<std::vector<double>> LateStarts::starts(
    const std::vector<Precedence>& further) const {
  std::vector<Precedence> edges = edges_;
  for (const Precedence& edge : further) {
    edges.push_back(
        {node(edge.from), node(edge.to), edge.gap + offset(edge.from) - offset(edge.to)});
  }
  // Bellman and Ford from time 0: the longest path to a run is its earliest start.
  const std::size_t nodes = static_cast<std::size_t>(source_) + 1;
  std::vector<double> at(nodes, kNone);
  at.back() = 0;
  for (std::size_t round = 0; round <= nodes; ++round) {
    bool changed = false;
    for (const Precedence& edge : edges) {
      const double reached = at[static_cast<std::size_t>(edge.from)] + edge.gap;
      if (reached > at[static_cast<std::size_t>(edge.to)] + kTimeTolerance) {
        at[static_cast<std::size_t>(edge.to)] = reached;
        changed = true;
      }
    }
    if (!changed) break;
    if (round == nodes) return std::nullopt;
  }
  if (at.back() > 1e-6) return std::nullopt;
  std::vector<double> starts;
  for (std::size_t s = 0; s < offset_.size(); ++s) {
    starts.push_back(at[static_cast<std::size_t>(task_.run_of[s])] + offset_[s]);
  }
  return starts;
}

}  // namespace handover::verify
