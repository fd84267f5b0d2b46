// SPDX-License-Identifier: Apache-2.0
#include "core/planning/chain_search.hpp"

#include "core/planning/plan_cost.hpp"
#include "core/planning/plan_rules.hpp"

#include <handover/common/check.hpp>
#include <handover/common/random.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace handover {
namespace {

/// The turns about z_shoulder that a tier looks at.
std::vector<ApproachOffset> turnsOf(SearchTier tier, const SearchSettings& settings) {
  if (tier != SearchTier::kTurned) return {{}};
  std::vector<ApproachOffset> all;
  for (int turn = 0; turn < settings.wide_turns; ++turn) {
    all.push_back({2 * M_PI * turn / settings.wide_turns, 0, 0});
  }
  return all;
}

/// The points as an event carries them, cut at what it may carry.
std::vector<LatticeCell> cellsOf(const std::vector<LatticePoint>& points) {
  std::vector<LatticeCell> cells(std::min(points.size(), bounds::kLattice));
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Eigen::Vector3d& p_W = points[i].p_W;
    cells[i] = {{p_W.x(), p_W.y(), p_W.z()}, points[i].manipulability};
  }
  return cells;
}

double manipulabilityOf(const TransportTuple& tuple) {
  return tuple.holders.back().give.manipulability;
}

}  // namespace

const Manipulator& SearchState::manipulator(const ChainHolder& arm) {
  const auto [entry, fresh] = manipulators.try_emplace({arm.robot, arm.arm});
  if (fresh) entry->second = makeManipulator(problem, arm.robot, arm.arm);
  return entry->second;
}

/// Places of one handover.
struct ChainSearch::Lattice {
  std::vector<LatticePoint> both;  ///< in reach of both arms by their maps, best first
  std::vector<LatticePoint> all;   ///< these, then where only the receiver's map says so
};

/// Part of a tuple, from the last holder back.
struct ChainSearch::Node {
  TransportTuple tuple;                 ///< set from the handover's receiver on, its take apart
  const FeasibleGrasp* give = nullptr;  ///< the receiver's grasp where it gives the object on
  Pose X_WO_give = Pose::Identity();    ///< the object there
  std::set<int>* receivers = nullptr;   ///< grasps of the receiver with a pose, for the counts
};

/// A handover pose to be tried at the last handover.
struct ChainSearch::Candidate {
  ApproachOffset offset;
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();  ///< of the receiver's tool, or of the object
  const FeasibleGrasp* place = nullptr;
};

FailureScope failureScope(const MotionFailure& failure, std::size_t holders) {
  const std::size_t k = failure.stage.holder;
  const bool last = k + 1 == holders;
  if (last && failure.cause == Cause::kStraightApproach) return {k, true};
  switch (failure.stage.action) {
    case StageAction::kCarry:
      return k == 0 ? FailureScope{0, false} : FailureScope{k - 1, true};
    case StageAction::kReach:
    case StageAction::kApproach:
    case StageAction::kGrasp:
      return {k == 0 ? 0 : k - 1, false};
    default:
      return {k, last};
  }
}

namespace {

std::vector<const Manipulator*> manipulatorsOf(SearchState& state,
                                               const std::vector<ChainHolder>& arms) {
  std::vector<const Manipulator*> holders;
  for (const ChainHolder& arm : arms) holders.push_back(&state.manipulator(arm));
  return holders;
}

}  // namespace

ChainSearch::ChainSearch(SearchState& state, const std::vector<ChainHolder>& arms)
    : state_(state),
      settings_(state.problem.settings),
      arms_(arms),
      motions_(state.problem, manipulatorsOf(state, arms), state.world, state.spare_world,
               state.deadline),
      lattices_(arms.size()),
      all_takes_(arms.size()) {}

ChainSearch::~ChainSearch() = default;

const PrunedGrasps& ChainSearch::pruned(std::size_t holder, PruningPlace place) {
  const bool start = place == PruningPlace::kStart;
  PrunedByArm& sets = start ? state_.at_start : state_.at_goal;
  const ArmName arm = at(holder).name();
  const auto [entry, fresh] = sets.try_emplace(arm);
  if (!fresh) return entry->second;
  const auto prune = [&](const PruneEffort& effort) {
    return start ? motions_.pruneFirstAtStart(effort) : motions_.pruneLastAtGoal(effort);
  };
  entry->second = prune(settings_.pruning);
  if (state_.wide() && noneKept(sets)) entry->second = prune(settings_.thorough_pruning);
  if (entry->second.kept.empty()) fellAtEnd(place, entry->second);
  if (state_.cancelled()) return entry->second;
  state_.sink.emit(GraspsPruned{
      arm, static_cast<std::uint32_t>(holder), place, entry->second.tested,
      static_cast<std::uint32_t>(entry->second.kept.size()), entry->second.rejects.counts()});
  return entry->second;
}

