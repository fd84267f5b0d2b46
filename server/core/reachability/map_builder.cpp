// SPDX-License-Identifier: Apache-2.0
#include "core/reachability/map_file.hpp"

#include <handover/common/random.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace handover {

using reachability::FileHeader;
using reachability::kMostCells;

namespace {

// Samples between two looks at the deadline: some ms, self-collision tests included.
constexpr std::uint64_t kBlock = 512;

/// Sample number `sample`: each joint uniform within its limits, whatever was drawn before.
ArmVector drawConfiguration(const ArmKinematics& arm, std::uint64_t seed, std::uint64_t sample) {
  ArmVector q(arm.dofs());
  for (int i = 0; i < arm.dofs(); ++i) {
    const double fraction = SeededRandom::toUnit(
        SeededRandom::bitsAt(seed, sample * 8 + static_cast<std::uint64_t>(i)));
    q[i] = arm.lower()[i] + fraction * (arm.upper()[i] - arm.lower()[i]);
  }
  return q;
}

/// What gathers in a voxel.
struct Gathered {
  double sum = 0, best = -1;
  std::uint32_t samples = 0;
  std::uint64_t directions = 0;
  std::array<float, 8> q_best{};
};

/// A grid about A's origin that holds every tool position; voxels get their place when first
/// reached.
class Gatherer {
 public:
  /// Half the grid's edge in voxels, for an arm that reaches that far.
  static double halfSize(double reach, double voxel) { return std::floor(reach / voxel) + 2; }

  Gatherer(double reach, double voxel)
      : half_(static_cast<int>(halfSize(reach, voxel))),
        size_(2 * half_),
        voxel_(voxel),
        index_(static_cast<std::size_t>(size_) * size_ * size_, -1) {}

  void add(const Eigen::Vector3d& p, double manipulability, int direction, const ArmVector& q) {
    const std::size_t cell =
        (cellAlong(p.x()) * size_ + cellAlong(p.y())) * size_ + cellAlong(p.z());
    if (index_[cell] < 0) {
      index_[cell] = static_cast<std::int32_t>(voxels_.size());
      voxels_.emplace_back();
    }
    Gathered& voxel = voxels_[static_cast<std::size_t>(index_[cell])];
    voxel.sum += manipulability;
    ++voxel.samples;
    voxel.directions |= std::uint64_t{1} << direction;
    if (manipulability > voxel.best) {
      voxel.best = manipulability;
      for (int i = 0; i < q.size(); ++i) voxel.q_best[i] = static_cast<float>(q[i]);
    }
  }

  /// The filled part: bounds into `header`, indices and voxels in grid order.
  void crop(FileHeader& header, std::vector<std::int32_t>& index,
            std::vector<ReachabilityVoxel>& voxels) const {
    std::array<int, 3> low{size_, size_, size_}, high{-1, -1, -1};
    forEachFilled([&](const std::array<int, 3>& at, const Gathered&) {
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], at[axis]);
        high[axis] = std::max(high[axis], at[axis]);
      }
    });
    if (voxels_.empty()) return;
    std::size_t cells = 1;
    for (int axis = 0; axis < 3; ++axis) {
      header.first[axis] = low[axis] - half_;
      header.size[axis] = high[axis] - low[axis] + 1;
      cells *= static_cast<std::size_t>(header.size[axis]);
    }
    index.assign(cells, -1);
    voxels.reserve(voxels_.size());
    forEachFilled([&](const std::array<int, 3>& at, const Gathered& gathered) {
      std::size_t cell = 0;
      for (int axis = 0; axis < 3; ++axis) {
        cell = cell * static_cast<std::size_t>(header.size[axis]) +
               static_cast<std::size_t>(at[axis] - low[axis]);
      }
      index[cell] = static_cast<std::int32_t>(voxels.size());
      voxels.push_back({static_cast<float>(gathered.sum / gathered.samples), gathered.samples,
                        gathered.directions, gathered.q_best});
    });
  }

 private:
  std::size_t cellAlong(double x) const {
    const int cell = static_cast<int>(std::floor(x / voxel_)) + half_;
    return static_cast<std::size_t>(cell);
  }

  template <typename Visit>
  void forEachFilled(const Visit& visit) const {
    std::size_t cell = 0;
    for (int i = 0; i < size_; ++i) {
      for (int j = 0; j < size_; ++j) {
        for (int k = 0; k < size_; ++k, ++cell) {
          if (index_[cell] >= 0) visit({i, j, k}, voxels_[static_cast<std::size_t>(index_[cell])]);
        }
      }
    }
  }

  int half_, size_;
  double voxel_;
  std::vector<std::int32_t> index_;
  std::vector<Gathered> voxels_;
};

Error stopped(const Deadline& deadline) {
  if (deadline.state() == Deadline::State::kPassed) {
    return {ErrorCode::kDeadline, "the deadline passed while the map was built"};
  }
  return {ErrorCode::kCancelled, "cancelled while the map was built"};
}

}  // namespace

Result<bool> ReachabilityMap::build(const RobotModel& model, int arm_index,
                                    const RobotVector& q_torso, const ReachabilityParams& params,
                                    const SelfCollision& self_collision,
                                    const std::filesystem::path& file, const Progress& progress,
                                    const Deadline& deadline) {
  const ArmKinematics arm(model, arm_index);
  const double half = Gatherer::halfSize(arm.reach(), params.voxel);
  const double cells = 8 * half * half * half;
  if (!(params.voxel > 0) || !std::isfinite(params.voxel) ||
      !(cells <= static_cast<double>(kMostCells))) {
    return Error{ErrorCode::kInvalidInput, "a voxel of " + std::to_string(params.voxel) +
                                               " m does not divide the reach of " +
                                               std::to_string(arm.reach()) + " m sensibly"};
  }
  if (params.samples < 1 || params.samples > std::numeric_limits<std::uint32_t>::max()) {
    return Error{ErrorCode::kInvalidInput, "a map needs 1 to 4294967295 samples"};
  }

  const Eigen::Vector3d approach_T = model.arms[static_cast<std::size_t>(arm_index)].approach_axis;
  Gatherer gatherer(arm.reach(), params.voxel);
  FileHeader header;
  ArmJacobian J;
  for (std::uint64_t sample = 0; sample < params.samples; ++sample) {
    if (sample % kBlock == 0) {
      if (deadline.over()) return stopped(deadline);
      if (progress) progress(static_cast<double>(sample) / static_cast<double>(params.samples));
    }
    const ArmVector q = drawConfiguration(arm, params.seed, sample);
    if (self_collision && self_collision(q)) continue;
    const Pose X_AT = arm.toolPose(q, J);
    gatherer.add(X_AT.translation(), manipulability(J), directionBin(X_AT.linear() * approach_T),
                 q);
    ++header.accepted;
  }

  header.hash = hash(model, arm_index, q_torso, params);
  header.voxel = params.voxel;
  header.samples = params.samples;
  header.seed = params.seed;
  header.dofs = static_cast<std::uint32_t>(arm.dofs());
  std::vector<std::int32_t> index;
  std::vector<ReachabilityVoxel> voxels;
  gatherer.crop(header, index, voxels);
  Result<bool> written = reachability::writeMapFile(file, header, index, voxels);
  if (written && progress) progress(1);
  return written;
}

}  // namespace handover
