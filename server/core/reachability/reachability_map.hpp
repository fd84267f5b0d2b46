// SPDX-License-Identifier: Apache-2.0
// [paper] §IV-A: voxels of the tool's position in frame A with the average manipulability of the
// random configurations that fell into them.
#pragma once

#include "core/kinematics/arm_kinematics.hpp"

#include <handover/common/deadline.hpp>
#include <handover/common/result.hpp>

#include <array>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace handover {

class ReachabilityMap;

struct ReachabilityParams {
  double voxel = 0.05;                ///< edge [m]
  std::uint64_t samples = 1'000'000;  ///< configurations uniform within limits
  std::uint64_t seed = 1;
  /// Voxels in which two arms of the robot are as good to within so many standard errors get more
  /// samples, up to this count in each (or until the most draws are spent).
  std::uint32_t tie_samples = 200;
  double tie_errors = 3;
};

/// What was made of one arm's map.
struct MapReport {
  int image_of = -1;                ///< the earlier arm whose map it shares, mirrored; -1: its own
  std::string why_own;              ///< what differs from a mirror image of the last earlier arm
  std::uint64_t accepted = 0;       ///< samples in voxels
  std::size_t near_ties = 0;        ///< voxels in which another arm is as good, within the errors
  std::size_t near_ties_short = 0;  ///< of them with fewer than tie_samples after all
  std::shared_ptr<const ReachabilityMap> map;
  std::string not_kept;  ///< why there is no file of it; empty: there is
};

/// One voxel: [i, i+1) x [j, j+1) x [k, k+1) edges in A. Directions: 64 bins of the approach axis
/// in A (see directionBin()), bit set = reached.
struct ReachabilityVoxel {
  float manipulability = 0;  ///< mean over the samples; 0 = not reached
  std::uint32_t samples = 0;
  std::uint64_t directions = 0;
  std::array<float, 8> q_seed{};  ///< the sample of highest manipulability
};

/// Bin (0..63) of a unit direction in A: 8 x 8 equal-area bins (z by azimuth).
int directionBin(const Eigen::Vector3d& direction_A);

/// Immutable, in memory: what happens to its file later does not matter. Safe from any thread.
class ReachabilityMap {
 public:
  /// Called with the fraction done in [0, 1].
  using Progress = std::function<void(double)>;
  /// True when the arm at q touches itself or its rigid torso.
  using SelfCollision = std::function<bool(const ArmVector&)>;

  /// Hash of all that decides a map's content: for each arm of the robot (they share samples, and
  /// are compared) the chain and its limits, the shapes and standing joints of the arm, its open
  /// hand and everything that no other arm moves (as ArmSelfCollision tests them); the parameters.
  /// Lengths and angles count to 1e-9.
  /// @param q_torso  posture of the whole robot; its entries for arms and their hands do not
  /// matter.
  /// @throws std::invalid_argument, std::out_of_range for a posture of the wrong size, no such arm.
  static std::uint64_t hash(const RobotModel& model, ArmId arm, const RobotVector& q_torso,
                            const ReachabilityParams& params);

  /// Samples and writes the maps of all arms of a robot, each to a temporary name, synced, then
  /// renamed; missing folders are made. The bytes depend on the arguments alone.
  /// Arms that are mirror images (findArmMirror) and whose self-collision tests tell the same of
  /// all but 2 % of mirrored samples share one map: that of the first, mirrored, so that mirrored
  /// voxels have equal entries. Then voxels where two arms are about as good are sampled further
  /// (ReachabilityParams).
  /// @param self_collision  one per arm, or none.   @param files  one per arm.
  /// @return per arm what was made, in memory even where it could not be written; kInvalidInput for
  /// a voxel size or sample count without sense, kCancelled or kDeadline. A file is left as it was
  /// or is whole.
  /// @throws std::invalid_argument for another number of tests or files.
  static Result<std::vector<MapReport>> build(const RobotModel& model, const RobotVector& q_torso,
                                              const ReachabilityParams& params,
                                              const std::vector<SelfCollision>& self_collision,
                                              const std::vector<std::filesystem::path>& files,
                                              const Progress& progress, const Deadline& deadline);

  /// Reads a file. kNotFound: no file; kInvalidInput: magic, version, hash, checksum or any other
  /// part does not fit; kIo: it cannot be read.
  static Result<std::shared_ptr<const ReachabilityMap>> open(const std::filesystem::path& file,
                                                             std::uint64_t expected_hash);
  ~ReachabilityMap();

  /// The voxel of a point in A, or nullptr where the arm does not reach.
  const ReachabilityVoxel* find(const Eigen::Vector3d& p_A) const;
  /// The voxel's mean manipulability, 0 where not reached (paper's R).
  double operator()(const Eigen::Vector3d& p_A) const;

  /// Distance [m] from a point in A to the farthest that is reached, voxels whole.
  double reach(const Eigen::Vector3d& p_A) const;

  double voxelSize() const;
  std::size_t filledVoxels() const;

 private:
  ReachabilityMap();
  /// The bytes of a file; kInvalidInput as open().
  static Result<std::shared_ptr<const ReachabilityMap>> of(std::vector<std::byte> bytes,
                                                           std::uint64_t expected_hash);
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace handover
