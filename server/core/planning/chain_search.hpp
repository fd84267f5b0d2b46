// SPDX-License-Identifier: Apache-2.0
// The search of one request over candidates: for a chain of arms, handover poses and tuples of
// grasps, best first, until the motions of one exist ([paper] Alg. 2, 3, §IV-E).
#pragma once

#include "core/planning/explanation.hpp"
#include "core/planning/farthest.hpp"
#include "core/planning/plan_assembly.hpp"
#include "core/planning/plan_event_sink.hpp"
#include "core/planning/transport_motions.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

namespace handover {

/// How far the search goes from the paper's handover poses, in this order.
enum class SearchTier {
  kPaper,      ///< the object on the best lattice point, in the paper's orientation
  kTool,       ///< the receiver's tool on that point
  kTurned,     ///< further points, and turns about z_shoulder
  kScattered,  ///< points, turns and tilts off z_shoulder at random
};

/// What all chains of one request share. One per worker.
struct SearchState {
  SearchState(const TransportProblem& of, PlanEventSink& events, const Deadline& until)
      : problem(of),
        sink(events),
        deadline(until),
        world(of.collision),
        spare_world(of.collision) {}

  const TransportProblem& problem;
  PlanEventSink& sink;
  const Deadline& deadline;
  CollisionWorld world, spare_world;
  std::map<std::pair<RobotId, ArmId>, Manipulator> manipulators;  ///< by robot and arm
  PrunedByArm at_start, at_goal;
  SearchCounts counts;
  FarthestCandidate farthest;
  std::uint32_t motion_attempts = 0, grasp_attempts = 0;
  std::uint32_t failed_trees = 0;  ///< searches for a free motion that found nothing
  std::optional<TransportPlan> plan;
  TransportTuple tuple;             ///< of the plan
  std::vector<std::string> broken;  ///< rules that the plan breaks

  bool wide() const { return problem.search == SearchWidth::kWide; }

  bool spent() const {
    return motion_attempts >= problem.settings.motion_attempts ||
           grasp_attempts >= mostGraspAttempts() || failed_trees >= problem.settings.failed_trees;
  }

  std::uint32_t mostGraspAttempts() const {
    const SearchSettings& settings = problem.settings;
    return problem.task.chain.size() > 2 ? settings.grasp_attempts_inner : settings.grasp_attempts;
  }

  /// The deadline is over: the search ends, wherever it is.
  bool over() const { return deadline.over(); }

  /// Nobody listens any more; a deadline's answer still tells what was counted.
  bool cancelled() const { return deadline.state() == Deadline::State::kCancelled; }

  const Manipulator& manipulator(const ChainHolder& arm);
};

/// The choices that a failed stage depends on.
struct FailureScope {
  /// The stage depends on this handover and those after it; the number of handovers: on the last
  /// holder's grasp alone.
  std::size_t handover = 0;
  bool pose = false;  ///< on the pose and the receiver's grasp there, whatever the giver's grasp

  bool ofPlacing(std::size_t holders) const { return pose && handover + 1 == holders; }

  bool operator==(const FailureScope&) const = default;
};

/// What has to be chosen anew after a failure in a chain of `holders`.
FailureScope failureScope(const MotionFailure& failure, std::size_t holders);

/// Candidates of one chain of arms.
class ChainSearch {
 public:
  ChainSearch(SearchState& state, const std::vector<ChainHolder>& arms);
  ~ChainSearch();

  /// Prunes the grasps of the first holder at the start and of the last one at the goal, each arm's
  /// once; false when nothing is left of one of the sets, or two arms have no point in common.
  bool open();

  /// Goes through the tier's candidates, best placing first; true when the state has a plan.
  bool search(SearchTier tier);

  std::size_t holders() const { return motions_.holders().size(); }

  /// Where a handover's giver and receiver may meet, the best points first.
  const std::vector<LatticePoint>& points(std::size_t handover);

  const std::vector<ChainHolder>& arms() const { return arms_; }

 private:
  struct Lattice;
  struct Node;
  struct Candidate;

  const Manipulator& at(std::size_t holder) const { return *motions_.holders()[holder]; }

  bool spent() const {
    return state_.spent() || inner_poses_ >= settings_.most_inner_poses || noEndsLeft() ||
           motions_.failedWays() >= settings_.failed_ways || (!counted() && looksSpent());
  }

