// SPDX-License-Identifier: Apache-2.0
#include "core/planning/plan_improvement.hpp"

#include "core/planning/plan_cost.hpp"
#include "core/planning/plan_rules.hpp"

#include <handover/common/random.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <tuple>

namespace handover {
namespace {

/// As the request has it, but what one tuple's search finds does not depend on the others'.
TransportProblem independent(TransportProblem problem) {
  SearchSettings& settings = problem.settings;
  settings.independent = true;
  settings.free_motion.skins = settings.improvement.skins;
  settings.free_motion.rrt_iterations = settings.improvement.rrt_iterations;
  settings.free_motion.patient_trees = std::numeric_limits<std::uint32_t>::max();
  return problem;
}

std::vector<const Manipulator*> manipulatorsOf(SearchState& state, const ChainSearch& search) {
  std::vector<const Manipulator*> holders;
  for (const ChainHolder& arm : search.arms()) holders.push_back(&state.manipulator(arm));
  return holders;
}

class PlanImprover {
 public:
  PlanImprover(SearchState& state, ChainSearch& search)
      : state_(state),
        search_(search),
        problem_(independent(state.problem)),
        settings_(problem_.settings.improvement),
        motions_(problem_, manipulatorsOf(state, search), state.world, state.spare_world,
                 state.deadline),
        start_(motions_.context().startState()),
        best_(state.tuple) {
    findPlaces();
    best_cost_ = state.plan->solution.cost;
  }

  /// Calls take(plan, tuple) for every plan that is found, of `plans` tuples a round.
  template <typename Take>
  void search(std::size_t plans, const Take& take) {
    for (int round = 0; round < settings_.rounds && !state_.over(); ++round) {
      pool_.clear();
      if (holders() == 1) gatherSingles();
      for (std::size_t k = 0; k + 1 < holders() && !state_.over(); ++k) gather(k, round);
      evaluatePool(plans, take);
    }
  }

  double bestCost() const { return best_cost_; }

 private:
  struct Candidate {
    TransportTuple tuple;
    double promise = 0;
  };

  /// A choice of the receiver's grasp, the point and the turn; by handover.
  using Choice = std::tuple<std::size_t, std::size_t, std::size_t, int>;

  std::size_t holders() const { return motions_.holders().size(); }

  const Manipulator& at(std::size_t holder) const { return *motions_.holders()[holder]; }

  /// How the last holder may leave the object: each of its grasps, by each of a few configurations.
  void findPlaces() {
    const Manipulator& arm = at(holders() - 1);
    for (const FeasibleGrasp& grasp : state_.at_goal.at(arm.name()).kept) {
      best_placing_ = std::max(best_placing_, grasp.manipulability);
      const std::size_t most = std::min(grasp.configurations.size(), settings_.places);
      for (std::size_t i = 0; i < most; ++i) {
        const ArmVector& q = grasp.configurations[i];
        places_.push_back({grasp.grasp, {q}, arm.kinematics->manipulability(q)});
      }
    }
    if (problem_.objective == Objective::kTime) return;
    // The others only where none of these gives a plan: there is one already.
    std::erase_if(places_, [&](const FeasibleGrasp& place) {
      return place.manipulability < problem_.settings.cost.dexterous * best_placing_;
    });
  }

  const PrunedGrasps& takes() const { return state_.at_start.at(at(0).name()); }

  double promiseOf(const TransportTuple& tuple) const {
    return promisedCost(problem_, motions_.holders(), tuple, start_, best_placing_);
  }

  void gatherSingles() {
    for (const FeasibleGrasp& place : places_) {
      if (const FeasibleGrasp* take = takes().find(place.grasp)) {
        offer({{}, {{*take, place}}});
      }
    }
  }

  void offer(TransportTuple tuple) {
    const double promise = promiseOf(tuple);
    pool_.push_back({std::move(tuple), promise});
  }