FarthestTool ChainSearch::toolOf(std::size_t holder, int grasp, const Pose& X_WO) const {
  return {at(holder).name(), toValue(X_WO * at(holder).grasp(grasp).X_OT)};
}

void ChainSearch::fellAtEnd(PruningPlace place, const PrunedGrasps& pruned) {
  if (pruned.farthest < 0) return;
  const bool start = place == PruningPlace::kStart;
  const std::size_t holder = start ? 0 : holders() - 1;
  const auto within = static_cast<std::uint32_t>(pruned.farthest_step);
  state_.farthest.offer({start ? SearchStep::kTake : SearchStep::kGive, within}, [&] {
    const SceneTask& task = state_.problem.task;
    const Pose& X_WO = start ? task.X_WO_start : task.X_WO_goal;
    const StageAction end =
        task.end == TransportEnd::kHold ? StageAction::kCarry : StageAction::kPlace;
    return Farthest{toValue(X_WO),
                    {toolOf(holder, pruned.farthest, X_WO)},
                    {static_cast<std::uint32_t>(holder), start ? StageAction::kGrasp : end}};
  });
}

/// @param receive, give  grasps in the arms' sets; negative: none to show.
void ChainSearch::fellAtHandover(SearchProgress progress, std::size_t handover, const Pose& X_WH,
                                 int receive, int give) {
  state_.farthest.offer(progress, [&] {
    const auto receiver = static_cast<std::uint32_t>(handover + 1);
    Farthest farthest{toValue(X_WH), {}, {receiver, StageAction::kGrasp}};
    if (give >= 0) farthest.tools.push_back(toolOf(handover, give, X_WH));
    if (receive >= 0) farthest.tools.push_back(toolOf(handover + 1, receive, X_WH));
    return farthest;
  });
}

void ChainSearch::fellInMotion(SearchStep step, const MotionFailure& failure,
                               const TransportTuple& tuple) {
  const std::size_t last = holders() - 1;
  const std::size_t k = failure.stage.holder;
  const StageAction action = failure.stage.action;
  // The stages as the search for motions goes through them: the end, then from the start on.
  const bool end = k == last && failure.cause == Cause::kStraightApproach;
  const std::uint32_t within =
      end ? 0 : 16 * failure.stage.holder + static_cast<std::uint32_t>(action);
  state_.farthest.offer({step, within}, [&] {
    const bool taking = action < StageAction::kCarry;
    const SceneTask& task = state_.problem.task;
    if (taking && k == 0) {
      return Farthest{toValue(task.X_WO_start),
                      {toolOf(0, tuple.holders[0].take.grasp, task.X_WO_start)},
                      failure.stage};
    }
    if (!taking && k == last) {
      return Farthest{toValue(task.X_WO_goal),
                      {toolOf(last, tuple.holders[last].give.grasp, task.X_WO_goal)},
                      failure.stage};
    }
    const std::size_t handover = taking ? k - 1 : k;
    const Pose& X_WH = tuple.X_WH[handover];
    return Farthest{toValue(X_WH),
                    {toolOf(handover, tuple.holders[handover].give.grasp, X_WH),
                     toolOf(handover + 1, tuple.holders[handover + 1].take.grasp, X_WH)},
                    failure.stage};
  });
}

bool ChainSearch::open() {
  if (pruned(0, PruningPlace::kStart).kept.empty()) return false;
  takes_left_.kept = pruned(0, PruningPlace::kStart).kept;
  const PrunedGrasps& placed = pruned(holders() - 1, PruningPlace::kGoal);
  if (placed.kept.empty() || state_.over()) return false;
  for (const auto& grasp : placed.kept) place_order_.push_back(&grasp);
  std::stable_sort(place_order_.begin(), place_order_.end(),
                   [](const FeasibleGrasp* a, const FeasibleGrasp* b) {
                     return a->manipulability > b->manipulability;
                   });
  std::size_t points = holders() > 1 ? std::numeric_limits<std::uint32_t>::max() : 0;
  bool any = true;
  for (std::size_t k = 0; k + 1 < holders(); ++k) {
    points = std::min(points, latticeOf(k).both.size());
    any = any && !latticeOf(k).all.empty();
  }
  SearchCounts& counts = state_.counts;
  counts.lattice_points = std::max(counts.lattice_points, static_cast<std::uint32_t>(points));
  counts.may_meet = counts.may_meet || (holders() > 1 && mayMeet());
  ++counts.chains;
  return any;
}

