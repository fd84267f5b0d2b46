// SPDX-License-Identifier: Apache-2.0
// What would help a request that failed: the least move of the receiver after which there is a
// plan.
#pragma once

#include "core/planning/plan_transport.hpp"

#include <handover/common/deadline.hpp>
#include <handover/common/plan_event.hpp>

#include <cstdint>
#include <functional>
#include <vector>

namespace handover {

/// A move of a robot's base on a lattice of 5 cm and 10 degrees in the world's plane.
struct BaseMove {
  int i = 0, j = 0;  ///< along x, y [5 cm]
  int turn = 0;      ///< about z [10 degrees], in (-18, 18]

  /// |dxy| + 0.5 m/rad |dyaw| [m]
  double cost() const;
  bool operator==(const BaseMove&) const = default;
};

/// The `most` cheapest moves, but none at all, after which a ball of the moved robot meets one of
/// the other's, in rising cost; ties by turn, i, j.
/// @param p_WB  the moved robot's base; its balls as it stands now.
/// @return none where the deadline is over.
std::vector<BaseMove> movesByCost(const Eigen::Vector3d& p_WB, const std::vector<ReachBall>& moved,
                                  const std::vector<ReachBall>& other, std::size_t most,
                                  const Deadline& deadline);

/// The override that makes the move: the base as a whole, in the world.
Override overrideOf(const BaseMove& move, const SceneRobot& robot);

/// What is asked of a cell with its receiver moved.
struct FixQuestions {
  /// How much the reachability maps promise, 0: nothing; cheap.
  std::function<std::size_t(const Override&)> promise;
  /// Whether it has a plan. Adds to `work` what it took to find out, in SearchEffort::work().
  std::function<bool(const Override&, std::uint64_t& work)> plans;
  /// Why the search is to end now, for people; empty: it is not. Asked before each of the others.
  std::function<std::string()> stop;
};

struct NearestFix {
  std::vector<Override> overrides;  ///< empty: none was found
  std::string text;                 ///< what was tried and found, for people
};

/// At most this is asked for one failure.
inline constexpr std::uint32_t kMostFixPlans = 20, kMostMapLooks = 2'000;
/// Work that any failure is worth: that of three quick plans with all that they may try.
inline constexpr std::uint64_t kLeastFixWork = 120'000;

/// Tries moves of the receiver, a list of movesByCost(), until one gives a plan: those first that
/// the maps promise more than those that failed.
/// @param most_work  no plan is begun beyond it: about that of the failed search.
NearestFix findNearestFix(const SceneRobot& receiver, const std::vector<BaseMove>& moves,
                          const FixQuestions& questions, std::uint64_t most_work);

}  // namespace handover
