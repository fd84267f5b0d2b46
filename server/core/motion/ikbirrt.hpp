// SPDX-License-Identifier: Apache-2.0
// IKBiRRT (Berenson, Srinivasa et al. 2009) on OMPL's RRTConnect: goals enter the goal tree during
// the search. Distances are Euclidean over the joints [rad].
#pragma once

#include "core/model/robot_model.hpp"

#include <handover/common/deadline.hpp>
#include <handover/common/result.hpp>

#include <cstdint>
#include <functional>
#include <vector>

namespace handover {

/// A joint-space polyline, in the order of the arm's joints.
struct JointPath {
  std::vector<ArmVector> waypoints;
};

/// One arm's planning problem. Callbacks are called from the calling thread only.
struct MotionProblem {
  ArmVector lower, upper;                         ///< finite, lower <= upper
  std::function<bool(const ArmVector& q)> valid;  ///< free of collision at q
  double resolution = 0.03;                       ///< largest joint step between checks [rad]
  /// If given, asked of a straight segment, its ends included, instead of `valid` at every
  /// `resolution`.
  std::function<bool(const ArmVector& from, const ArmVector& to)> valid_between;
  /// Corners that are made on purpose, by cuts and at via configurations, can be rounded by this
  /// [rad]: the parabola that passes a corner at that distance is valid, too. 0: not asked for.
  double rounding = 0;
  /// If given, moves a configuration the short way to where it keeps what bends the valid states
  /// into a thin sheet, like the tilt of a held object; false, q anything, if it does not get
  /// there. Trees then grow along that sheet (CBiRRT2, Berenson, Srinivasa et al. 2009): straight
  /// segments leave it.
  std::function<bool(ArmVector& q)> project{};
};

struct IkBiRrtSettings {
  std::uint64_t seed = 1;
  std::uint32_t max_iterations = 20'000;  ///< a count, never seconds
  double range = 1.0;                     ///< longest tree extension [rad]
  double projected_range = 0.25;          ///< the same where states are projected
  std::uint32_t direct_goals = 4;         ///< first goals tried by one straight segment
  std::uint32_t goal_period = 8;          ///< iterations from one goal drawn to the next
  /// While a tree has no more states, every second sample is at most so far from one of them in
  /// each joint [rad]. In our cells that leaves one search in five without a path of those that
  /// none was found for with far samples alone.
  std::size_t cramped_states = 20;
  double cramped_step = 0.7;
  /// Ways that were free in a world much like this one: on from the start, and back from the first
  /// valid goal. The trees begin with what is still free of them.
  std::vector<ArmVector> from_start{}, from_goal{};
};

/// The i-th goal configuration, drawn as the search asks for it; false when there are no more.
/// Calls come with i = 0, 1, 2, ... until false. Goals that are not finite, of another size,
/// outside the limits or invalid are skipped; each counts as an iteration while no goal has been
/// valid yet.
using GoalSampler = std::function<bool(std::uint32_t i, ArmVector& q)>;

/// A valid path from `start` to one of the goals, both to the bit; the goal index goes to `goal`.
/// kNoPath after the iteration budget or when every goal is invalid; kDeadline, kCancelled;
/// kInvalidInput: start or limits not finite, of different sizes or contradictory, start outside
/// the limits by more than 1e-9, resolution, range or goal_period <= 0; kInCollision: the start is
/// invalid. Same arguments, same answer, to the byte, whatever else the process plans. Safe from
/// any thread.
Result<JointPath> planIkBiRrt(const MotionProblem& problem, const ArmVector& start,
                              const GoalSampler& goals, const IkBiRrtSettings& settings,
                              const Deadline& deadline, std::uint32_t* goal = nullptr);

/// Shortens a valid path: the straight segment between its ends, else vertices left out, then
/// `attempts` seeded cuts. Never longer than `path`; every segment that is new was valid at the
/// problem's resolution; both ends are kept. A deadline ends it early with what it has.
JointPath shortcut(const MotionProblem& problem, const JointPath& path, std::uint64_t seed,
                   std::uint32_t attempts, const Deadline& deadline);

/// True when the straight joint segment is valid, ends included: as `valid_between` has it, else at
/// the problem's resolution.
bool segmentValid(const MotionProblem& problem, const ArmVector& from, const ArmVector& to);

/// True when the corner of two valid segments can be rounded as the problem asks for.
bool cornerValid(const MotionProblem& problem, const ArmVector& before, const ArmVector& corner,
                 const ArmVector& after);

}  // namespace handover