/// False: two arms that follow each other are so far apart that no object can be in both hands.
bool ChainSearch::mayMeet() const {
  for (std::size_t k = 0; k + 1 < holders(); ++k) {
    const Manipulator &giver = at(k), &receiver = at(k + 1);
    const double between = (giver.map.X_WA.translation() - receiver.map.X_WA.translation()).norm();
    const double most =
        giver.kinematics->reach() + receiver.kinematics->reach() + maxToolSeparation(k);
    if (between > most) return false;
  }
  return true;
}

/// Two arms that follow each other have no lattice point in common.
bool ChainSearch::apart() {
  for (std::size_t k = 0; k + 1 < holders(); ++k) {
    if (latticeOf(k).both.empty()) return true;
  }
  return false;
}

/// How far apart [m] the tools of two hands at the object can be, at most.
double ChainSearch::maxToolSeparation(std::size_t handover) const {
  double apart = 0;
  for (const std::size_t holder : {handover, handover + 1}) {
    double most = 0;
    for (const Grasp& grasp : at(holder).grasps->grasps) {
      most = std::max(most, grasp.X_OT.translation().norm());
    }
    apart += most;
  }
  return apart;
}

const ChainSearch::Lattice& ChainSearch::latticeOf(std::size_t handover) {
  std::unique_ptr<Lattice>& lattice = lattices_[handover];
  if (lattice) return *lattice;
  lattice = std::make_unique<Lattice>();
  const Manipulator& giver = at(handover);
  const Manipulator& receiver = at(handover + 1);
  const bool same_robot = state_.wide() && giver.robot == receiver.robot;
  const double radius = same_robot ? settings_.same_robot_neighbourhood : settings_.neighbourhood;
  lattice->both = crossMaps(giver.map, receiver.map, radius);
  lattice->all = lattice->both;
  if (state_.wide() && !same_robot) {
    // Farther from the midpoint, where arms that stand far apart or askew meet.
    for (const LatticePoint& point :
         crossMaps(giver.map, receiver.map, settings_.wide_neighbourhood)) {
      const auto same = [&](const LatticePoint& it) { return it.p_W == point.p_W; };
      if (std::none_of(lattice->both.begin(), lattice->both.end(), same)) {
        lattice->all.push_back(point);
      }
    }
    const double reach = giver.kinematics->reach() + maxToolSeparation(handover);
    auto more = receiverPoints(giver.map, receiver.map, radius, reach);
    const Eigen::Vector3d middle = 0.5 * (giver.map.p_WShoulder + receiver.map.p_WShoulder);
    std::stable_sort(more.begin(), more.end(), [&](const auto& a, const auto& b) {
      return (a.p_W - middle).squaredNorm() < (b.p_W - middle).squaredNorm();
    });
    lattice->all.insert(lattice->all.end(), more.begin(), more.end());
  }
  return *lattice;
}

const std::vector<LatticePoint>& ChainSearch::points(std::size_t handover) {
  return latticeOf(handover).all;
}

/// The giver's grasps at a handover: those it can take the object with, as far as that is known.
const PrunedGrasps& ChainSearch::takesOf(std::size_t handover) {
  if (handover == 0) return takes_left_;
  std::unique_ptr<PrunedGrasps>& all = all_takes_[handover];
  if (!all) {
    all = std::make_unique<PrunedGrasps>();
    const int size = static_cast<int>(at(handover).grasps->grasps.size());
    for (int grasp = 0; grasp < size; ++grasp) all->kept.push_back({grasp, {}, 0});
  }
  return *all;
}

void ChainSearch::failPick(int pick) {
  failed_picks_.insert(pick);
  std::erase_if(takes_left_.kept, [&](const FeasibleGrasp& take) { return take.grasp == pick; });
}

