// SPDX-License-Identifier: Apache-2.0
// The 2 pi copies of revolute joints' angles within their limits.
#pragma once

#include "core/kinematics/chain.hpp"

#include <cmath>
#include <numbers>

namespace handover::kinematics {

inline constexpr double kTurn = 2 * std::numbers::pi;  ///< [rad]

/// angle + 2 pi k lies within the limits, widened by a slack, for k in [first, last].
struct Windings {
  double first = 0, last = -1;

  bool none() const { return last < first; }
};

inline Windings windings(double angle, double lower, double upper, double slack) {
  return {std::ceil((lower - slack - angle) / kTurn), std::floor((upper + slack - angle) / kTurn)};
}

/// Hands over the copy of q nearest to q_near, or with query.all_windings every copy, in rising
/// order with the last joint fastest, until `take` has had enough. Answers lie within the limits to
/// the last bit: what is over by rounding is cut.
struct CopiesTaken {
  int count = 0;  ///< 0 when q has no copy within the limits
  bool go_on = true;
};

CopiesTaken forEachEquivalent(const Chain& chain, const IkQuery& query, const ArmVector& q_near,
                              const ArmVector& q, const ArmKinematics::Take& take);

}  // namespace handover::kinematics
