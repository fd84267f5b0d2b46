// SPDX-License-Identifier: Apache-2.0
#include "core/planning/plan_transport.hpp"

#include "core/planning/arm_selection.hpp"
#include "core/planning/chain_search.hpp"
#include "core/planning/plan_improvement.hpp"
#include "core/planning/scene_validity.hpp"

#include <algorithm>
#include <deque>
#include <memory>
#include <optional>

namespace handover {
namespace {

using Chain = std::vector<ChainHolder>;

/// A place in a chain, as the task leaves it open.
using Place = std::optional<ChainHolder>;

/// All chains of arms that fit the places, the best-ranked first and last arms first.
class ChainList {
 public:
  ChainList(const TransportProblem& problem, std::vector<Place> places, bool repeats)
      : problem_(problem), places_(std::move(places)), repeats_(repeats) {}

  void setEnds(const ArmRanking& first, const ArmRanking& last) {
    first_ = armsOf(first);
    last_ = armsOf(last);
  }

  std::vector<Chain> chains() {
    if (places_.size() == 1) {
      for (const ChainHolder& arm : first_) {
        if (std::find(last_.begin(), last_.end(), arm) != last_.end()) chains_.push_back({arm});
      }
      return chains_;
    }
    for (const ChainHolder& first : first_) {
      for (const ChainHolder& last : last_) {
        if (first == last && !(repeats_ && places_.size() > 2)) continue;
        chain_ = {first};
        extend(last);
      }
    }
    return chains_;
  }

 private:
  static Chain armsOf(const ArmRanking& ranking) {
    Chain arms;
    for (const RankedArm& ranked : ranking.arms) arms.push_back(ranked.arm);
    return arms;
  }

  bool mayFollow(const ChainHolder& arm) const {
    if (arm == chain_.back()) return false;
    return repeats_ || std::find(chain_.begin(), chain_.end(), arm) == chain_.end();
  }

  void extend(const ChainHolder& last) {
    if (chain_.size() + 1 == places_.size()) {
      if (!mayFollow(last)) return;
      chains_.push_back(chain_);
      chains_.back().push_back(last);
      return;
    }
    for (const ChainHolder& arm : fitArms(problem_, places_[chain_.size()])) {
      if (!mayFollow(arm)) continue;
      chain_.push_back(arm);
      extend(last);
      chain_.pop_back();
    }
  }

  const TransportProblem& problem_;
  std::vector<Place> places_;
  bool repeats_;
  Chain first_, last_, chain_;
  std::vector<Chain> chains_;
};

/// One request: the chains it leaves open, each searched tier by tier.
class TransportSearch {
 public:
  TransportSearch(const TransportProblem& problem, PlanEventSink& sink, const Deadline& deadline)
      : problem_(problem), state_(problem_, sink, deadline) {}

  Outcome run() {
    Outcome outcome = search();
    if (auto* failed = std::get_if<Failed>(&outcome)) {
      std::optional<Farthest>& farthest = failed->explanation.farthest;
      if (!farthest) farthest = state_.farthest.candidate();
    }
    return outcome;
  }

  SearchEffort effort() const {
    return {state_.counts.poses_asked, state_.motion_attempts + state_.grasp_attempts};
  }

 private:
  Outcome search() {
    const auto invalid = checkScene(problem_, state_.world, problem_.task);
    state_.sink.emit(snapshot(*problem_.scene, problem_.task, problem_.seed));
    if (state_.over()) return ended();
    if (invalid) return *invalid;
    return problem_.task.chain.empty() ? searchAuto() : searchGiven();
  }

  Outcome ended() const {
    if (state_.deadline.state() == Deadline::State::kCancelled) return Cancelled{};
    return explainDeadline(state_.at_start, state_.at_goal, state_.counts);
  }

  Outcome searchGiven() {
    std::vector<Place> places(problem_.task.chain.begin(), problem_.task.chain.end());
    const auto found = searchChains(places, true);
    if (found) return *found;
    return explainSearch(problem_, state_.at_start, state_.at_goal, state_.counts);
  }

  /// The fewest handovers first.
  Outcome searchAuto() {
    for (std::size_t n = 1; n <= problem_.settings.most_auto_holders; ++n) {
      const auto found = searchChains(std::vector<Place>(n), false);
      if (found) return *found;
    }
    return explainSearch(problem_, state_.at_start, state_.at_goal, state_.counts);
  }