/// Few grasps take the object: those that no motion leads to are left out before long searches. The
/// fewer they are, the more depends on each.
void ChainSearch::tryTakes() {
  if (counted() || state_.problem.task.held_by) return;
  const std::vector<FeasibleGrasp>& takes = pruned(0, PruningPlace::kStart).kept;
  if (takes.size() > settings_.few_takes) return;
  takes_left_.kept = takes;  // those that failed before get another try
  failed_picks_.clear();
  const auto patience = static_cast<std::uint32_t>(settings_.takes_patience / takes.size());
  for (const FeasibleGrasp& take : takes) {
    if (spent() || state_.over()) return;
    const bool can = motions_.canTake(take, patience);
    countTrees();
    if (can) continue;
    if (state_.over()) return;
    const MotionFailure failure{{0, StageAction::kReach}, Cause::kNoPath, {}};
    state_.counts.motion_rejects.add(failure.cause, failure.stage);
    state_.farthest.offer(
        {SearchStep::kMotions, static_cast<std::uint32_t>(StageAction::kReach)}, [&] {
          const Pose& X_WO = state_.problem.task.X_WO_start;
          return Farthest{toValue(X_WO), {toolOf(0, take.grasp, X_WO)}, failure.stage};
        });
    ++state_.motion_attempts;
    failPick(take.grasp);
  }
}

void ChainSearch::countTrees() {
  state_.failed_trees += motions_.failedTrees() - trees_seen_;
  trees_seen_ = motions_.failedTrees();
}

/// No grasp is left to take the object with, or none to put it down: no pose could change that.
bool ChainSearch::noEndsLeft() const {
  if (counted()) return false;
  return takes_left_.kept.empty() || failed_places_.size() == place_order_.size();
}

void ChainSearch::countFailure(const MotionFailure& failure, const TransportTuple& tuple) {
  state_.counts.motion_rejects.add(failure.cause, failure.stage, failure.pair);
  const bool meet = failure.cause == Cause::kHandsMeet;
  fellInMotion(meet ? SearchStep::kHandsMeet : SearchStep::kMotions, failure, tuple);
  if (meet) {
    ++state_.grasp_attempts;
    return;
  }
  ++state_.motion_attempts;
  const bool picking = failure.stage == StageRef{0, StageAction::kReach};
  const bool placing = failureScope(failure, holders()).ofPlacing(holders());
  if (!picking && !placing) failed_at_.push_back(point_);
}

/// After a failure below a handover: whether the handover's giver's grasp is to be left, at least.
/// @param pose_dropped  set: the pose, too.
bool ChainSearch::backOut(std::size_t handover, bool& pose_dropped) {
  if (!back_to_) return false;
  pose_dropped = back_to_->handover > handover || back_to_->pose;
  if (back_to_->handover == handover) back_to_.reset();
  return true;
}

/// How the object is taken depends on the first grasp alone, how it is left on the last: what
/// cannot be timed there cannot with any tuple.
void ChainSearch::dropEnd(const StageRef& stage, int pick, int place) {
  const StageAction action = stage.action;
  if (stage.holder == 0 && action < StageAction::kCarry) failPick(pick);
  const bool leaving = action == StageAction::kPlace || action == StageAction::kRetreat;
  if (stage.holder + 1 == holders() && leaving) failed_places_.insert(place);
}