  /// Counted as the paper counts: before any motion is looked for.
  bool counted() const { return state_.problem.mode == SearchMode::kAll; }

  bool looksSpent() const {
    return dear_poses_ >= settings_.most_looks ||
           motions_.ikLooks() >= settings_.most_ik_looks / std::max(1u, state_.counts.chains);
  }

  bool noEndsLeft() const;

  const PrunedGrasps& pruned(std::size_t holder, PruningPlace place);
  const Lattice& latticeOf(std::size_t handover);
  double maxToolSeparation(std::size_t handover) const;
  bool mayMeet() const;
  bool apart();
  const PrunedGrasps& takesOf(std::size_t handover);

  bool searchSingle();
  bool searchLast(SearchTier tier);
  bool searchPoints(SearchTier tier, std::size_t first, std::size_t end, std::uint32_t most_poses,
                    HandoverCandidates& counts);
  bool searchScattered(HandoverCandidates& counts);
  bool searchScattered(HandoverCandidates& counts, std::uint32_t& not_in_map);
  bool tryCandidate(SearchTier tier, const Candidate& candidate, HandoverCandidates& counts);
  bool crowded(const Eigen::Vector3d& p_W) const;
  bool searchInner(std::size_t handover, Node& node);
  bool tryPose(std::size_t handover, Node& node, const Pose& X_WH, HandoverCandidates& counts);
  bool followInner(std::size_t handover, const TransportTuple& tuple, const PrunedGrasps& give);
  bool connectFirst(TransportTuple tuple, const PrunedGrasps& give);
  bool tryTuples(std::vector<TransportTuple> tuples, std::size_t most);
  bool backOut(std::size_t handover, bool& pose_dropped);
  void countFailure(const MotionFailure& failure, const TransportTuple& tuple);
  void failPick(int pick);
  void dropEnd(const StageRef& stage, int pick, int place);
  void tryTakes();
  void countTrees();
  bool mapAllows(std::size_t point, const ApproachOffset& offset);
  void finishCounts(HandoverCandidates counts);

  // What the search remembers of candidates that fell: the farthest is shown with a failure.
  FarthestTool toolOf(std::size_t holder, int grasp, const Pose& X_WO) const;
  void fellAtEnd(PruningPlace place, const PrunedGrasps& pruned);
  void fellAtHandover(SearchProgress progress, std::size_t handover, const Pose& X_WH, int receive,
                      int give);
  void fellInMotion(SearchStep step, const MotionFailure& failure, const TransportTuple& tuple);

  SearchState& state_;
  const SearchSettings& settings_;
  std::vector<ChainHolder> arms_;
  TransportMotions motions_;
  std::vector<std::unique_ptr<Lattice>> lattices_;        ///< by handover
  std::vector<std::unique_ptr<PrunedGrasps>> all_takes_;  ///< by handover
  /// Handover and receiver's grasp: how often no pose was found for it.
  std::map<std::pair<std::size_t, int>, std::uint32_t> inner_failures_;
  std::uint32_t inner_poses_ = 0;
  std::uint32_t trees_seen_ = 0;              ///< of the motions' failed ones, already in the state
  std::uint32_t dear_poses_ = 0;              ///< whose collisions were looked at
  std::vector<std::uint64_t> receiver_bins_;  ///< by point of the last handover's lattice
  PrunedGrasps takes_left_;      ///< of the first holder, without those that cannot be taken
  std::set<int> failed_picks_;   ///< grasps of the first holder that cannot be taken
  std::set<int> failed_places_;  ///< grasps of the last holder that cannot be placed
  /// Where the search goes on after a failure that nothing below can mend.
  std::optional<FailureScope> back_to_;
  Eigen::Vector3d point_ = Eigen::Vector3d::Zero();  ///< of the last handover, under way
  std::vector<Eigen::Vector3d> failed_at_;           ///< points whose motions failed
  std::set<int> receivers_;  ///< grasps of the last holder with a pose, for the counts
  std::vector<const FeasibleGrasp*> place_order_;   ///< 𝒢_r, most dexterous placing first
  CauseTally rejects_;                              ///< of the tier under way
  std::vector<std::vector<TransportTuple>> poses_;  ///< mode all: tuples by pose, as found
};

}  // namespace handover