  Place first(const std::vector<Place>& places) const {
    return problem_.task.held_by ? problem_.task.held_by : places.front();
  }

  /// nullopt: no chain of that length gives a plan.
  std::optional<Outcome> searchChains(const std::vector<Place>& places, bool repeats) {
    const std::size_t n = places.size();
    const SceneTask& task = problem_.task;
    ArmRanking givers = rankArms(problem_, first(places), 0, task.X_WO_start, state_.deadline);
    ArmRanking receivers =
        rankArms(problem_, places.back(), n - 1, task.X_WO_goal, state_.deadline);
    if (state_.over()) return ended();
    if (problem_.search == SearchWidth::kPaper && givers.arms.size() > 1) givers.arms.resize(1);
    ChainList list(problem_, places, repeats);
    list.setEnds(givers, receivers);
    std::vector<Chain> chains = list.chains();
    if (!repeats) {
      const std::size_t all = chains.size();
      dropOutOfReach(chains);
      if (chains.size() < all)
        state_.counts.cut = state_.counts.may_meet = true;  // maps have holes
    }
    emitSelected(chains, givers, receivers);
    if (givers.arms.empty()) return explainArms(problem_, PruningPlace::kStart, givers);
    if (receivers.arms.empty()) return explainArms(problem_, PruningPlace::kGoal, receivers);
    if (chains.empty() && repeats) {
      return explainNoChain(problem_, n, namesOf(givers), namesOf(receivers),
                            rejectsOf(givers, receivers));
    }
    return searchAll(chains);
  }

  /// What stands against the arms at either end.
  static CauseTally rejectsOf(const ArmRanking& givers, const ArmRanking& receivers) {
    CauseTally tally;
    for (const ArmRanking* ranking : {&givers, &receivers}) {
      for (const ArmScore& score : ranking->scores) {
        if (score.rejected == Cause::kUnspecified) continue;
        tally.add(score.rejected, {score.arm.robot + "/" + score.arm.arm, score.object});
      }
    }
    return tally;
  }

  std::vector<ArmName> namesOf(const ArmRanking& ranking) {
    std::vector<ArmName> names;
    for (const RankedArm& ranked : ranking.arms) {
      names.push_back(state_.manipulator(ranked.arm).name());
    }
    return names;
  }

  std::optional<Outcome> searchAll(const std::vector<Chain>& chains) {
    std::deque<ChainSearch> searches;
    for (const Chain& chain : chains) {
      ChainSearch& search = searches.emplace_back(state_, chain);
      const bool usable = search.open();
      if (state_.over()) return ended();
      if (!usable) {
        searches.pop_back();
        continue;
      }
      for (const SearchTier tier : {SearchTier::kPaper, SearchTier::kTool}) {
        if (tier == SearchTier::kTool && !state_.wide()) continue;
        if (search.search(tier)) return solved(search);
        if (state_.over()) return ended();
      }
    }
    if (!state_.wide()) return std::nullopt;
    for (const SearchTier tier : {SearchTier::kTurned, SearchTier::kScattered}) {
      for (ChainSearch& search : searches) {
        if (search.search(tier)) return solved(search);
        if (state_.over()) return ended();
      }
    }
    return std::nullopt;
  }

  /// Chains of which two that follow each other have no point in common by their maps.
  void dropOutOfReach(std::vector<Chain>& chains) {
    const SearchSettings& settings = problem_.settings;
    std::erase_if(chains, [&](const Chain& chain) {
      for (std::size_t k = 0; k + 1 < chain.size(); ++k) {
        const double radius = chain[k].robot == chain[k + 1].robot
                                  ? settings.same_robot_neighbourhood
                                  : settings.neighbourhood;
        const PlacedMap& giver = state_.manipulator(chain[k]).map;
        const PlacedMap& receiver = state_.manipulator(chain[k + 1]).map;
        if (crossMaps(giver, receiver, radius).empty()) return true;
      }
      return false;
    });
  }