  /// Other poses of one handover, all else as in the best plan so far.
  void gather(std::size_t handover, int round) {
    const bool last = handover + 2 == holders();
    const std::vector<FeasibleGrasp> options =
        last ? places_ : std::vector<FeasibleGrasp>{best_.holders[handover + 1].give};
    PrunedGrasps fixed;
    if (handover > 0) fixed.kept.push_back({best_.holders[handover].take.grasp, {}, 0});
    const PrunedGrasps& giver = handover > 0 ? fixed : takes();
    const std::vector<LatticePoint> points = pointsFor(handover, round);
    if (options.empty() || points.empty()) return;
    const Pose& X_WO_give = last ? problem_.task.X_WO_goal : best_.X_WH[handover + 1];
    SeededRandom random(
        SeededRandom::mix(problem_.seed ^ (64 * static_cast<std::uint64_t>(round) + handover + 1)));
    std::uint32_t poses = 0;
    for (std::uint32_t i = 0; i < settings_.looks && poses < settings_.poses; ++i) {
      if (state_.over()) return;
      const double early = random.unit();
      const auto point =
          static_cast<std::size_t>(early * early * static_cast<double>(points.size()));
      const auto turn =
          static_cast<int>(random.index(static_cast<std::uint32_t>(problem_.settings.wide_turns)));
      const std::size_t option = random.index(static_cast<std::uint32_t>(options.size()));
      if (!seen_.insert({handover, option, pointKey(points[point].p_W), turn}).second) continue;
      const ApproachOffset offset{2 * M_PI * turn / problem_.settings.wide_turns, 0, 0};
      const FeasibleGrasp& give = options[option];
      const Pose X_WH =
          handoverPose(at(handover), at(handover + 1), at(handover + 1).grasp(give.grasp),
                       X_WO_give, points[point].p_W, offset, false, motions_.context().tilt());
      if (!motions_.receiverReaches(handover, X_WH, give.grasp) ||
          !motions_.giverReaches(handover, X_WH, give.grasp, giver)) {
        continue;
      }
      ++poses;
      gatherAt(handover, X_WH, give, giver);
    }
  }

  static std::size_t pointKey(const Eigen::Vector3d& p_W) {
    const Eigen::Vector3d cell = (p_W / kLatticeEdge).array().floor() + 4096;
    return (static_cast<std::size_t>(cell.x()) << 40) ^ (static_cast<std::size_t>(cell.y()) << 20) ^
           static_cast<std::size_t>(cell.z());
  }

  std::vector<LatticePoint> pointsFor(std::size_t handover, int round) {
    const std::vector<LatticePoint>& all = search_.points(handover);
    if (round == 0) return all;
    const Manipulator& receiver = at(handover + 1);
    const Eigen::Vector3d p_WT =
        best_.X_WH[handover] *
        receiver.grasp(best_.holders[handover + 1].take.grasp).X_OT.translation();
    std::vector<LatticePoint> near;
    for (const LatticePoint& point : all) {
      if ((point.p_W - p_WT).norm() < settings_.near) near.push_back(point);
    }
    return near;
  }

  /// The most promising of the giver's grasps at one pose.
  void gatherAt(std::size_t handover, const Pose& X_WH, const FeasibleGrasp& give,
                const PrunedGrasps& giver) {
    PrunedGrasps receive = motions_.pruneReceiverAt(handover, X_WH, give);
    if (receive.kept.empty()) return;
    FeasibleGrasp& received = receive.kept.front();
    if (!motions_.keepApproachable(handover, X_WH, received)) return;
    const PrunedGrasps given = motions_.pruneGiverAt(handover, X_WH, received, giver);
    TransportTuple tuple = best_;
    tuple.X_WH[handover] = X_WH;
    tuple.holders[handover + 1] = {received, give};
    std::vector<Candidate> here;
    for (const FeasibleGrasp& it : given.kept) {
      if (handover == 0) tuple.holders[0].take = *takes().find(it.grasp);
      tuple.holders[handover].give = it;
      here.push_back({tuple, promiseOf(tuple)});
    }
    std::stable_sort(here.begin(), here.end(), promisesMore);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < here.size() && i < 3 * settings_.per_pose; ++i) {
      if (kept == settings_.per_pose || state_.over()) break;
      if (!motions_.handsMeet(handover, here[i].tuple)) continue;
      pool_.push_back(std::move(here[i]));
      ++kept;
    }
  }

  static bool promisesMore(const Candidate& a, const Candidate& b) { return a.promise < b.promise; }

