// SPDX-License-Identifier: Apache-2.0
#include "core/planning/workspaces.hpp"

#include "core/planning/arm_selection.hpp"
#include "core/planning/manipulator.hpp"

#include <handover/common/check.hpp>

#include <algorithm>
#include <cmath>

namespace handover {
namespace {

constexpr int kMostHalfWidth = 90;   // cells from the shoulder: squares within bounds::kSliceCells
constexpr double kScoreStep = 1e-6;  // scores are rounded to it: the file says them in few digits

/// A place in a chain, as the task leaves it open.
using Place = std::optional<ChainHolder>;

std::vector<Place> placesOf(const TransportProblem& problem) {
  std::vector<Place> places(problem.task.chain.begin(), problem.task.chain.end());
  if (places.empty()) places.emplace_back();
  if (problem.task.held_by) places.insert(places.begin(), problem.task.held_by);
  return places;
}

double shoulderHeight(const TransportProblem& problem, const Place& place) {
  double sum = 0;
  const std::vector<ChainHolder> arms = fitArms(problem, place);
  for (const ChainHolder& arm : arms) {
    sum += makeManipulator(problem, arm.robot, arm.arm).map.p_WShoulder.z();
  }
  return arms.empty() ? problem.task.X_WO_start.translation().z()
                      : sum / static_cast<double>(arms.size());
}

double heightOf(const TransportProblem& problem, const std::vector<Place>& places,
                const Failed& failed) {
  if (failed.explanation.farthest) return failed.explanation.farthest->X_WO.xyz[2];
  switch (failed.reason) {
    case FailureReason::kStartUnreachable:
    case FailureReason::kNoGraspAtStart:
    case FailureReason::kStartInCollision:
    case FailureReason::kStartUnsupported:
    case FailureReason::kNoGrasp:
      return problem.task.X_WO_start.translation().z();
    case FailureReason::kGoalUnreachable:
    case FailureReason::kNoGraspAtGoal:
    case FailureReason::kGoalInCollision:
    case FailureReason::kGoalUnsupported:
      return problem.task.X_WO_goal.translation().z();
    case FailureReason::kUnspecified:
    case FailureReason::kNoCommonWorkspace:
    case FailureReason::kNoHandoverPose:
    case FailureReason::kNoPath:
    case FailureReason::kDeadline:
    case FailureReason::kInternal:
      break;
  }
  return 0.5 * (shoulderHeight(problem, places.front()) + shoulderHeight(problem, places.back()));
}

int cellOf(double coordinate) { return static_cast<int>(std::floor(coordinate / kLatticeEdge)); }

double centreOf(int cell) { return kLatticeEdge * (cell + 0.5); }

ReachSlice sliceOf(const Manipulator& arm, double z) {
  ReachSlice slice;
  slice.arm = arm.name();
  slice.tool_link = arm.toolLink();
  const Eigen::Vector3d& shoulder = arm.map.p_WShoulder;
  const double reach = arm.map.map->reach(arm.map.X_WA.inverse() * shoulder);
  const double up = std::abs(z - shoulder.z());
  if (up >= reach) return slice;
  const int half =
      std::min(kMostHalfWidth,
               static_cast<int>(std::ceil(std::sqrt(reach * reach - up * up) / kLatticeEdge)));
  const int i_first = cellOf(shoulder.x()) - half, j_first = cellOf(shoulder.y()) - half;
  slice.first = {centreOf(i_first), centreOf(j_first)};
  slice.columns = static_cast<std::uint32_t>(2 * half + 1);
  for (int j = j_first; j <= j_first + 2 * half; ++j) {
    for (int i = i_first; i <= i_first + 2 * half; ++i) {
      const double score = arm.map({centreOf(i), centreOf(j), z});
      slice.scores.push_back(std::round(score / kScoreStep) * kScoreStep);
    }
  }
  return slice;
}

}  // namespace

Workspaces workspacesOf(const TransportProblem& problem, const Failed& failed) {
  static_assert((2 * kMostHalfWidth + 1) * (2 * kMostHalfWidth + 1) <= bounds::kSliceCells);
  const std::vector<Place> places = placesOf(problem);
  Workspaces workspaces{.z = heightOf(problem, places, failed), .slices = {}};
  std::vector<ChainHolder> arms;
  for (const Place& place : places) {
    for (const ChainHolder& arm : fitArms(problem, place)) {
      if (std::find(arms.begin(), arms.end(), arm) == arms.end()) arms.push_back(arm);
    }
  }
  if (arms.size() > bounds::kSlices) arms.resize(bounds::kSlices);
  for (const ChainHolder& arm : arms) {
    workspaces.slices.push_back(
        sliceOf(makeManipulator(problem, arm.robot, arm.arm), workspaces.z));
  }
  return workspaces;
}

}  // namespace handover