  void emitSelected(const std::vector<Chain>& chains, const ArmRanking& givers,
                    const ArmRanking& receivers) {
    ArmSelected selected;
    if (!chains.empty()) {
      for (const ChainHolder& arm : chains.front()) {
        selected.holders.push_back(state_.manipulator(arm).name());
      }
    }
    selected.scores = givers.scores;
    selected.scores.insert(selected.scores.end(), receivers.scores.begin(), receivers.scores.end());
    state_.sink.emit(std::move(selected));
  }

  /// A deadline that passed on the way ended the shortening of motions: not complete then.
  Outcome solved(ChainSearch& search) {
    if (!state_.broken.empty()) return heldBack();
    if (state_.deadline.state() == Deadline::State::kCancelled) return Cancelled{};
    const bool further = problem_.search == SearchWidth::kWide && !state_.over();
    std::uint32_t best = 0;
    if (further && problem_.mode == SearchMode::kAll) {
      rankPlans(state_, search);
    } else {
      state_.sink.emit(state_.plan->solution);
      for (const StageTrajectory& trajectory : state_.plan->trajectories) {
        state_.sink.emit(trajectory);
      }
      if (further && problem_.mode == SearchMode::kBest) best = improvePlan(state_, search);
    }
    if (state_.deadline.state() == Deadline::State::kCancelled) return Cancelled{};
    if (search.holders() == 2) noteIfOneArmWouldDo(search.arms().front());
    return Done{best, !state_.over()};
  }

  /// A plan that breaks a rule is a fault of ours.
  Outcome heldBack() const {
    std::string text = "A plan was held back that breaks rules:";
    for (const std::string& rule : state_.broken) text += " " + rule + ";";
    text.back() = '.';
    return failed(FailureReason::kInternal, "rules", text, {}, false);
  }

  /// Nobody is told to hand over what one arm could bring.
  void noteIfOneArmWouldDo(const ChainHolder& arm) {
    const Manipulator& it = state_.manipulator(arm);
    if (!it.map.near(problem_.task.X_WO_goal.translation())) return;
    TransportMotions alone(problem_, {&it}, state_.world, state_.spare_world, state_.deadline);
    const PrunedGrasps places = alone.pruneLastAtGoal(problem_.settings.pruning);
    const PrunedGrasps& takes = state_.at_start.at(it.name());
    for (const FeasibleGrasp& place : places.kept) {
      if (takes.find(place.grasp) == nullptr) continue;
      state_.sink.emit(Note{"one_arm_would_do", it.name().robot + "/" + it.name().arm +
                                                    " reaches both the start and the goal: the "
                                                    "chain [" +
                                                    it.name().robot + "/" + it.name().arm +
                                                    "] may do without a handover."});
      return;
    }
  }

  TransportProblem problem_;  ///< its task's rests are found here
  SearchState state_;
};

}  // namespace

Outcome planTransport(const TransportProblem& problem, PlanEventSink& sink,
                      const Deadline& deadline, SearchEffort* effort) {
  TransportSearch search(problem, sink, deadline);
  Outcome outcome = search.run();
  if (effort != nullptr) *effort = search.effort();
  return outcome;
}

std::size_t commonPoints(const TransportProblem& problem) {
  const auto armsOf = [&](const ChainHolder& which, std::size_t holder, const Pose& X_WO) {
    std::vector<Manipulator> arms;
    for (const auto& ranked : rankArms(problem, which, holder, X_WO, Deadline()).arms) {
      arms.push_back(makeManipulator(problem, ranked.arm.robot, ranked.arm.arm));
    }
    return arms;
  };
  std::size_t most = 0;
  const auto givers = armsOf(problem.task.chain.front(), 0, problem.task.X_WO_start);
  for (const Manipulator& r : armsOf(problem.task.chain.back(), 1, problem.task.X_WO_goal)) {
    for (const Manipulator& g : givers) {
      most = std::max(most, crossMaps(g.map, r.map, problem.settings.neighbourhood).size());
    }
  }
  return most;
}

std::vector<ReachBall> reachBalls(const TransportProblem& problem, const ChainHolder& holder) {
  std::vector<ReachBall> balls;
  for (const ChainHolder& arm : fitArms(problem, holder)) {
    const PlacedMap map = makeManipulator(problem, arm.robot, arm.arm).map;
    balls.push_back({map.p_WShoulder, map.map->reach(map.X_WA.inverse() * map.p_WShoulder)});
  }
  return balls;
}

}  // namespace handover
