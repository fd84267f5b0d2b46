// SPDX-License-Identifier: Apache-2.0
#include "core/planning/grasp_feasibility.hpp"

#include <algorithm>
#include <numeric>

namespace handover {
namespace {

constexpr std::array<double, 2> kPartlyClosed{0.33, 0.67};

/// Tests grasps with the hand open and closed, all else as in a state.
class GraspChecker {
 public:
  GraspChecker(const PruneQuery& query, CollisionContext& open_context,
               CollisionContext& closed_context)
      : manipulator_(*query.manipulator),
        q_(query.state.of(*query.manipulator)),
        move_(query.move),
        open_(open_context.makeForArm(query.state, manipulator_, query.open)),
        closed_(closed_context.makeForArm(query.state, manipulator_, query.closed)) {}

  /// What touches the hand at its pose, which all configurations share.
  std::optional<BodyPair> handTouches(const Grasp& grasp, const Pose& X_WT) {
    set(grasp);
    if (move_ != HandMove::kHolds) {
      if (auto hit = open_.toolTouches(X_WT)) return hit;
    }
    if (move_ == HandMove::kCloses) {  // a table beside the object may be in the fingers' way
      for (const double part : kPartlyClosed) {
        setClosed(grasp.open + part * (grasp.closed - grasp.open));
        if (auto hit = closed_.toolTouches(X_WT)) {
          grasp_ = nullptr;
          return hit;
        }
      }
      setClosed(grasp.closed);
    }
    return closed_.toolTouches(X_WT);
  }

  /// What touches the rest of the arm at one configuration. @pre the hand is free.
  std::optional<BodyPair> armTouches(const Grasp& grasp, const ArmVector& q) {
    set(grasp);
    if (move_ == HandMove::kHolds) return closed_.armTouches(q, StateChecker::ArmPart::kAll);
    if (auto hit = open_.armTouches(q, StateChecker::ArmPart::kAll)) return hit;
    // The arm is where it was; only the fingers are not.
    return closed_.armTouches(q, StateChecker::ArmPart::kToolWithArm);
  }

 private:
  void set(const Grasp& grasp) {
    if (&grasp == grasp_) return;
    grasp_ = &grasp;
    open_.setPosture(manipulator_.robot, manipulator_.withFingers(q_, grasp.open));
    setClosed(grasp.closed);
  }

  void setClosed(const Eigen::VectorXd& q_fingers) {
    closed_.setPosture(manipulator_.robot, manipulator_.withFingers(q_, q_fingers));
  }

  const Manipulator& manipulator_;
  RobotVector q_;
  HandMove move_;
  const Grasp* grasp_ = nullptr;
  StateChecker open_, closed_;
};

/// One query at work: scratch and tally.
class Pruner {
 public:
  Pruner(const PruneQuery& query, CollisionContext& open_context, CollisionContext& closed_context,
         const CollisionScene& bodies)
      : query_(query),
        manipulator_(*query.manipulator),
        checker_(query, open_context, closed_context),
        bodies_(bodies) {
    ik_.swivel_samples = query.effort.swivels;
    ik_.q_near = manipulator_.armOf(manipulator_.placed->q_start);
  }

  void test(int index) {
    ++pruned_.tested;
    if (const BodyPair* known = knownConflict(index)) {
      fell(index, PruneStep::kHand);
      return tally(*known);
    }
    const Grasp& grasp = manipulator_.grasp(index);
    const Pose X_WT = query_.state.X_WO * grasp.X_OT;
    const Pose X_AT = manipulator_.worldToArm(X_WT);
    // Cheapest test first: is there any configuration, is the hand free, then all of them.
    const IkCounts counts =
        manipulator_.kinematics->visit(X_AT, ik_, [](const ArmVector&) { return false; });
    if (counts.solutions == 0) {
      fell(index, PruneStep::kIk);
      const bool out_of_reach = counts.limits == 0 && manipulator_.kinematics->closedForm();
      if (!out_of_reach && !(query_.effort.proof && checker_.handTouches(grasp, X_WT))) {
        pruned_.proven = false;
      }
      return pruned_.rejects.add(counts.limits > 0 ? Cause::kLimits : Cause::kNoIk);
    }
    if (const auto hit = checker_.handTouches(grasp, X_WT)) {
      fell(index, PruneStep::kHand);
      keepConflict(index, *hit);
      return tally(*hit);
    }
    order(index, X_AT);
    std::optional<BodyPair> first_hit;
    const std::size_t first = firstFree(grasp, first_hit);
    if (first == tried()) {
      fell(index, PruneStep::kArm);
      pruned_.proven = false;
      return tally(*first_hit);
    }
    keep(index, first);
  }

