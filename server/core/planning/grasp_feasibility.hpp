// SPDX-License-Identifier: Apache-2.0
// [paper] Alg. 1 PruneGrasps: the grasps with an IK solution free of collision, with their joint
// vectors.
#pragma once

#include "core/planning/cause_tally.hpp"
#include "core/planning/collision_context.hpp"

#include <functional>
#include <map>
#include <optional>
#include <vector>

namespace handover {

/// A grasp that survived at one object pose.
struct FeasibleGrasp {
  int grasp = -1;  ///< index in the manipulator's set
  /// Configurations that reach it, cheapest first; the first one is known to be free, those after
  /// it are untested.
  std::vector<ArmVector> configurations;
  double manipulability = 0;  ///< of the first
};

/// Where a grasp fell, in the order of the tests.
enum class PruneStep : std::uint32_t { kNone, kIk, kHand, kArm };

struct PrunedGrasps {
  std::vector<FeasibleGrasp> kept;  ///< by rising index in the set
  std::uint32_t tested = 0;
  CauseTally rejects;
  /// Of the rejected ones, the first of those that came farthest: its index in the set.
  int farthest = -1;
  PruneStep farthest_step = PruneStep::kNone;
  /// Every reject holds for all configurations of the arm: out of reach by a closed form, or the
  /// hand itself touches something. Else some configurations were not looked at.
  bool proven = true;

  /// By index in the set; nullptr if it did not survive.
  const FeasibleGrasp* find(int grasp) const;
};

/// What the hand does at the object: it comes open and closes there; it holds it and opens; it
/// holds it, no more.
enum class HandMove { kCloses, kOpens, kHolds };

/// Ranks the configurations of a grasp: the lowest cost is tried first.
using ConfigurationCost = std::function<double(int grasp, const ArmVector& q)>;

/// Grasps whose hand touches another hand that holds the object by a known grasp: both hands stand
/// still against the object, so that this is true at every pose of it. By index in the set.
using HandConflicts = std::map<int, BodyPair>;

struct PruneQuery {
  const Manipulator* manipulator = nullptr;
  CellState state{};  ///< all else as here, the object at its X_WO
  HandMove move = HandMove::kCloses;
  AllowedContacts open{}, closed{};  ///< of the open and the closed hand
  std::vector<int> candidates{};     ///< by index in the set; empty: all
  ConfigurationCost cost{};
  PruneEffort effort{};
  const Manipulator* other_hand = nullptr;  ///< that holds the object, too; nullptr: none
  HandConflicts* conflicts = nullptr;       ///< with it, found before; new ones are added
};

/// Prunes grasps. A grasp survives only if the hand is free both open and closed, and on the way
/// where it closes: the paper tests one posture. Each posture has a context, and so a world, of its
/// own: a world is set anew only when the grasp changes. Ends early when the deadline is over.
PrunedGrasps pruneGrasps(const PruneQuery& query, CollisionContext& open_context,
                         CollisionContext& closed_context, const CollisionScene& bodies,
                         const Deadline& deadline);

}  // namespace handover
