// SPDX-License-Identifier: Apache-2.0
// Samples the maps of all arms of a robot: mirrored arms from the same samples, and more samples
// where the choice between two arms is close.
#pragma once

#include "core/reachability/voxel_gatherer.hpp"

#include <optional>
#include <vector>

namespace handover::reachability {

class MapSampler {
 public:
  /// @param self_collision  one per arm, each may be empty; or none at all.
  /// @param arms  one per arm of the model. Everything given must outlive the sampler.
  MapSampler(const RobotModel& model, const RobotVector& q_torso, const ReachabilityParams& params,
             const std::vector<ReachabilityMap::SelfCollision>& self_collision,
             std::vector<ArmKinematics> arms);

  /// Draws every sample. kCancelled or kDeadline when stopped before the end.
  std::optional<Error> sample(const ReachabilityMap::Progress& progress, const Deadline& deadline);

  MapReport report(std::size_t arm) const;
  MapContents contents(std::size_t arm) const;

 private:
  /// An arm that shares a family's samples: its first (no mirror), or an image of that.
  struct Member {
    std::size_t arm;
    std::optional<ArmMirror> mirror;
  };

  /// Arms with one map, kept in the base frame of the first.
  struct Family {
    std::vector<Member> members;
    VoxelGatherer gatherer;
    std::uint64_t accepted = 0;
    double relative_deviation = 0;  ///< of a sample within its voxel, over the voxels
    std::vector<bool> near_tie;     ///< per voxel
  };

  /// Where an arm's map is found.
  struct Seat {
    std::size_t family = 0, member = 0;
    Pose X_BA = Pose::Identity();  ///< of the arm's base frame in the robot's root
    std::string why_own;  ///< why it is not an image of an earlier arm; "": it is, or first
  };

  bool touches(std::size_t arm, const ArmVector& q) const;

  std::size_t first(const Family& family) const { return family.members.front().arm; }

  MapSample sampleAt(std::size_t arm, const ArmVector& q) const;
  ArmVector draw(std::size_t arm, std::uint64_t sample) const;

  /// Why the image's shapes do not allow to share the map; "": they do.
  std::string shapesDiffer(std::size_t arm, const Member& image) const;

  std::optional<Error> sampleAll(Family& family, const std::function<void(double)>& done,
                                 const Deadline& deadline);
  void findNearTies();
  void compare(std::size_t arm, std::size_t other);
  double squaredError(const Family& family, const Gathered& voxel) const;
  std::int32_t voxelAt(std::size_t arm, const Eigen::Vector3d& p_B) const;
  std::optional<Error> refine(Family& family, std::uint64_t pass, const Deadline& deadline);

  const RobotModel& model_;
  const ReachabilityParams& params_;
  const std::vector<ReachabilityMap::SelfCollision>& self_collision_;
  std::vector<ArmKinematics> arms_;
  std::vector<Family> families_;
  std::vector<Seat> seats_;  ///< per arm
};

}  // namespace handover::reachability