  PrunedGrasps take() { return std::move(pruned_); }

 private:
  const BodyPair* knownConflict(int index) const {
    if (query_.conflicts == nullptr) return nullptr;
    const auto known = query_.conflicts->find(index);
    return known == query_.conflicts->end() ? nullptr : &known->second;
  }

  void keepConflict(int index, const BodyPair& hit) {
    if (query_.conflicts == nullptr) return;
    const auto of = [](const Manipulator& arm, BodyId body) {
      return std::find(arm.hand_bodies.begin(), arm.hand_bodies.end(), body) !=
             arm.hand_bodies.end();
    };
    const Manipulator& other = *query_.other_hand;
    if ((of(manipulator_, hit.first) && of(other, hit.second)) ||
        (of(other, hit.first) && of(manipulator_, hit.second))) {
      query_.conflicts->emplace(index, hit);
    }
  }

  std::size_t tried() const { return std::min(query_.effort.configurations, order_.size()); }

  void order(int index, const Pose& X_AT) {
    solutions_.clear();
    manipulator_.kinematics->solve(X_AT, ik_, solutions_);
    order_.clear();
    for (std::size_t i = 0; i < solutions_.size(); ++i) {
      order_.emplace_back(query_.cost(index, solutions_[i]), i);
    }
    std::sort(order_.begin(), order_.end());
  }

  const ArmVector& solution(std::size_t place) const { return solutions_[order_[place].second]; }

  std::size_t firstFree(const Grasp& grasp, std::optional<BodyPair>& first_hit) {
    for (std::size_t i = 0; i < tried(); ++i) {
      const auto hit = checker_.armTouches(grasp, solution(i));
      if (!hit) return i;
      if (!first_hit) first_hit = hit;
    }
    return tried();
  }

  void keep(int index, std::size_t first) {
    FeasibleGrasp feasible;
    feasible.grasp = index;
    feasible.manipulability = manipulator_.kinematics->manipulability(solution(first));
    const std::size_t end = std::min(order_.size(), first + query_.effort.configurations);
    for (std::size_t i = first; i < end; ++i) feasible.configurations.push_back(solution(i));
    pruned_.kept.push_back(std::move(feasible));
  }

  void fell(int index, PruneStep step) {
    if (step <= pruned_.farthest_step) return;
    pruned_.farthest_step = step;
    pruned_.farthest = index;
  }

  void tally(const BodyPair& hit) {
    const auto owner = [&](BodyId body) { return bodies_.robotOf(body); };
    const bool self = owner(hit.first).valid() && owner(hit.first) == owner(hit.second);
    pruned_.rejects.add(self ? Cause::kSelfCollision : Cause::kCollision,
                        {bodies_.name(hit.first), bodies_.name(hit.second)});
  }

  const PruneQuery& query_;
  const Manipulator& manipulator_;
  GraspChecker checker_;
  const CollisionScene& bodies_;
  IkQuery ik_;
  std::vector<ArmVector> solutions_;
  std::vector<std::pair<double, std::size_t>> order_;  ///< cost, index in solutions_
  PrunedGrasps pruned_;
};

}  // namespace

const FeasibleGrasp* PrunedGrasps::find(int grasp) const {
  const auto found =
      std::lower_bound(kept.begin(), kept.end(), grasp,
                       [](const FeasibleGrasp& a, int index) { return a.grasp < index; });
  return found != kept.end() && found->grasp == grasp ? &*found : nullptr;
}

PrunedGrasps pruneGrasps(const PruneQuery& query, CollisionContext& open_context,
                         CollisionContext& closed_context, const CollisionScene& bodies,
                         const Deadline& deadline) {
  std::vector<int> all(query.candidates);
  if (all.empty()) {
    all.resize(query.manipulator->grasps->grasps.size());
    std::iota(all.begin(), all.end(), 0);
  }
  Pruner pruner(query, open_context, closed_context, bodies);
  for (const int index : all) {
    if (deadline.over()) break;
    pruner.test(index);
  }
  return pruner.take();
}

}  // namespace handover
