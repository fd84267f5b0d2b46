// SPDX-License-Identifier: Apache-2.0
// [paper] §IV-A: voxels of the tool's position in frame A with the average manipulability of the
// random configurations that fell into them.
#pragma once

#include "core/kinematics/arm_kinematics.hpp"

#include <handover/common/deadline.hpp>
#include <handover/common/result.hpp>

#include <filesystem>
#include <functional>
#include <memory>
#include <span>

namespace handover {

struct ReachabilityParams {
  double voxel = 0.05;                ///< edge [m]
  std::uint64_t samples = 1'000'000;  ///< configurations uniform within limits
  std::uint64_t seed = 1;
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
  /// True when the arm at q touches itself or its rigid torso; such samples are left out.
  using SelfCollision = std::function<bool(const ArmVector&)>;

  /// Hash of all that decides a map's content: the chain and its limits, the shapes and standing
  /// joints of the arm, its open hand and everything that no other arm moves (as ArmSelfCollision
  /// tests them), the parameters. Lengths and angles count to 1e-9.
  /// @param q_torso  posture of the whole robot; its entries for arms and their hands do not
  /// matter.
  static std::uint64_t hash(const RobotModel& model, int arm, const RobotVector& q_torso,
                            const ReachabilityParams& params);

  /// Samples and writes a map: to a temporary name, synced, then renamed; missing folders are made.
  /// The bytes depend on the arguments alone. Sample n is the same whatever the others do, so a
  /// self-collision test only takes samples out.
  /// @return kInvalidInput for a voxel size or sample count without sense, kCancelled, kDeadline or
  /// kIo; no file is left or changed then.
  static Result<bool> build(const RobotModel& model, int arm, const RobotVector& q_torso,
                            const ReachabilityParams& params, const SelfCollision& self_collision,
                            const std::filesystem::path& file, const Progress& progress,
                            const Deadline& deadline);

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
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace handover
