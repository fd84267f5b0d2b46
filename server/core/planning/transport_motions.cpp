// SPDX-License-Identifier: Apache-2.0
#include "core/planning/transport_motions.hpp"

#include "core/planning/grip_motion.hpp"

#include <handover/common/random.hpp>

#include <algorithm>

namespace handover {
namespace {

using enum StageAction;

constexpr std::size_t kOtherPlaces = 2;  // of a chain of one, to which a carry is sought

bool contains(const std::vector<BodyId>& bodies, BodyId body) {
  return std::find(bodies.begin(), bodies.end(), body) != bodies.end();
}

}  // namespace

TransportMotions::TransportMotions(const TransportProblem& problem,
                                   std::vector<const Manipulator*> holders, CollisionWorld& world,
                                   CollisionWorld& spare_world, const Deadline& deadline)
    : problem_(problem),
      holders_(std::move(holders)),
      stages_(makeStages(transportOf(problem.task, holders_.size()))),
      deadline_(deadline),
      context_(problem, holders_, world),
      spare_context_(problem, holders_, spare_world),
      free_motion_(problem.settings.free_motion, deadline),
      start_(context_.startState()) {}

AllowedContacts TransportMotions::contactsOf(std::size_t holder, StageAction action) const {
  const auto found = std::find_if(stages_.begin(), stages_.end(), [&](const TaskStage& stage) {
    return stage.holder == holder && stage.action == action;
  });
  return found == stages_.end() ? AllowedContacts{} : allowedContacts(*found);
}

std::uint64_t TransportMotions::seedFor(std::size_t holder, StageAction action, int grasp) const {
  const auto mix = SeededRandom::mix;
  const std::uint64_t stage = 16 * holder + static_cast<std::uint64_t>(action);
  return mix(mix(mix(problem_.seed) ^ stage) ^ static_cast<std::uint64_t>(grasp + 1));
}

// ---- Alg. 1

PrunedGrasps TransportMotions::pruneFirstAtStart(const PruneEffort& effort) {
  const Manipulator& arm = at(0);
  const ArmVector home = homeOf(arm);
  if (problem_.task.held_by) {
    PrunedGrasps held;
    held.tested = 1;
    held.kept.push_back({problem_.held_grasp, {home}, arm.kinematics->manipulability(home)});
    return held;
  }
  PruneQuery query{&arm, start_, HandMove::kCloses};
  query.open = besideContacts(0, kApproach);
  query.closed = contactsOf(0, kGrasp);
  query.cost = [&](int, const ArmVector& q) { return travelTime(arm, home, q); };
  query.effort = effort;
  return pruneGrasps(query, context_, spare_context_, *problem_.collision, deadline_);
}

PrunedGrasps TransportMotions::pruneLastAtGoal(const PruneEffort& effort) {
  const Manipulator& arm = at(last());
  const bool hold = problem_.task.end == TransportEnd::kHold;
  PruneQuery query{&arm, start_, hold ? HandMove::kHolds : HandMove::kOpens};
  query.state.X_WO = problem_.task.X_WO_goal;
  query.open = besideContacts(last(), kRetreat);
  query.closed = contactsOf(last(), hold ? kCarry : kPlace);
  // The paper's criterion: the dexterity of the placing.
  query.cost = [&](int, const ArmVector& q) { return -arm.kinematics->manipulability(q); };
  query.effort = effort;
  return pruneGrasps(query, context_, spare_context_, *problem_.collision, deadline_);
}

PrunedGrasps TransportMotions::pruneReceiverAt(std::size_t handover, const Pose& X_WH,
                                               const FeasibleGrasp& give) {
  const Manipulator& arm = at(handover + 1);
  const ArmVector home = homeOf(arm);
  PruneQuery query{&arm, start_, HandMove::kCloses};
  query.state.X_WO = X_WH;
  query.open = besideObject({}, handover + 1, arm);
  query.closed.hands = {handover + 1};
  query.candidates = {give.grasp};
  query.cost = [&](int, const ArmVector& q) {
    return travelTime(arm, home, q) + travelTime(arm, q, give.configurations.front());
  };
  query.effort = problem_.settings.pruning;
  return pruneGrasps(query, context_, spare_context_, *problem_.collision, deadline_);
}

PrunedGrasps TransportMotions::pruneGiverAt(std::size_t handover, const Pose& X_WH,
                                            const FeasibleGrasp& receive,
                                            const PrunedGrasps& takes) {
  const Manipulator& giver = at(handover);
  const Manipulator& receiver = at(handover + 1);
  const ArmVector home = homeOf(giver);
  PruneQuery query{&giver, start_, HandMove::kOpens};
  query.state.X_WO = X_WH;
  RobotVector& q_receiver = query.state.of(receiver);
  q_receiver =
      receiver.withFingers(receiver.withArm(std::move(q_receiver), receive.configurations.front()),
                           receiver.grasp(receive.grasp).closed);
  query.open.hands = query.closed.hands = {handover, handover + 1};
  for (const auto& take : takes.kept) query.candidates.push_back(take.grasp);
  query.other_hand = &receiver;
  query.conflicts = &hand_conflicts_[{handover, receive.grasp}];
  query.cost = [&](int grasp, const ArmVector& q) {
    const FeasibleGrasp* take = takes.find(grasp);
    const double come =
        take->configurations.empty() ? 0 : travelTime(giver, take->configurations.front(), q);
    return come + travelTime(giver, q, home);
  };
  query.effort = problem_.settings.pruning;
  return pruneGrasps(query, context_, spare_context_, *problem_.collision, deadline_);
}

bool TransportMotions::reaches(const Manipulator& arm, const Pose& X_WT) {
  const bool closed_form = arm.kinematics->closedForm();
  if (!closed_form && !arm.mapReaches(X_WT)) return false;
  ++ik_looks_;
  const bool reached = arm.reaches(X_WT);
  if (!closed_form && !reached) ++failed_ik_solves_;
  return reached;
}

bool TransportMotions::giverReaches(std::size_t handover, const Pose& X_WH, int receive,
                                    const PrunedGrasps& takes) {
  const Manipulator& arm = at(handover);
  const HandConflicts& conflicts = hand_conflicts_[{handover, receive}];
  const MayHold may_hold(arm, X_WH);
  return std::any_of(takes.kept.begin(), takes.kept.end(), [&](const FeasibleGrasp& take) {
    return may_hold(take.grasp) && !conflicts.contains(take.grasp) &&
           reaches(arm, X_WH * arm.grasp(take.grasp).X_OT);
  });
}

std::optional<BodyPair> TransportMotions::handsInTheWay(std::size_t handover, int receive,
                                                        const PrunedGrasps& takes) {
  const HandConflicts& conflicts = hand_conflicts_[{handover, receive}];
  if (conflicts.size() < takes.kept.size()) return std::nullopt;
  for (const FeasibleGrasp& take : takes.kept) {
    if (!conflicts.contains(take.grasp)) return std::nullopt;
  }
  return conflicts.at(takes.kept.front().grasp);
}

bool TransportMotions::receiverReaches(std::size_t handover, const Pose& X_WH, int grasp) {
  const Manipulator& arm = at(handover + 1);
  return MayHold(arm, X_WH)(grasp) && reaches(arm, X_WH * arm.grasp(grasp).X_OT);
}

bool TransportMotions::keepApproachable(std::size_t handover, const Pose& X_WH,
                                        FeasibleGrasp& receive) {
  const Manipulator& arm = at(handover + 1);
  const Grasp& grasp = arm.grasp(receive.grasp);
  const Pose X_WT = X_WH * grasp.X_OT;
  // Mostly the arm cannot fold so far: then no configuration needs to be looked at.
  const Pose X_WT_back = arm.backedOff(X_WT, problem_.settings.linear_motion.retreat.back());
  if (!arm.reaches(X_WT_back)) return false;

  CellState open = start_;
  open.X_WO = X_WH;
  open.of(arm) = arm.withFingers(std::move(open.of(arm)), grasp.open);
  StateChecker checker = context_.makeForArm(open, arm, besideObject({}, handover + 1, arm));
  const auto first = std::find_if(
      receive.configurations.begin(), receive.configurations.end(), [&](const ArmVector& q) {
        return checker.valid(q) && linearPath(arm, q, X_WT, X_WT_back, checker).has_value();
      });
  if (first == receive.configurations.end()) return false;
  receive.configurations.erase(receive.configurations.begin(), first);
  return true;
}

// ---- taking at the start, leaving at the goal

const std::optional<TransportMotions::PickMotion>& TransportMotions::pickMotion(
    const FeasibleGrasp& take, std::uint32_t patience) {
  Pick& pick = picks_[take.grasp];
  std::optional<PickMotion>& found = pick.motion;
  if (found || patience <= pick.patience) return found;
  pick.patience = patience;
  const Manipulator& arm = at(0);
  const LinearMotionSettings& linear = problem_.settings.linear_motion;
  const Grasp& grasp = arm.grasp(take.grasp);
  const Pose X_WT = start_.X_WO * grasp.X_OT;
  CellState open = start_;
  open.of(arm) = arm.withFingers(std::move(open.of(arm)), grasp.open);
  StateChecker open_checker = context_.makeForArm(open, arm, besideContacts(0, kApproach));
  StateChecker reach_checker = context_.makeForArm(open, arm, contactsOf(0, kReach));

  // Goals enter the goal tree as the search asks for them: each is the pre-grasp of one
  // configuration from which the straight approach and the lift exist.
  std::vector<PickMotion> candidates;
  std::size_t next = 0;
  const auto add = [&](const ArmVector& q) {
    open_checker.activate();
    if (!open_checker.valid(q)) return false;
    auto back = retreatPath(arm, q, X_WT, open_checker, linear);
    if (!back) return false;
    StateChecker held_checker =
        context_.makeForArm(holding(start_, arm, grasp, q), arm, contactsOf(0, kLift));
    if (gripContact(context_, arm, open, q, grasp.open, grasp.closed, contactsOf(0, kGrasp)) ||
        !held_checker.valid(q)) {
      return false;
    }
    auto lift = liftPath(arm, q, X_WT, held_checker, linear);
    if (!lift) return false;
    candidates.push_back({q, {}, reversed(std::move(*back)), std::move(*lift)});
    return true;
  };
  const std::size_t most =
      std::min(take.configurations.size(), patience * problem_.settings.configurations);
  const auto draw = [&](std::uint32_t i, ArmVector& goal) {
    // As long as there is none, every configuration counts.
    while (i >= candidates.size() &&
           next < (candidates.empty() ? take.configurations.size() : most)) {
      add(take.configurations[next++]);
    }
    if (i >= candidates.size()) return false;
    reach_checker.activate();
    goal = candidates[i].approach.waypoints.front();
    return true;
  };

  reach_checker.activate();
  std::uint32_t goal = 0;
  auto reach =
      free_motion_.solveToAny(arm, homeOf(arm), draw, reach_checker,
                              seedFor(0, kReach, take.grasp) + patience - 1, goal, patience);
  if (!reach || goal >= candidates.size()) return found;
  found = std::move(candidates[goal]);
  found->reach = std::move(*reach);
  return found;
}

std::optional<TransportMotions::PlaceMotion> TransportMotions::placeAt(const FeasibleGrasp& give,
                                                                       const ArmVector& q) {
  const Manipulator& arm = at(last());
  const Grasp& grasp = arm.grasp(give.grasp);
  const LinearMotionSettings& linear = problem_.settings.linear_motion;
  const bool hold = problem_.task.end == TransportEnd::kHold;
  StateChecker held_checker = context_.makeForArm(holding(start_, arm, grasp, q), arm,
                                                  contactsOf(last(), hold ? kCarry : kPlace));
  if (!held_checker.valid(q)) return std::nullopt;
  if (hold) return PlaceMotion{q, {}, {}, {}};
  const Pose X_WT = problem_.task.X_WO_goal * grasp.X_OT;
  auto up = liftPath(arm, q, X_WT, held_checker, linear);
  if (!up) return std::nullopt;
  CellState open = start_;
  open.X_WO = problem_.task.X_WO_goal;
  open.of(arm) = arm.withFingers(std::move(open.of(arm)), grasp.open);
  StateChecker open_checker = context_.makeForArm(open, arm, besideContacts(last(), kRetreat));
  if (!open_checker.valid(q)) return std::nullopt;
  auto back = retreatPath(arm, q, X_WT, open_checker, linear);
  if (!back) return std::nullopt;
  if (gripContact(context_, arm, open, q, grasp.closed, grasp.open, contactsOf(last(), kRelease))) {
    return std::nullopt;
  }
  StateChecker home_checker = context_.makeForArm(open, arm, contactsOf(last(), kHome));
  auto home = free_motion_.solve(arm, back->waypoints.back(), homeOf(arm), home_checker,
                                 seedFor(last(), kHome, give.grasp));
  if (!home) return std::nullopt;
  return PlaceMotion{q, reversed(std::move(*up)), std::move(*back), std::move(*home)};
}

const std::optional<TransportMotions::PlaceMotion>& TransportMotions::placeMotion(
    const FeasibleGrasp& give) {
  const ArmVector& first = give.configurations.front();
  const auto [entry, fresh] =
      places_.try_emplace({give.grasp, std::vector<double>(first.begin(), first.end())});
  const std::size_t most = std::min(give.configurations.size(), problem_.settings.configurations);
  for (std::size_t i = 0; fresh && i < most && !entry->second; ++i) {
    entry->second = placeAt(give, give.configurations[i]);
  }
  return entry->second;
}

// ---- both hands at the object

struct TransportMotions::HandPair {
  std::size_t handover;
  const Manipulator &giver, &receiver;
  const Grasp &grasp_g, &grasp_r;
  Pose X_WTg, X_WTr;
};

/// `hopeless`: these hands touch each other or the object whatever the arms do.
std::optional<TransportMotions::DualGrasp> TransportMotions::dualGraspAt(
    const HandPair& hands, const CellState& given, const ArmVector& q_g, const ArmVector& q_r,
    StateChecker& arriving, bool& hopeless) {
  const LinearMotionSettings& linear = problem_.settings.linear_motion;
  const std::size_t k = hands.handover;
  arriving.activate();
  if (!arriving.valid(q_r)) return std::nullopt;
  // The receiver has closed its hand; the giver's opens and leaves. Where this fails it costs less
  // to find out than how the receiver comes.
  CellState taken = given;
  RobotVector& q_receiver = taken.of(hands.receiver);
  q_receiver = hands.receiver.withFingers(hands.receiver.withArm(std::move(q_receiver), q_r),
                                          hands.grasp_r.closed);
  const AllowedContacts both = contactsOf(k + 1, kGrasp);
  if (!context_.makeForArm(taken, hands.receiver, both).valid(q_r)) return std::nullopt;
  RobotVector& q_giver = taken.of(hands.giver);
  q_giver = hands.giver.withFingers(std::move(q_giver), hands.grasp_g.open);
  StateChecker leaving = context_.makeForArm(taken, hands.giver, besideContacts(k, kRetreat));
  if (!leaving.valid(q_g) || !leaving.valid(homeOf(hands.giver))) return std::nullopt;
  auto hit = gripContact(context_, hands.receiver, given, q_r, hands.grasp_r.open,
                         hands.grasp_r.closed, both);
  if (!hit) {
    hit = gripContact(context_, hands.giver, taken, q_g, hands.grasp_g.closed, hands.grasp_g.open,
                      both);
  }
  if (hit) {
    const auto ofHands = [&](BodyId body) {
      return body == context_.objectBody() || contains(hands.giver.hand_bodies, body) ||
             contains(hands.receiver.hand_bodies, body);
    };
    hopeless = ofHands(hit->a) && ofHands(hit->b);
    return std::nullopt;
  }
  auto away = retreatPath(hands.giver, q_g, hands.X_WTg, leaving, linear);
  if (!away) return std::nullopt;
  arriving.activate();
  auto back = retreatPath(hands.receiver, q_r, hands.X_WTr, arriving, linear);
  if (!back) return std::nullopt;
  return DualGrasp{q_g, q_r, reversed(std::move(*back)), std::move(*away)};
}

/// Hands that were found to meet at no pose are not looked at again.
std::optional<TransportMotions::DualGrasp> TransportMotions::dualGrasp(
    std::size_t handover, const TransportTuple& tuple) {
  const HandsAt hands{handover, tuple.holders[handover].give.grasp,
                      tuple.holders[handover + 1].take.grasp};
  if (hopeless_hands_.contains(hands)) return std::nullopt;
  bool hopeless = false;
  auto found = findDualGrasp(handover, tuple, hopeless);
  if (hopeless) hopeless_hands_.insert(hands);
  return found;
}

std::optional<TransportMotions::DualGrasp> TransportMotions::findDualGrasp(
    std::size_t handover, const TransportTuple& tuple, bool& hopeless) {
  const FeasibleGrasp& give = tuple.holders[handover].give;
  const FeasibleGrasp& receive = tuple.holders[handover + 1].take;
  const Manipulator& giver = at(handover);
  const Manipulator& receiver = at(handover + 1);
  const Pose& X_WH = tuple.X_WH[handover];
  const Grasp& grasp_g = giver.grasp(give.grasp);
  const Grasp& grasp_r = receiver.grasp(receive.grasp);
  const HandPair hands{handover,           giver, receiver, grasp_g, grasp_r, X_WH * grasp_g.X_OT,
                       X_WH * grasp_r.X_OT};
  const auto most = [&](const FeasibleGrasp& grasp) {
    return std::min(grasp.configurations.size(), problem_.settings.configurations);
  };
  const Pose X_WTg_back =
      giver.backedOff(hands.X_WTg, problem_.settings.linear_motion.retreat.back());
  for (std::size_t i = 0; i < most(give); ++i) {
    const ArmVector& q_g = give.configurations[i];
    // Mostly the arm cannot fold so far.
    if (!straightLine(*giver.kinematics, q_g, giver.worldToArm(hands.X_WTg),
                      giver.worldToArm(X_WTg_back))) {
      continue;
    }
    CellState given = holding(stateBefore(handover, tuple), giver, grasp_g, q_g);
    given.X_WO = X_WH;
    given.holder = nullptr;  // stands still while the receiver comes
    given.of(receiver) = receiver.withFingers(std::move(given.of(receiver)), grasp_r.open);
    StateChecker arriving =
        context_.makeForArm(given, receiver, besideContacts(handover + 1, kApproach));
    if (!arriving.valid(homeOf(receiver))) continue;
    for (std::size_t j = 0; j < most(receive); ++j) {
      auto found = dualGraspAt(hands, given, q_g, receive.configurations[j], arriving, hopeless);
      if (found || hopeless) return found;
    }
  }
  return std::nullopt;
}

bool TransportMotions::handsMeet(std::size_t handover, const TransportTuple& tuple) {
  return dualGrasp(handover, tuple).has_value();
}

// ---- between

CellState TransportMotions::stateBefore(std::size_t holder, const TransportTuple& tuple) const {
  CellState state = start_;
  for (std::size_t k = 0; k < holder; ++k) {
    if (tuple.holders[k].take.grasp < 0) continue;  // not chosen yet
    RobotVector& q = state.of(at(k));
    q = at(k).withFingers(std::move(q), at(k).grasp(tuple.holders[k].take.grasp).open);
  }
  return state;
}

ArmVector TransportMotions::takeConfiguration(std::size_t holder, const Motions& motions) const {
  if (holder > 0) return motions.dual_grasps[holder - 1].q_r;
  return motions.pick != nullptr ? motions.pick->q : homeOf(at(0));
}

ArmVector TransportMotions::giveConfiguration(std::size_t holder, const Motions& motions) const {
  return holder == last() ? motions.place->q : motions.dual_grasps[holder].q_g;
}

std::optional<JointPath> TransportMotions::carryPath(std::size_t holder,
                                                     const TransportTuple& tuple,
                                                     const Motions& motions, Cause& cause) {
  const Manipulator& arm = at(holder);
  const HolderGrasp& grasp = tuple.holders[holder];
  const bool lifted = holder == 0 && motions.pick != nullptr;
  const ArmVector from =
      lifted ? motions.pick->lift.waypoints.back() : takeConfiguration(holder, motions);
  const bool placed = holder == last() && problem_.task.end == TransportEnd::kRelease;
  const ArmVector to =
      placed ? motions.place->place.waypoints.front() : giveConfiguration(holder, motions);
  const CellState state =
      holding(stateBefore(holder, tuple), arm, arm.grasp(grasp.take.grasp), from);
  StateChecker checker = context_.makeForArm(state, arm, contactsOf(holder, kCarry));
  auto path = free_motion_.solve(arm, from, to, checker, seedFor(holder, kCarry, grasp.give.grasp));
  cause = checker.tilted() > checker.touched() ? Cause::kTilt : Cause::kNoPath;
  return path;
}

/// The most dexterous configuration there may be on another branch than the one that takes the
/// object; where there is a handover, its configurations are near those that follow.
std::optional<JointPath> TransportMotions::carryElsewhere(const TransportTuple& tuple,
                                                          Motions& motions) {
  const FeasibleGrasp& give = tuple.holders.front().give;
  const ArmVector from = takeConfiguration(0, motions), failed = motions.place->q;
  std::vector<ArmVector> others = give.configurations;
  std::stable_sort(others.begin(), others.end(), [&](const ArmVector& a, const ArmVector& b) {
    return travelTime(at(0), from, a) < travelTime(at(0), from, b);
  });
  std::size_t tried = 0;
  for (const ArmVector& q : others) {
    if (q == failed) continue;
    if (tried == kOtherPlaces || deadline_.over()) break;
    auto place = placeAt(give, q);
    if (!place) continue;
    ++tried;
    motions.place = &elsewhere_.emplace_back(std::move(*place));
    Cause cause = Cause::kNoPath;
    if (auto path = carryPath(0, tuple, motions, cause)) return path;
  }
  return std::nullopt;
}

std::optional<JointPath> TransportMotions::reachPath(std::size_t holder,
                                                     const TransportTuple& tuple,
                                                     const Motions& motions) {
  const Manipulator& arm = at(holder);
  const Manipulator& giver = at(holder - 1);
  const DualGrasp& hands = motions.dual_grasps[holder - 1];
  const int grasp = tuple.holders[holder].take.grasp;
  CellState state = holding(stateBefore(holder - 1, tuple), giver,
                            giver.grasp(tuple.holders[holder - 1].give.grasp), hands.q_g);
  state.holder = nullptr;
  state.X_WO = tuple.X_WH[holder - 1];
  state.of(arm) = arm.withFingers(std::move(state.of(arm)), arm.grasp(grasp).open);
  StateChecker checker = context_.makeForArm(state, arm, contactsOf(holder, kReach));
  SeedPaths known;
  if (holder == last()) known.from_start = reversed(motions.place->home).waypoints;
  return free_motion_.solve(arm, homeOf(arm), hands.approach.waypoints.front(), checker,
                            seedFor(holder, kReach, grasp), known);
}

std::optional<JointPath> TransportMotions::homePath(std::size_t holder, const TransportTuple& tuple,
                                                    const Motions& motions) {
  const Manipulator& arm = at(holder);
  const Manipulator& receiver = at(holder + 1);
  const DualGrasp& hands = motions.dual_grasps[holder];
  const int grasp = tuple.holders[holder].give.grasp;
  CellState state = stateBefore(holder + 1, tuple);
  state.X_WO = tuple.X_WH[holder];
  RobotVector& q_receiver = state.of(receiver);
  q_receiver = receiver.withFingers(receiver.withArm(std::move(q_receiver), hands.q_r),
                                    receiver.grasp(tuple.holders[holder + 1].take.grasp).closed);
  StateChecker checker = context_.makeForArm(state, arm, contactsOf(holder, kHome));
  SeedPaths known;  // it may go back by the way that it came
  if (holder == 0 && motions.pick != nullptr) known.from_goal = motions.pick->reach.waypoints;
  const std::vector<ArmVector>& came = motions.carries[holder].waypoints;
  known.from_goal.insert(known.from_goal.end(), came.begin(), came.end());
  return free_motion_.solve(arm, hands.retreat.waypoints.back(), homeOf(arm), checker,
                            seedFor(holder, kHome, grasp), known);
}

TransportMotions::FailedMotion TransportMotions::lastCarry(const TransportTuple& tuple,
                                                           const Motions& motions) const {
  return {last(), kCarry, tuple.holders.back().give.grasp, takeConfiguration(last(), motions), {}};
}

TransportMotions::FailedMotion TransportMotions::wayHome(std::size_t holder,
                                                         const TransportTuple& tuple,
                                                         const Motions& motions) const {
  const DualGrasp& hands = motions.dual_grasps[holder];
  return {holder, kHome, tuple.holders[holder].give.grasp, hands.q_g, hands.q_r};
}

/// What was not found is not sought again where only little is otherwise: hands at home that are
/// opened differently, the way by which the arm came.
std::optional<Cause> TransportMotions::knownToFail(const FailedMotion& motion) const {
  if (problem_.settings.independent) return std::nullopt;
  const auto found = std::find_if(failed_motions_.begin(), failed_motions_.end(),
                                  [&](const auto& failed) { return failed.first == motion; });
  if (found == failed_motions_.end()) return std::nullopt;
  return found->second;
}

MotionFailure TransportMotions::noWay(std::size_t holder, StageAction action, Cause cause) {
  if (holder < last()) {
    most_failed_ways_ = std::max(most_failed_ways_, ++failed_ways_[{holder, action}]);
  }
  return {{static_cast<std::uint32_t>(holder), action}, cause, {}};
}

/// What fails most and costs least to find out comes first.
std::optional<MotionFailure> TransportMotions::findMotions(const TransportTuple& tuple,
                                                           Motions& motions) {
  const std::size_t n = holders_.size();
  const auto failure = [](std::size_t holder, StageAction action, Cause cause = Cause::kNoPath) {
    return MotionFailure{{static_cast<std::uint32_t>(holder), action}, cause, {}};
  };
  for (std::size_t k = 0; k + 1 < n; ++k) {
    auto hands = dualGrasp(k, tuple);
    if (!hands) return failure(k + 1, kGrasp, Cause::kHandsMeet);
    motions.dual_grasps.push_back(std::move(*hands));
  }
  const auto& place = placeMotion(tuple.holders.back().give);
  if (!place) {
    const bool hold = problem_.task.end == TransportEnd::kHold;
    return failure(last(), hold ? kCarry : kPlace, Cause::kStraightApproach);
  }
  motions.place = &*place;
  motions.reaches.resize(n);
  motions.carries.resize(n);
  motions.homes.resize(n);
  // The last holder carries it away when the giver is back, whatever comes before.
  if (last() > 0) {
    if (const auto cause = knownToFail(lastCarry(tuple, motions))) {
      return failure(last(), kCarry, *cause);
    }
  }
  Cause cause = Cause::kNoPath;
  const auto carry = [&](std::size_t holder) {
    auto path = carryPath(holder, tuple, motions, cause);
    if (!path && n == 1) path = carryElsewhere(tuple, motions);
    if (path) motions.carries[holder] = std::move(*path);
    return path.has_value();
  };
  if (last() > 0 && !carry(last())) {
    failed_motions_.emplace_back(lastCarry(tuple, motions), cause);
    return failure(last(), kCarry, cause);
  }
  if (!problem_.task.held_by) {
    const auto& pick = pickMotion(tuple.holders.front().take);
    if (!pick) return failure(0, kReach);
    motions.pick = &*pick;
  }
  for (std::size_t k = 0; k < last(); ++k) {
    if (knownToFail(wayHome(k, tuple, motions))) return failure(k, kHome);
  }
  for (std::size_t k = 0; k < n; ++k) {
    if ((k < last() || n == 1) && !carry(k)) return noWay(k, kCarry, cause);
    if (k == last()) break;
    auto reach = reachPath(k + 1, tuple, motions);
    if (!reach) return failure(k + 1, kReach);
    motions.reaches[k + 1] = std::move(*reach);
    auto home = homePath(k, tuple, motions);
    if (!home) {
      failed_motions_.emplace_back(wayHome(k, tuple, motions), Cause::kNoPath);
      return noWay(k, kHome, Cause::kNoPath);
    }
    motions.homes[k] = std::move(*home);
  }
  return std::nullopt;
}

// ---- the whole

const JointPath& TransportMotions::armPath(const TaskStage& stage, const Motions& motions) const {
  const std::size_t k = stage.holder;
  const bool first = k == 0;
  const bool ends = k == last();
  switch (stage.action) {
    case kReach:
      return first ? motions.pick->reach : motions.reaches[k];
    case kApproach:
      return first ? motions.pick->approach : motions.dual_grasps[k - 1].approach;
    case kLift:
      return motions.pick->lift;
    case kPlace:
      return motions.place->place;
    case kRetreat:
      return ends ? motions.place->retreat : motions.dual_grasps[k].retreat;
    case kHome:
      return ends ? motions.place->home : motions.homes[k];
    case kCarry:
    case kGrasp:
    case kRelease:
    case kUnspecified:
      break;
  }
  return motions.carries[k];
}

StagePath TransportMotions::gripStage(const TaskStage& stage, const Grasp& grasp,
                                      CellState& now) const {
  const Manipulator& arm = at(stage.holder);
  StagePath added;
  added.stage = stage;
  added.mover = &arm;
  added.state = now;
  added.dofs = arm.hand->dofs;
  RobotVector& q = now.of(arm);
  const bool grips = typeOf(stage.action) == StageType::kGrip;
  added.waypoints = {arm.fingersOf(q), grips ? grasp.closed : grasp.open};
  q = arm.withFingers(std::move(q), added.waypoints.back());
  return added;
}

StagePath TransportMotions::armStage(const TaskStage& stage, const Grasp& grasp,
                                     const JointPath& moves, const TransportTuple& tuple,
                                     CellState& now) const {
  const Manipulator& arm = at(stage.holder);
  StagePath added;
  added.stage = stage;
  added.mover = &arm;
  if (carries(stage)) now = holding(std::move(now), arm, grasp, moves.waypoints.front());
  added.state = now;
  added.dofs = arm.arm_model->dofs;
  added.waypoints.assign(moves.waypoints.begin(), moves.waypoints.end());
  RobotVector& q = now.of(arm);
  if (stage.action == kReach && !arm.hand->dofs.empty()) {
    added.fingers = FingerMotion{arm.fingersOf(q), grasp.open};
    q = arm.withFingers(std::move(q), grasp.open);
  }
  q = arm.withArm(std::move(q), moves.waypoints.back());
  if (!carries(stage)) return added;
  // Where it is given or put down the object stands as the tuple has it.
  now = holding(std::move(now), arm, grasp, moves.waypoints.back());
  now.holder = nullptr;
  if (stage.action == kCarry && stage.holder < last()) now.X_WO = tuple.X_WH[stage.holder];
  if (stage.action == kPlace) now.X_WO = problem_.task.X_WO_goal;
  return added;
}

TransportPath TransportMotions::assemble(const TransportTuple& tuple,
                                         const Motions& motions) const {
  TransportPath path;
  path.X_WH = tuple.X_WH;
  for (std::size_t k = 0; k < holders_.size(); ++k) {
    const ArmKinematics& kinematics = *at(k).kinematics;
    path.holders.push_back({holders_[k],
                            tuple.holders[k].take.grasp,
                            {kinematics.manipulability(takeConfiguration(k, motions)),
                             kinematics.manipulability(giveConfiguration(k, motions))}});
  }
  CellState now = start_;
  for (const TaskStage& stage : stages_) {
    const Grasp& grasp = at(stage.holder).grasp(path.holders[stage.holder].grasp);
    const StageType type = typeOf(stage.action);
    const bool fingers = type == StageType::kGrip || type == StageType::kRelease;
    path.stages.push_back(fingers ? gripStage(stage, grasp, now)
                                  : armStage(stage, grasp, armPath(stage, motions), tuple, now));
  }
  return path;
}

std::variant<TransportPath, MotionFailure> TransportMotions::connect(const TransportTuple& tuple) {
  Motions motions;
  if (const auto failure = findMotions(tuple, motions)) return *failure;
  return assemble(tuple, motions);
}

}  // namespace handover