bool ChainSearch::tryTuples(std::vector<TransportTuple> tuples, std::size_t most) {
  // The paper's choice: r's manipulability at the placing; then the giver's arm, ties by
  // generation.
  std::stable_sort(tuples.begin(), tuples.end(), [](const auto& a, const auto& b) {
    return std::pair(manipulabilityOf(a), a.holders.front().give.manipulability) >
           std::pair(manipulabilityOf(b), b.holders.front().give.manipulability);
  });
  std::size_t searched = 0;
  for (std::size_t i = 0; i < tuples.size() && searched < most; ++i) {
    if (state_.spent() || state_.over()) return false;
    const int pick = tuples[i].holders.front().take.grasp;
    const int place = tuples[i].holders.back().give.grasp;
    if (failed_picks_.contains(pick) || failed_places_.contains(place)) continue;
    const auto connected = motions_.connect(tuples[i]);
    countTrees();
    if (state_.over()) return false;
    if (const auto* failure = std::get_if<MotionFailure>(&connected)) {
      countFailure(*failure, tuples[i]);
      // Hands that do not go together are found out cheaply; only searches for motions are counted.
      if (failure->cause != Cause::kHandsMeet) ++searched;
      // How the object is taken depends on the first grasp alone, how it is put down on the last.
      if (failure->stage == StageRef{0, StageAction::kReach}) failPick(pick);
      const FailureScope scope = failureScope(*failure, holders());
      if (scope.ofPlacing(holders())) failed_places_.insert(place);
      if (holders() > 1 && (scope.handover > 0 || scope.pose)) {
        back_to_ = scope;
        return false;
      }
      continue;
    }
    ++state_.motion_attempts;
    ++searched;
    const TransportPath& path = std::get<TransportPath>(connected);
    auto timed = timeStages(state_.problem, motions_.context(), path, state_.deadline);
    if (state_.over()) return false;
    if (const auto* failure = std::get_if<MotionFailure>(&timed)) {
      state_.counts.motion_rejects.add(failure->cause, failure->stage, failure->pair);
      fellInMotion(SearchStep::kTiming, *failure, tuples[i]);
      dropEnd(failure->stage, pick, place);
      continue;
    }
    const auto& stages = std::get<std::vector<TimedStage>>(timed);
    const auto schedule = scheduleStages(motions_.context(), stages, state_.deadline);
    if (state_.over()) return false;
    state_.tuple = tuples[i];
    state_.plan = assemblePlan(state_.problem, motions_.context(), path, stages, schedule);
    setCost(state_.problem, path.holders.back().dexterity.give,
            place_order_.front()->manipulability, state_.plan->solution);
    state_.broken = brokenRules(state_.problem, *state_.plan, state_.world);
    return true;
  }
  return false;
}

/// A chain of one: no handover; the same grasp at the start and at the goal.
bool ChainSearch::searchSingle() {
  const PrunedGrasps& takes = pruned(0, PruningPlace::kStart);
  std::vector<TransportTuple> tuples;
  for (const FeasibleGrasp* give : place_order_) {
    if (const FeasibleGrasp* take = takes.find(give->grasp)) {
      tuples.push_back({{}, {{*take, *give}}});
    }
  }
  state_.counts.tuples += static_cast<std::uint32_t>(tuples.size());
  state_.counts.alone = true;
  return tryTuples(std::move(tuples), settings_.motion_attempts);
}

/// One pose of a handover: who can hold the object there, and the tuples that follow.
bool ChainSearch::tryPose(std::size_t handover, Node& node, const Pose& X_WH,
                          HandoverCandidates& counts) {
  const int grasp = node.give->grasp;
  if (!counted() && handover + 2 == holders() && failed_places_.contains(grasp)) return false;
  ++counts.poses_tried;
  if (const auto& tilt = motions_.context().tilt(); tilt && !tilt->keeps(X_WH)) {
    rejects_.add(Cause::kTilt);
    return false;
  }
  if (const auto meet = motions_.handsInTheWay(handover, grasp, takesOf(handover))) {
    const CollisionScene& bodies = *state_.problem.collision;
    rejects_.add(Cause::kCollision, {bodies.name(meet->first), bodies.name(meet->second)});
    return false;
  }
  // One look, and the giver takes one for each of its grasps.
  const bool received_at = motions_.receiverReaches(handover, X_WH, grasp);
  if (!received_at || !motions_.giverReaches(handover, X_WH, grasp, takesOf(handover))) {
    rejects_.add(Cause::kNoIk);
    fellAtHandover({SearchStep::kBothReach, received_at ? 2u : 1u}, handover, X_WH,
                   received_at ? grasp : -1, -1);
    return false;
  }
  ++dear_poses_;
  PrunedGrasps receive = motions_.pruneReceiverAt(handover, X_WH, *node.give);
  rejects_.add(receive.rejects);
  if (receive.kept.empty()) {
    fellAtHandover({SearchStep::kReceive, static_cast<std::uint32_t>(receive.farthest_step)},
                   handover, X_WH, grasp, -1);
    return false;
  }
  FeasibleGrasp& received = receive.kept.front();
  // The paper counts this pose whether or not there is a straight path to it.
  if (!counted() && !motions_.keepApproachable(handover, X_WH, received)) {
    rejects_.add(Cause::kStraightApproach);
    fellAtHandover({SearchStep::kApproach, 1}, handover, X_WH, grasp, -1);
    state_.counts.cut = true;
    return false;
  }
  const PrunedGrasps give = motions_.pruneGiverAt(handover, X_WH, received, takesOf(handover));
  rejects_.add(give.rejects);
  if (give.kept.empty()) {
    fellAtHandover({SearchStep::kGiverBeside, static_cast<std::uint32_t>(give.farthest_step)},
                   handover, X_WH, grasp, give.farthest);
  }
  if (give.kept.empty() || state_.over()) return false;
  ++counts.poses;
  counts.tuples += static_cast<std::uint32_t>(give.kept.size());
  if (node.receivers != nullptr) node.receivers->insert(grasp);

  TransportTuple tuple = node.tuple;
  tuple.X_WH[handover] = X_WH;
  tuple.holders[handover + 1].take = received;
  if (handover > 0) return followInner(handover, tuple, give);
  return connectFirst(tuple, give);
}

