// SPDX-License-Identifier: Apache-2.0
// An oracle for the planner's failures: a search for a plan that shares the planner's tests and
// motions but not its choice of handover poses.
#pragma once

#include "core/planning/cause_tally.hpp"
#include "core/planning/transport_problem.hpp"

#include <optional>

namespace handover::dense {

/// A plan's handover, beside the paper's choice.
struct FoundPlan {
  ArmName giver, receiver;
  int giver_grasp = -1, receiver_grasp = -1;
  Eigen::Vector3d p_WTr = Eigen::Vector3d::Zero();  ///< the receiver's tool
  double from_midpoint = 0;  ///< of the tool to the midpoint of the shoulders [m]
  bool both_maps = false;    ///< both arms' maps reach the tool's place
  bool near_map = false;     ///< the receiver's map reaches it or a voxel next to it
  double tilt = 0;           ///< between the approach axis and z_shoulder [rad]
  double turn = 0;           ///< about z_shoulder, from the paper's rotation [rad]
  bool thorough = false;     ///< its motions took more than the planner's budget
};

/// Handover poses by the first test that they fail; cheap tests come before dear ones.
struct PoseCounts {
  std::uint64_t receiver_reaches_not = 0, giver_reaches_not = 0, receiver_touches = 0,
                receiver_comes_not = 0, giver_touches = 0, held_by_both = 0;
};

struct DenseAnswer {
  std::optional<FoundPlan> plan;
  std::uint64_t poses = 0;  ///< looked at
  std::uint64_t grid = 0;   ///< poses there are
  PoseCounts counts;
  CauseTally tuples;        ///< of poses held by both hands: where their motions ended
  CauseTally tuples_again;  ///< the same with the larger budget
  bool giver_grasps = false, receiver_grasps = false;  ///< at the start; at the goal
  /// The object cannot stand at its start or its goal: no pose was looked at.
  std::optional<Failed> invalid;
};

/// Looks at up to `most_poses` poses of a grid, in a random order that the problem's seed decides:
/// every pair of arms; the receiver's tool on a 2.5 cm lattice over the overlap of what the arms
/// reach; the paper's rotation turned by 15 degrees and tilted by up to 50, and 72 rotations evenly
/// over all; every grasp that the receiver can place with. Ends at the first plan.
/// @throws std::runtime_error for chains of other than two holders.
DenseAnswer searchDensely(const TransportProblem& problem, std::uint64_t most_poses);

}  // namespace handover::dense
