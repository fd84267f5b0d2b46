// SPDX-License-Identifier: Apache-2.0
// Solver of free stages: paths of an arm that are not straight lines of its tool ([paper] §IV-E).
// First a lazy roadmap over configurations that such paths are likely to lead through, then
// IKBiRRT.
#pragma once

#include "core/motion/ikbirrt.hpp"
#include "core/planning/collision_context.hpp"

#include <optional>
#include <vector>

namespace handover {

/// Paths found before in much the same world: configurations in the order in which they lead away
/// from the start or from the goal.
struct SeedPaths {
  std::vector<ArmVector> from_start, from_goal;
};

/// Safe from one thread at a time only because its checkers are.
class FreeMotionSolver {
 public:
  FreeMotionSolver(const FreeMotionSettings& settings, const Deadline& deadline)
      : settings_(settings), deadline_(deadline) {}

  /// A path from one configuration to another; nullopt: none found.
  /// @param seed  of the trees: of the request, the stage and its grasp.
  std::optional<JointPath> solve(const Manipulator& arm, const ArmVector& from, const ArmVector& to,
                                 StateChecker& checker, std::uint64_t seed,
                                 const SeedPaths& known = {});

  /// A path to one of several goals, that are drawn as the search asks for them; its index goes to
  /// `goal`.
  /// @param patience  how many times the usual iterations the trees may take.
  std::optional<JointPath> solveToAny(const Manipulator& arm, const ArmVector& from,
                                      const GoalSampler& goals, StateChecker& checker,
                                      std::uint64_t seed, std::uint32_t& goal,
                                      std::uint32_t patience = 1);

  /// How many searches by trees, which take the most time, have found nothing.
  std::uint32_t failedTrees() const { return failed_trees_; }

 private:
  MotionProblem problemOf(const Manipulator& arm, StateChecker& checker) const;
  std::vector<ArmVector> viasBetween(const Manipulator& arm, const ArmVector& from,
                                     const ArmVector& to) const;
  std::optional<JointPath> roadmapPath(const Manipulator& arm, const MotionProblem& motion,
                                       const ArmVector& from, const ArmVector& to,
                                       const std::vector<ArmVector>& known,
                                       std::uint32_t checks) const;
  std::optional<JointPath> treePath(const MotionProblem& motion, const ArmVector& from,
                                    const GoalSampler& goals, std::uint64_t seed,
                                    const SeedPaths& known, std::uint32_t& goal,
                                    std::uint32_t patience = 1);

  const FreeMotionSettings& settings_;
  const Deadline& deadline_;
  std::uint32_t failed_trees_ = 0;
};

}  // namespace handover