/// The handovers before this one, for the best of the giver's grasps here.
bool ChainSearch::followInner(std::size_t handover, const TransportTuple& tuple,
                              const PrunedGrasps& give) {
  std::vector<const FeasibleGrasp*> gives;
  for (const FeasibleGrasp& given : give.kept) gives.push_back(&given);
  std::stable_sort(gives.begin(), gives.end(), [](const auto* a, const auto* b) {
    return a->manipulability > b->manipulability;
  });
  if (gives.size() > settings_.inner_gives) {
    gives.resize(settings_.inner_gives);
    state_.counts.cut = true;
  }
  std::size_t followed = 0;
  for (const FeasibleGrasp* given : gives) {
    if (followed == settings_.inner_tuples) {
      state_.counts.cut = true;
      return false;
    }
    Node inner{tuple, given, tuple.X_WH[handover], nullptr};
    inner.tuple.holders[handover].give = *given;
    if (!motions_.handsMeet(handover, inner.tuple)) {
      rejects_.add(Cause::kHandsMeet);
      fellAtHandover({SearchStep::kHandsMeet, 0}, handover, inner.tuple.X_WH[handover],
                     inner.tuple.holders[handover + 1].take.grasp, given->grasp);
      continue;
    }
    ++followed;
    if (searchInner(handover - 1, inner)) return true;
    if (spent() || state_.over()) return false;
    bool pose_dropped = false;
    if (backOut(handover, pose_dropped) && pose_dropped) return false;
  }
  return false;
}

/// All else is settled: the first holder's grasps, each with its motions.
bool ChainSearch::connectFirst(TransportTuple tuple, const PrunedGrasps& give) {
  state_.counts.tuples += static_cast<std::uint32_t>(give.kept.size());
  std::vector<TransportTuple> tuples;
  for (const FeasibleGrasp& given : give.kept) {
    tuple.holders[0] = {*takesOf(0).find(given.grasp), given};
    tuples.push_back(tuple);
  }
  if (counted() && holders() == 2) {
    poses_.push_back(std::move(tuples));  // counted first, connected afterwards in the same order
    return false;
  }
  const bool solved = tryTuples(std::move(tuples), settings_.tuples_per_pose);
  bool pose_dropped = false;
  backOut(0, pose_dropped);
  return solved;
}

/// A handover before the chain's last one, with what follows it settled.
bool ChainSearch::searchInner(std::size_t handover, Node& node) {
  std::uint32_t& failures = inner_failures_[{handover, node.give->grasp}];
  if (failures >= settings_.inner_failures) {
    state_.counts.cut = true;
    return false;
  }
  const std::vector<LatticePoint>& points = latticeOf(handover).all;
  const std::size_t end = std::min(points.size(), settings_.wide_points);
  const Grasp& grasp = at(handover + 1).grasp(node.give->grasp);
  HandoverCandidates counts;
  for (const ApproachOffset& offset : turnsOf(SearchTier::kTurned, settings_)) {
    for (std::size_t point = 0; point < end; ++point) {
      if (state_.spent() || state_.over() || counts.poses_tried >= settings_.inner_poses ||
          inner_poses_ >= settings_.most_inner_poses) {
        state_.counts.cut = true;
        if (counts.poses == 0) ++failures;
        return false;
      }
      ++state_.counts.poses_asked;
      ++inner_poses_;
      const Pose X_WH = handoverPose(at(handover), at(handover + 1), grasp, node.X_WO_give,
                                     points[point].p_W, offset, false, motions_.context().tilt());
      if (tryPose(handover, node, X_WH, counts)) return true;
      if (back_to_) return false;
    }
  }
  if (counts.poses == 0) ++failures;
  return false;
}

