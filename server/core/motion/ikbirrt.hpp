// SPDX-License-Identifier: Apache-2.0
// IKBiRRT (Berenson et al.) on OMPL state spaces: goals enter the goal tree during the search.
#pragma once

#include "core/model/robot_model.hpp"

#include <handover/common/deadline.hpp>
#include <handover/common/result.hpp>

#include <cstdint>
#include <functional>
#include <vector>

namespace handover {

/// A joint-space polyline, in the order of the arm's joints.
struct JointPath {
  std::vector<ArmVector> waypoints;
};

/// One arm's planning problem. Callbacks are called from the calling thread only.
struct MotionProblem {
  ArmVector lower, upper;
  std::function<bool(const ArmVector& q)> valid;               ///< free of collision at q
  double resolution = 0.03;                                    ///< largest joint step between checks [rad]
};

struct IkBiRrtSettings {
  std::uint64_t seed = 1;
  std::uint32_t max_iterations = 20'000;                       ///< a count, never seconds
  double range = 1.0;                                          ///< longest tree extension [rad]
};

/// The i-th goal configuration, drawn as the search asks for it; false when there are no more.
/// Calls come with i = 0, 1, 2, ...
using GoalSampler = std::function<bool(std::uint32_t i, ArmVector& q)>;

/// A valid path from `start` to one of the goals; the goal index goes to `goal`.
/// kNoPath after the iteration budget or when every goal is invalid; kDeadline, kCancelled.
Result<JointPath> planIkBiRrt(const MotionProblem& problem, const ArmVector& start,
                              const GoalSampler& goals, const IkBiRrtSettings& settings,
                              const Deadline& deadline, std::uint32_t* goal = nullptr);

/// Shortens a valid path by seeded corner cutting; the result is valid at the problem's resolution and
/// keeps both ends.
JointPath shortcut(const MotionProblem& problem, const JointPath& path, std::uint64_t seed,
                   std::uint32_t attempts, const Deadline& deadline);

/// True when the straight joint segment is valid at the problem's resolution (ends included).
bool segmentValid(const MotionProblem& problem, const ArmVector& from, const ArmVector& to);

}  // namespace handover
