// SPDX-License-Identifier: Apache-2.0
// Where everything is at a time of the plan: all running stages of all robots together.
#pragma once

#include "verify/hermite.hpp"
#include "verify/scene.hpp"

#include <cstddef>
#include <vector>

namespace handover::verify {

/// Places of the fourteen stages in the plan file.
enum StageIndex {
  kGiverReach,
  kGiverApproach,
  kGiverGrasp,
  kGiverLift,
  kGiverTransfer,
  kReceiverReach,
  kReceiverApproach,
  kReceiverGrasp,
  kGiverRelease,
  kGiverRetreat,
  kReceiverTransfer,
  kReceiverPlace,
  kReceiverRelease,
  kReceiverRetreat,
  kStages
};

/// "giver_reach", ... @pre 0 <= stage < kStages.
const char* stageName(int stage);

/// The cubic of one joint (column) between two samples. @pre the stage's times rise.
HermiteCubic cubicOf(const PlanEvent& stage, std::size_t segment, std::size_t joint);

/// Who carries O.
enum class Carrier { kNobodyAtStart, kGiver, kReceiver, kNobodyAtGoal };

/// Joint positions, link poses and object poses by time.
/// @pre the scene's stages passed checkStructure().
class Motion {
 public:
  explicit Motion(const Scene& scene);

  const Scene& scene() const { return scene_; }

  const PlanEvent& stage(int index) const {
    return scene_.plan.stages[static_cast<std::size_t>(index)];
  }

  /// Every joint of the robot at time T; mimic joints by their law.
  std::vector<double> jointsAt(int robot, double T) const;
  std::vector<Pose> linksAt(int robot, double T) const;
  Pose linkAt(int robot, int link, double T) const;

  /// Largest speed of every joint of the robot on [from, to].
  std::vector<double> topSpeeds(int robot, double from, double to) const;

  /// Whether the stage really moves the joint (mimic joints with their master).
  bool moves(int stage, int joint) const;

  /// giver_lift begins the giver's hold, giver_release the receiver's; receiver_place ends it.
  Carrier carrierAt(double T) const;

  const Hold& giverHold() const { return giver_hold_; }

  const Hold& receiverHold() const { return receiver_hold_; }

  /// X_WO as the giver (receiver) would have it at time T.
  Pose objectByGiver(double T) const;
  Pose objectByReceiver(double T) const;
  Pose objectAt(double T) const;
  /// Of any other object: standing, or with the link that it is attached to.
  Pose otherObjectAt(int object, double T) const;

 private:
  const Scene& scene_;
  Hold giver_hold_, receiver_hold_;
  std::vector<std::vector<int>> stages_of_robot_;          ///< by start
  std::vector<std::vector<std::size_t>> joint_of_column_;  ///< [stage][column]
  std::vector<std::vector<bool>> moved_;                   ///< [stage][joint]
};

}  // namespace handover::verify
