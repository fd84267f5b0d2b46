// SPDX-License-Identifier: Apache-2.0
// Shortest path over a small set of candidate configurations, edges checked lazily; tried before
// trees are grown.
#pragma once

#include "core/motion/ikbirrt.hpp"

#include <optional>

namespace handover {

struct LazyRoadmapSettings {
  double most = 0;                  ///< cost of a way that is too long to be worth a check
  std::uint32_t most_checks = 100;  ///< segments checked
  bool straight = true;             ///< whether the straight segment may be a way
};

/// What a straight segment costs: >= 0.
using SegmentCost = std::function<double(const ArmVector& from, const ArmVector& to)>;

/// The cheapest valid way from `from` to `to` by straight segments between these and `vias`, each
/// of its corners such that it can be rounded (MotionProblem::rounding); nullopt where there is
/// none below `most`, or none was found in time. Segments are checked only where the cheapest way
/// left leads over them. Same arguments, same answer.
/// @pre `from` and `to` are valid.
std::optional<JointPath> lazyShortestPath(const MotionProblem& problem, const ArmVector& from,
                                          const ArmVector& to, std::vector<ArmVector> vias,
                                          const SegmentCost& cost,
                                          const LazyRoadmapSettings& settings,
                                          const Deadline& deadline);

}  // namespace handover