/// Whether so many motions failed near a point that others come first.
bool ChainSearch::crowded(const Eigen::Vector3d& p_W) const {
  const auto near = [&](const Eigen::Vector3d& failed) {
    return (failed - p_W).norm() < settings_.crowd_radius;
  };
  return std::count_if(failed_at_.begin(), failed_at_.end(), near) >= settings_.crowd_failures;
}

bool ChainSearch::tryCandidate(SearchTier tier, const Candidate& candidate,
                               HandoverCandidates& counts) {
  const std::size_t handover = holders() - 2;
  std::set<int>& receivers = receivers_;
  const int place = candidate.place->grasp;
  Node node{
      {std::vector<Pose>(holders() - 1, Pose::Identity()), std::vector<HolderGrasp>(holders())},
      candidate.place,
      state_.problem.task.X_WO_goal,
      &receivers};
  node.tuple.holders.back().give = *candidate.place;
  const Pose X_WH = handoverPose(at(handover), at(handover + 1), at(handover + 1).grasp(place),
                                 node.X_WO_give, candidate.p_W, candidate.offset,
                                 tier == SearchTier::kPaper, motions_.context().tilt());
  point_ = candidate.p_W;
  const bool solved = tryPose(handover, node, X_WH, counts);
  back_to_.reset();
  counts.receiver_grasps = static_cast<std::uint32_t>(receivers.size());
  return solved;
}

bool ChainSearch::searchPoints(SearchTier tier, std::size_t first, std::size_t end,
                               std::uint32_t most_poses, HandoverCandidates& counts) {
  const Lattice& lattice = latticeOf(holders() - 2);
  const bool widened = tier == SearchTier::kTurned;
  const std::uint32_t failed_before = motions_.failedIkSolves();
  receivers_.clear();
  std::vector<Candidate> postponed;
  const std::uint32_t dear_before = dear_poses_;
  const auto enough = [&] {
    const bool cut =
        counts.poses_tried >= most_poses ||
        (widened && !counted() && dear_poses_ - dear_before >= settings_.turned_looks) ||
        (widened && !counted() && state_.motion_attempts >= settings_.turned_motions) ||
        (widened && motions_.failedIkSolves() - failed_before >= settings_.most_failed_ik);
    state_.counts.cut = state_.counts.cut || cut;
    return cut || spent() || state_.over();
  };
  // Another place more often helps than another turn at the same one: an arm that cannot fold so
  // far there cannot in any turn.
  for (const ApproachOffset& offset : turnsOf(tier, settings_)) {
    for (std::size_t point = first; point < end; ++point) {
      // Tried already, by the tier before.
      if (widened && point == 0 && offset.turn == 0 && !lattice.both.empty()) continue;
      if (widened && !counted() && !mapAllows(point, offset)) {
        rejects_.add(Cause::kNotInMap);
        continue;
      }
      for (const FeasibleGrasp* place : place_order_) {
        if (enough()) break;
        const Candidate candidate{offset, lattice.all[point].p_W, place};
        if (crowded(candidate.p_W)) {
          postponed.push_back(candidate);
          continue;
        }
        if (tryCandidate(tier, candidate, counts)) return true;
      }
    }
  }
  for (const Candidate& candidate : postponed) {
    if (enough()) break;
    if (tryCandidate(tier, candidate, counts)) return true;
  }
  return false;
}

/// By the receiver's map, which misses 0.4 % of the poses that the arm reaches: soon told.
bool ChainSearch::mapAllows(std::size_t point, const ApproachOffset& offset) {
  const std::size_t handover = holders() - 2;
  const PlacedMap& giver = at(handover).map;
  const PlacedMap& receiver = at(handover + 1).map;
  const Lattice& lattice = latticeOf(handover);
  if (receiver_bins_.empty()) {
    for (const LatticePoint& it : lattice.all) receiver_bins_.push_back(receiver.binsNear(it.p_W));
  }
  const Eigen::Vector3d approach_W =
      handoverApproach(giver.p_WShoulder, receiver.p_WShoulder, offset);
  return (receiver_bins_[point] & receiver.binsOf(approach_W)) != 0;
}

