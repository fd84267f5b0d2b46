// SPDX-License-Identifier: Apache-2.0
// [paper] Alg. 1 PruneGrasps: the grasps with an IK solution free of collision, with their joint
// vectors.
#pragma once

#include "core/handover/collision_context.hpp"
#include "core/handover/reject_tally.hpp"

#include <functional>
#include <optional>
#include <vector>

namespace handover {

/// A grasp that survived at one object pose.
struct FeasibleGrasp {
  int grasp = -1;  ///< index in the role's set
  /// Configurations that reach it, cheapest first; the first one is known to be free, those after
  /// it are untested.
  std::vector<ArmVector> configurations;
  double manipulability = 0;  ///< of the first
};

struct PrunedGrasps {
  std::vector<FeasibleGrasp> kept;  ///< by rising index in the set
  std::uint32_t tested = 0;
  RejectTally rejects;

  /// By index in the set; nullptr if it did not survive.
  const FeasibleGrasp* find(int grasp) const;
};

/// Tells what touches with a grasp, if anything: first of the hand at its pose, which all
/// configurations share, then of the rest of the arm at one of them.
class GraspTest {
 public:
  virtual ~GraspTest() = default;
  virtual std::optional<BodyPair> handTouches(const Grasp& grasp, const Pose& X_WT) = 0;
  /// @pre the hand is free.
  virtual std::optional<BodyPair> armTouches(const Grasp& grasp, const ArmVector& q) = 0;
};

/// How hard a free configuration of a grasp is looked for.
struct PruneEffort {
  int swivels = 8;                  ///< IkQuery::swivel_samples
  std::size_t configurations = 12;  ///< tested before the grasp is given up
};

/// Before it is said that a robot has no grasp at all.
inline constexpr PruneEffort kThoroughPruning{64, 512};

/// Ranks the configurations of a grasp: the lowest cost is tried first.
using ConfigurationCost = std::function<double(int grasp, const ArmVector& q)>;

/// How long [s] the slowest joint is under way between two configurations, at its speed limit.
double travelTime(const Manipulator& role, const ArmVector& from, const ArmVector& to);

/// Prunes a role's grasps (those in `candidates`, all if empty) with the object at X_WO.
PrunedGrasps pruneGrasps(const Manipulator& role, const CollisionScene& names, const Pose& X_WO,
                         const std::vector<int>& candidates, const ConfigurationCost& cost,
                         GraspTest& test, const PruneEffort& effort, const Deadline& deadline);

}  // namespace handover
