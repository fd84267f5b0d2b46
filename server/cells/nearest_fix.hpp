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

/// Every move but none, after which a ball of the moved robot meets one of the other's, in rising
/// cost; ties by turn, i, j.
/// @param p_WB  the moved robot's base; its balls as it stands now.
std::vector<BaseMove> movesByCost(const Eigen::Vector3d& p_WB, const std::vector<ReachBall>& moved,
                                  const std::vector<ReachBall>& other);

/// The override that makes the move: the base as a whole, in the world.
Override overrideOf(const BaseMove& move, const SceneRobot& robot);

struct NearestFix {
  std::vector<Override> overrides;  ///< empty: none was found
  std::string text;                 ///< what was tried and found, for people
};

/// Tries moves of the receiver, a list of movesByCost(), until one gives a plan.
/// @param maps_allow  whether the reachability maps leave the moved cell a chance; cheap.
/// @param plans       whether the moved cell has a plan; asked at most 200 times.
/// Stops early, saying so, when the deadline is over.
NearestFix findNearestFix(const SceneRobot& receiver, const std::vector<BaseMove>& moves,
                          const std::function<bool(const Override&)>& maps_allow,
                          const std::function<bool(const Override&)>& plans,
                          const Deadline& deadline);

}  // namespace handover