/// Poses as they are drawn, mostly where the search began and hardly tilted: a regular order would
/// spend itself on neighbours, which fail alike.
bool ChainSearch::searchScattered(HandoverCandidates& counts) {
  std::uint32_t not_in_map = 0;
  const bool solved = searchScattered(counts, not_in_map);
  rejects_.add(Cause::kNotInMap, not_in_map);
  return solved;
}

bool ChainSearch::searchScattered(HandoverCandidates& counts, std::uint32_t& not_in_map) {
  const std::vector<LatticePoint>& points = latticeOf(holders() - 2).all;
  const std::uint32_t failed_before = motions_.failedIkSolves();
  SeededRandom random(SeededRandom::mix(state_.problem.seed));
  const auto jitter = [&] { return random.uniform(-0.5, 0.5) * kLatticeEdge; };
  receivers_.clear();
  state_.counts.cut = true;  // a sample proves nothing
  const std::uint32_t dear_before = dear_poses_;
  // A request's poses, evenly over its chains.
  const std::uint32_t poses = apart() ? settings_.scattered_poses_apart : settings_.scattered_poses;
  const std::uint32_t most = poses / std::max(1u, state_.counts.chains);
  for (std::uint32_t i = 0; i < most; ++i) {
    if (spent() || state_.over()) return false;
    if (dear_poses_ - dear_before >= settings_.scattered_looks) return false;
    if (motions_.failedIkSolves() - failed_before >= settings_.most_failed_ik) return false;
    const double early = random.unit();
    const auto point = static_cast<std::size_t>(early * early * static_cast<double>(points.size()));
    const double x = jitter(), y = jitter(), z = jitter();
    const double turn = random.uniform(0, 2 * M_PI);
    const double tilt = settings_.most_tilt * random.unit() * random.unit();
    const double azimuth = random.uniform(0, 2 * M_PI);
    const auto place = random.index(static_cast<std::uint32_t>(place_order_.size()));
    if (!mapAllows(point, {turn, tilt, azimuth})) {
      ++counts.poses_tried;
      ++not_in_map;
      continue;
    }
    const Candidate candidate{
        {turn, tilt, azimuth}, points[point].p_W + Eigen::Vector3d(x, y, z), place_order_[place]};
    if (tryCandidate(SearchTier::kScattered, candidate, counts)) return true;
  }
  return false;
}

/// What a tier has counted, to its end or to the deadline.
void ChainSearch::finishCounts(HandoverCandidates counts) {
  state_.counts.poses_asked += counts.poses_tried;
  state_.counts.last_poses += counts.poses;
  counts.causes = rejects_.counts();
  state_.counts.handover_rejects.add(rejects_);
  if (!state_.cancelled()) state_.sink.emit(std::move(counts));
}

bool ChainSearch::searchLast(SearchTier tier) {
  const std::size_t handover = holders() - 2;
  const Lattice& lattice = latticeOf(handover);
  const bool widened = tier == SearchTier::kTurned || tier == SearchTier::kScattered;
  const std::size_t size =
      widened ? lattice.all.size() : std::min<std::size_t>(1, lattice.both.size());
  if (size == 0) return false;
  HandoverCandidates counts;
  counts.handover = static_cast<std::uint32_t>(handover);
  counts.giver = at(handover).name();
  counts.receiver = at(handover + 1).name();
  counts.lattice_points = static_cast<std::uint32_t>(lattice.both.size());
  rejects_ = {};
  poses_.clear();
  if (widened) tryTakes();
  bool solved = false;
  if (tier == SearchTier::kScattered) {
    solved = searchScattered(counts);
  } else {
    const std::size_t best = std::min(size, settings_.wide_points);
    solved =
        searchPoints(tier, 0, best, counted() ? settings_.wide_poses_counted : settings_.wide_poses,
                     counts) ||
        searchPoints(tier, best, size, settings_.wide_poses_counted, counts);
  }
  if (tier == SearchTier::kPaper) counts.lattice = cellsOf(lattice.both);
  finishCounts(std::move(counts));
  for (std::size_t i = 0; i < poses_.size() && !solved && !state_.over(); ++i) {
    solved = tryTuples(std::move(poses_[i]), settings_.tuples_per_pose);
  }
  return solved;
}

bool ChainSearch::search(SearchTier tier) {
  if (holders() == 1) return tier == SearchTier::kPaper && searchSingle();
  return searchLast(tier);
}

}  // namespace handover
