// SPDX-License-Identifier: Apache-2.0
#include "core/reachability/map_sampler.hpp"

#include <handover/common/atomic_file.hpp>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace handover {

using reachability::FileHeader;
using reachability::MapContents;
using reachability::MapSampler;

namespace {

Error invalid(std::string what) { return {ErrorCode::kInvalidInput, std::move(what)}; }

std::optional<Error> faultOf(const std::vector<ArmKinematics>& arms,
                             const ReachabilityParams& params) {
  for (const ArmKinematics& arm : arms) {
    const double half = reachability::VoxelGatherer::halfSize(arm.reach(), params.voxel);
    const double cells = 8 * half * half * half;
    if (!(params.voxel > 0) || !std::isfinite(params.voxel) ||
        !(cells <= static_cast<double>(reachability::kMostCells))) {
      return invalid("a voxel of " + std::to_string(params.voxel) +
                     " m does not divide the reach of " + std::to_string(arm.reach()) +
                     " m sensibly");
    }
  }
  if (params.samples < 1 || params.samples > std::numeric_limits<std::uint32_t>::max()) {
    return invalid("a map needs 1 to 4294967295 samples");
  }
  return std::nullopt;
}

}  // namespace

Result<std::vector<MapReport>> ReachabilityMap::build(
    const RobotModel& model, const RobotVector& q_torso, const ReachabilityParams& params,
    const std::vector<SelfCollision>& self_collision,
    const std::vector<std::filesystem::path>& files, const Progress& progress,
    const Deadline& deadline) {
  if (files.size() != model.arms.size() ||
      (!self_collision.empty() && self_collision.size() != model.arms.size())) {
    throw std::invalid_argument(
        "maps are made for all arms of a robot: one file and one "
        "self-collision test each");
  }
  std::vector<ArmKinematics> arms;
  for (const ArmId arm : IdRange<ArmId>(files.size())) arms.emplace_back(model, arm);
  if (const auto fault = faultOf(arms, params)) return *fault;

  MapSampler sampler(model, q_torso, params, self_collision, std::move(arms));
  if (const auto stopped = sampler.sample(progress, deadline)) return *stopped;
  std::vector<MapReport> reports;
  for (std::size_t arm = 0; arm < files.size(); ++arm) {
    reports.push_back(sampler.report(arm));
    const MapContents contents = sampler.contents(arm);
    FileHeader header;
    header.hash = hash(model, ArmId(arm), q_torso, params);
    header.voxel = params.voxel;
    header.samples = params.samples;
    header.accepted = reports.back().accepted;
    header.seed = params.seed;
    header.first = contents.first;
    header.size = contents.size;
    header.dofs = static_cast<std::uint32_t>(model.arms[arm].joints.size());
    auto bytes = reachability::mapFileBytes(header, contents.index, contents.voxels);
    const auto written = writeFileAtomically(files[arm], bytes);
    if (!written) reports.back().not_kept = written.error().detail;
    const auto map = of(std::move(bytes), header.hash);
    if (!map) return map.error();
    reports.back().map = *map;
  }
  if (progress) progress(1);
  return reports;
}

}  // namespace handover