  template <typename Take>
  void evaluatePool(std::size_t plans, const Take& take) {
    std::stable_sort(pool_.begin(), pool_.end(), promisesMore);
    const std::size_t most = std::min(pool_.size(), plans);
    for (std::size_t i = 0; i < most && !state_.over(); ++i) {
      auto plan = planOf(pool_[i].tuple);
      if (!plan || state_.over()) continue;
      if (plan->solution.cost < best_cost_) {
        best_ = pool_[i].tuple;
        best_cost_ = plan->solution.cost;
      }
      take(std::move(*plan), pool_[i].tuple);
    }
  }

  std::optional<TransportPlan> planOf(const TransportTuple& tuple) {
    const auto connected = motions_.connect(tuple);
    const auto* path = std::get_if<TransportPath>(&connected);
    if (path == nullptr || state_.over()) return std::nullopt;
    const auto timed = timeStages(problem_, motions_.context(), *path, state_.deadline);
    const auto* stages = std::get_if<std::vector<TimedStage>>(&timed);
    if (stages == nullptr || state_.over()) return std::nullopt;
    const auto schedule = scheduleStages(motions_.context(), *stages, state_.deadline);
    if (state_.over()) return std::nullopt;
    TransportPlan plan = assemblePlan(problem_, motions_.context(), *path, *stages, schedule);
    setCost(problem_, path->holders.back().dexterity.give, best_placing_, plan.solution);
    const std::vector<std::string> broken = brokenRules(problem_, plan, state_.world);
    if (broken.empty()) return plan;
    state_.sink.emit(Note{"plan_held_back", "A plan was held back: " + broken.front() + "."});
    return std::nullopt;
  }

  SearchState& state_;
  ChainSearch& search_;
  const TransportProblem problem_;
  const ImprovementSettings& settings_;
  TransportMotions motions_;
  const CellState start_;
  std::vector<FeasibleGrasp> places_;
  double best_placing_ = 0;
  std::set<Choice> seen_;
  std::vector<Candidate> pool_;
  TransportTuple best_;
  double best_cost_ = 0;
};

void send(TransportPlan plan, std::uint32_t index, PlanEventSink& sink) {
  plan.solution.index = index;
  sink.emit(std::move(plan.solution));
  for (StageTrajectory& trajectory : plan.trajectories) {
    trajectory.solution = index;
    sink.emit(std::move(trajectory));
  }
}

bool samePose(const Pose& a, const Pose& b) { return a.matrix() == b.matrix(); }

/// The same grasps at the same poses, whatever the arms' configurations.
bool alike(const TransportTuple& a, const TransportTuple& b) {
  const auto sameGrasp = [](const HolderGrasp& x, const HolderGrasp& y) {
    return x.take.grasp == y.take.grasp;
  };
  return std::equal(a.X_WH.begin(), a.X_WH.end(), b.X_WH.begin(), samePose) &&
         std::equal(a.holders.begin(), a.holders.end(), b.holders.begin(), sameGrasp);
}

}  // namespace

std::uint32_t improvePlan(SearchState& state, ChainSearch& search) {
  PlanImprover improver(state, search);
  std::uint32_t index = 0;
  double least = improver.bestCost();
  improver.search(state.problem.settings.improvement.plans,
                  [&](TransportPlan plan, const TransportTuple&) {
                    if (plan.solution.cost >= least) return;
                    least = plan.solution.cost;
                    send(std::move(plan), ++index, state.sink);
                  });
  return index;
}

void rankPlans(SearchState& state, ChainSearch& search) {
  struct Found {
    TransportPlan plan;
    TransportTuple tuple;
  };

  std::vector<Found> found{{*state.plan, state.tuple}};
  PlanImprover(state, search)
      .search(state.problem.settings.improvement.plans_ranked,
              [&](TransportPlan plan, const TransportTuple& tuple) {
                found.push_back({std::move(plan), tuple});
              });
  std::stable_sort(found.begin(), found.end(), [](const Found& a, const Found& b) {
    return a.plan.solution.cost < b.plan.solution.cost;
  });
  std::vector<Found> ranked;
  for (Found& it : found) {
    const auto known = [&](const Found& other) { return alike(it.tuple, other.tuple); };
    if (std::none_of(ranked.begin(), ranked.end(), known)) ranked.push_back(std::move(it));
  }
  const std::size_t most = std::min(ranked.size(), state.problem.settings.improvement.ranked);
  for (std::size_t i = 0; i < most; ++i) {
    send(std::move(ranked[i].plan), static_cast<std::uint32_t>(i), state.sink);
  }
}

}  // namespace handover
