// SPDX-License-Identifier: Apache-2.0
// Inverse kinematics of any chain by least squares, from starts that are already near: a table of
// random configurations with their tool poses, made once per arm. (A reachability map's seeds know
// the position of the tool but not its rotation: from these, fewer starts arrive.)
#pragma once

#include "core/kinematics/chain.hpp"

#include <array>
#include <vector>

namespace handover::kinematics {

class IterativeSolver {
 public:
  explicit IterativeSolver(const Chain& chain);

  /// As ArmKinematics::visit.
  IkCounts visit(const Chain& chain, const Pose& X_AT, const IkQuery& query,
                 const ArmVector& q_near, const ArmKinematics::Take& take) const;

 private:
  /// The `count` configurations whose tool poses are nearest to X_AT, nearest first.
  std::vector<int> nearest(const Pose& X_AT, std::size_t count) const;

  std::vector<ArmVector> configurations_;
  /// Their tool poses, an array per number so that the search runs over plain memory: position over
  /// a length that makes metres comparable to radians, and quaternion.
  std::array<std::vector<float>, 7> poses_;
  double length_ = 1;  ///< [m]
};

}  // namespace handover::kinematics
