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

/// One voxel. Directions: 64 bins of the approach axis in A (see directionBin()), bit set =
/// reached.
struct ReachabilityVoxel {
  float manipulability = 0;  ///< mean over the samples; 0 = not reached
  std::uint32_t samples = 0;
  std::uint64_t directions = 0;
  std::array<float, 8> q_seed{};  ///< the sample of highest manipulability
};

/// Bin (0..63) of a unit direction in A: 8 x 8 equal-area bins (z by azimuth).
int directionBin(const Eigen::Vector3d& direction_A);

/// Immutable, memory-mapped. Safe from any thread.
class ReachabilityMap {
 public:
  /// Called with the fraction done in [0, 1].
  using Progress = std::function<void(double)>;
  /// True when the arm at q touches itself or its rigid torso; such samples are left out.
  using SelfCollision = std::function<bool(const ArmVector&)>;

  /// Hash of all that decides a map's content: chain, limits, rigid torso's shapes, parameters.
  static std::uint64_t hash(const RobotModel& model, int arm, const RobotVector& q_torso,
                            const ReachabilityParams& params);

  /// Samples and writes a map: to a temporary name, then renamed. kCancelled/kIo on trouble.
  static Result<bool> build(const RobotModel& model, int arm, const RobotVector& q_torso,
                            const ReachabilityParams& params, const SelfCollision& self_collision,
                            const std::filesystem::path& file, const Progress& progress,
                            const Deadline& deadline);

  /// Maps a file. kNotFound: no file; kInvalidInput: magic, version, hash or checksum do not fit.
  static Result<std::shared_ptr<const ReachabilityMap>> open(const std::filesystem::path& file,
                                                             std::uint64_t expected_hash);
  ~ReachabilityMap();

  /// The voxel of a point in A, or nullptr where the arm does not reach.
  const ReachabilityVoxel* find(const Eigen::Vector3d& p_A) const;
  /// The voxel's mean manipulability, 0 where not reached (paper's R).
  double operator()(const Eigen::Vector3d& p_A) const;

  double voxelSize() const;
  std::size_t filledVoxels() const;

 private:
  ReachabilityMap();
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace handover
