// SPDX-License-Identifier: Apache-2.0
// What must have happened before a stage may start, as the file lists it and as the contract
// requires it, and when stages may start that are late.
#pragma once

#include "verify/scene.hpp"
#include "verify/task.hpp"

#include <optional>
#include <string>
#include <vector>

namespace handover::verify {

constexpr double kTimeTolerance = 1e-9;  // [s]

/// x[to] >= x[from] + gap.
struct Precedence {
  int from = 0, to = 0;
  double gap = 0;
};

/// Longest paths between all nodes of a graph of precedences.
class LongestPaths {
 public:
  LongestPaths(int nodes, const std::vector<Precedence>& edges);

  /// The sum of gaps that x[to] - x[from] must reach; nullopt: nothing joins them.
  std::optional<double> between(int from, int to) const;

  /// A cycle that no times can keep.
  bool contradictory() const { return contradictory_; }

 private:
  int nodes_;
  std::vector<double> longest_;
  bool contradictory_ = false;
};

/// Between stages: the file's `after`, and joined stages at their fixed distance.
LongestPaths listedOrder(const Scene& scene, const Task& task);

struct RequiredEdge {
  int stage = 0, before = 0;
  double progress = 0;  ///< of `before`, own time [s]
  std::string why;
};

/// What the contract requires. @pre task.first_5mm is known.
std::vector<RequiredEdge> requiredEdges(const Scene& scene, const Task& task);

/// All starts of runs that are at most `slack` later than planned and keep `after`.
class LateStarts {
 public:
  LateStarts(const Scene& scene, const Task& task, double slack);

  /// Least and greatest possible start(b) - start(a) of two stages.
  double least(int a, int b) const;
  double greatest(int a, int b) const;

  /// The earliest starts of all stages at which the further precedences between stages hold, too;
  /// nullopt: there are none.
  std::optional<std::vector<double>> starts(const std::vector<Precedence>& further) const;

 private:
  int node(int stage) const;

  double offset(int stage) const { return offset_[static_cast<std::size_t>(stage)]; }

  const Task& task_;
  int source_;                     ///< the node of time 0
  std::vector<double> offset_;     ///< per stage, from its run's start
  std::vector<Precedence> edges_;  ///< between runs and time 0
  LongestPaths paths_;
};

}  // namespace handover::verify
