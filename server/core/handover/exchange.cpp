// SPDX-License-Identifier: Apache-2.0
#include "core/handover/exchange.hpp"

#include "core/motion/lazy_roadmap.hpp"
#include "core/motion/straight.hpp"

#include <handover/common/random.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace handover {
namespace {

// Straight way back from a grasp, and up with the object [m]: the longest that works.
constexpr std::array<double, 3> kBackOff{0.10, 0.07, 0.04};
constexpr std::array<double, 3> kLift{0.08, 0.05, 0.03};  // lift, last descent [m]
constexpr double kViaDetour = 2.2;  // of a simple way: a tree's is hardly shorter, and dear
constexpr double kRounding = 0.05;  // corners of routes can be cut by so much when timed [rad]
// Farther back than a straight approach, to the sides from there, and up: where a hand gets round
// an object [m].
constexpr std::array<double, 3> kFartherBack{0.05, 0.12, 0.25};
constexpr double kAside = 0.12;
constexpr std::array<double, 2> kHigher{0.12, 0.25};
constexpr Eigen::Index kBowedJoints = 4;                     // those that carry the hand
constexpr std::array<double, 4> kBow{0.7, -0.7, 1.4, -1.4};  // [rad]
constexpr double kFarthestVia = 1.5;  // of one joint, from the end that it is back or up from [rad]
constexpr double kCornerTime = 0.5;   // what a corner costs, about [s]
constexpr double kMostCorners = 4;
constexpr std::uint32_t kDirectGoals = 4;                   // goals tried without a tree
constexpr std::uint32_t kFewChecks = 15, kViaChecks = 150;  // segments looked at for a simple way
constexpr std::size_t kSimpleWay = 3;                       // waypoints of ways found so, mostly

JointPath reversed(JointPath path) {
  std::reverse(path.waypoints.begin(), path.waypoints.end());
  return path;
}

/// `first` then `second`, which starts where the first ends.
JointPath joined(JointPath first, const JointPath& second) {
  first.waypoints.insert(first.waypoints.end(), second.waypoints.begin() + 1,
                         second.waypoints.end());
  return first;
}

Pose raised(Pose X, double height) {
  X.translation().z() += height;
  return X;
}

const Grasp& graspOf(const Manipulator& role, const FeasibleGrasp& feasible) {
  return role.grasps->grasps[static_cast<std::size_t>(feasible.grasp)];
}

void setArmPath(StagePath& stage, const JointPath& path) {
  stage.dofs = stage.mover->arm_model->dofs;
  stage.waypoints.assign(path.waypoints.begin(), path.waypoints.end());
}

void setFingerPath(StagePath& stage, const Eigen::VectorXd& from, const Eigen::VectorXd& to) {
  stage.dofs = stage.mover->hand->dofs;
  stage.waypoints = {from, to};
}

}  // namespace

ExchangePlanner::ExchangePlanner(const HandoverProblem& problem, const Manipulator& giver,
                                 const Manipulator& receiver, CollisionWorld& world,
                                 CollisionWorld& spare_world, const ExchangeBudget& budget,
                                 const Deadline& deadline)
    : problem_(problem),
      giver_(giver),
      receiver_(receiver),
      budget_(budget),
      deadline_(deadline),
      checkers_(problem, giver, receiver, world),
      spare_checkers_(problem, giver, receiver, spare_world),
      start_(checkers_.startState()) {}

std::uint64_t ExchangePlanner::seedFor(StageKind kind, int grasp) const {
  const auto mix = SeededRandom::mix;
  return mix(mix(mix(problem_.seed) ^ static_cast<std::uint64_t>(kind)) ^
             static_cast<std::uint64_t>(grasp + 1));
}

MotionProblem ExchangePlanner::motionProblem(const Manipulator& role, StateChecker& checker) const {
  MotionProblem motion;
  motion.lower = role.kinematics->lower();
  motion.upper = role.kinematics->upper();
  motion.valid = [&checker](const ArmVector& q) { return checker.valid(q); };
  motion.valid_between = [&checker](const ArmVector& from, const ArmVector& to) {
    return checker.isMotionFree(SegmentMotion(from, to));
  };
  motion.rounding = kRounding;
  return motion;
}

std::vector<ArmVector> ExchangePlanner::viasBetween(const Manipulator& role, const ArmVector& from,
                                                    const ArmVector& to) const {
  std::vector<ArmVector> vias;
  // Past the object and out of what stands about it: back or up from one of the ends.
  for (const ArmVector* end : {&from, &to}) {
    const Pose X_WT = role.toolPose(*end);
    const auto add = [&](const Pose& X_WT_via) {
      ArmVector q;
      if (role.kinematics->trackPose(role.worldToArm(X_WT_via), *end, kFarthestVia, q)) {
        vias.push_back(q);
      }
    };
    for (const double distance : kFartherBack) {
      const Pose X_WT_back = role.backedOff(X_WT, distance);
      add(X_WT_back);
      for (int axis = 0; axis < 3; ++axis) {
        Eigen::Vector3d aside = kAside * Eigen::Vector3d::Unit(axis);
        if (std::abs(role.arm_model->approach_axis.dot(aside)) > 0.5 * kAside) continue;
        for (const double side : {1.0, -1.0}) {
          add(X_WT_back * Eigen::Translation3d(side * aside));
        }
      }
    }
    for (const double height : kHigher) add(raised(X_WT, height));
  }
  // Round what stands before the arm where it is: a joint turned far first.
  for (Eigen::Index k = 0; k < std::min(kBowedJoints, from.size()); ++k) {
    for (const double by : kBow) {
      ArmVector q = from;
      q[k] += by;
      if (q[k] >= role.kinematics->lower()[k] && q[k] <= role.kinematics->upper()[k]) {
        vias.push_back(q);
      }
    }
  }
  // Some joints first, then the others.
  for (Eigen::Index k = 1; k < from.size(); ++k) {
    ArmVector near_first = from, far_first = to;
    near_first.head(k) = to.head(k);
    far_first.head(k) = from.head(k);
    vias.push_back(near_first);
    vias.push_back(far_first);
  }
  return vias;
}

std::optional<JointPath> ExchangePlanner::throughVia(const Manipulator& role,
                                                     const MotionProblem& motion,
                                                     const ArmVector& from, const ArmVector& to,
                                                     const std::vector<ArmVector>& known,
                                                     std::uint32_t checks) const {
  // Nothing is cheaper than to go straight, and often that is free.
  if (segmentValid(motion, from, to)) return JointPath{{from, to}};
  const auto cost = [&](const ArmVector& a, const ArmVector& b) {
    return travelTime(role, a, b) + kCornerTime;
  };
  LazyRoadmapSettings settings;
  settings.most_checks = checks;
  settings.most = kViaDetour * travelTime(role, from, to) + kMostCorners * kCornerTime;
  settings.straight = false;
  std::vector<ArmVector> vias = viasBetween(role, from, to);
  vias.insert(vias.end(), known.begin(), known.end());
  return lazyShortestPath(motion, from, to, std::move(vias), cost, settings, deadline_);
}

std::optional<BodyContact> ExchangePlanner::fingersHit(const Manipulator& role, CellState state,
                                                       const ArmVector& q,
                                                       const Eigen::VectorXd& from,
                                                       const Eigen::VectorXd& to,
                                                       const AllowedContacts& contacts) const {
  RobotVector& robot = state.q[static_cast<std::size_t>(role.robot)];
  robot = role.withArm(std::move(robot), q);
  StateChecker checker = checkers_.make(state, role, role.hand->dofs, contacts);
  return checker.hitAlong(SegmentMotion(from, to));
}

std::optional<JointPath> ExchangePlanner::straight(const Manipulator& role, const ArmVector& q,
                                                   const Pose& X_WT, const Pose& X_WT_end,
                                                   StateChecker& checker) {
  auto line = straightLine(*role.kinematics, q, role.worldToArm(X_WT), role.worldToArm(X_WT_end));
  if (!line || !checker.valid(line->waypoints.back()) ||
      !checker.isMotionFree(PolylineMotion(line->waypoints))) {
    return std::nullopt;
  }
  return std::move(*line);
}

template <typename EndAt>
std::optional<JointPath> ExchangePlanner::longestStraight(const Manipulator& role,
                                                          const ArmVector& q, const Pose& X_WT,
                                                          std::span<const double> distances,
                                                          const EndAt& end_at,
                                                          StateChecker& checker) {
  // The shortest first: where it is blocked, longer ones are, too.
  auto shortest = straight(role, q, X_WT, end_at(distances.back()), checker);
  if (!shortest) return std::nullopt;
  for (const double distance : distances.first(distances.size() - 1)) {
    auto line = straight(role, q, X_WT, end_at(distance), checker);
    if (line) return line;
  }
  return shortest;
}

std::optional<JointPath> ExchangePlanner::backOff(const Manipulator& role, const ArmVector& q,
                                                  const Pose& X_WT, StateChecker& checker) {
  const auto back = [&](double distance) { return role.backedOff(X_WT, distance); };
  return longestStraight(role, q, X_WT, kBackOff, back, checker);
}

std::optional<JointPath> ExchangePlanner::lifted(const Manipulator& role, const ArmVector& q,
                                                 const Pose& X_WT, StateChecker& checker) {
  const auto up = [&](double height) { return raised(X_WT, height); };
  return longestStraight(role, q, X_WT, kLift, up, checker);
}

std::optional<JointPath> ExchangePlanner::search(const Manipulator& role, const ArmVector& from,
                                                 const GoalSampler& goals, StateChecker& checker,
                                                 StageKind kind, int grasp, Ends ends,
                                                 std::uint32_t* goal, const SeedPaths& known) {
  const MotionProblem motion = motionProblem(role, checker);
  // Where a tree was needed before, it is needed again.
  const bool hard = known.from_start.size() > kSimpleWay;
  // Most ways are simple. First without a tree; of several goals, those that are simply come to.
  ArmVector to;
  if (!checker.valid(from)) return std::nullopt;
  for (const std::uint32_t checks : {kFewChecks, kViaChecks}) {
    if (ends == Ends::kOne && (checks == kFewChecks) != hard) continue;
    for (std::uint32_t i = 0; i < kDirectGoals && goals(i, to); ++i) {
      if (!checker.valid(to)) continue;
      if (auto path = throughVia(role, motion, from, to, known.from_goal, checks)) {
        if (goal != nullptr) *goal = i;
        return path;
      }
    }
  }
  IkBiRrtSettings settings;
  settings.direct_goals = 0;
  settings.max_iterations = budget_.rrt_iterations;
  settings.seed = SeededRandom::mix(seedFor(kind, grasp));
  settings.from_start = known.from_start;
  settings.from_goal = known.from_goal;
  std::uint32_t found_goal = 0;
  const auto path = planIkBiRrt(motion, from, goals, settings, deadline_, &found_goal);
  if (!path) return std::nullopt;
  if (goal != nullptr) *goal = found_goal;
  return shortcut(motion, *path, settings.seed, budget_.shortcut_attempts, deadline_);
}

std::optional<JointPath> ExchangePlanner::route(const Manipulator& role, const ArmVector& from,
                                                const ArmVector& to, StateChecker& checker,
                                                StageKind kind, int grasp, const SeedPaths& known) {
  const auto only_goal = [&](std::uint32_t i, ArmVector& q) {
    q = to;
    return i == 0;
  };
  return search(role, from, only_goal, checker, kind, grasp, Ends::kOne, nullptr, known);
}

CellState ExchangePlanner::holding(CellState state, const Manipulator& role, const Grasp& grasp,
                                   const ArmVector& q) const {
  RobotVector& robot = state.q[static_cast<std::size_t>(role.robot)];
  robot = role.withFingers(role.withArm(std::move(robot), q), grasp.closed);
  state.holder = &role;
  state.X_TO = grasp.X_OT.inverse();
  state.X_WO = role.toolPose(q) * state.X_TO;
  return state;
}

// ---- Alg. 1

namespace {

/// How a hand is about a grasp: it comes with its fingers as they start and closes them there, or
/// it holds the object and opens them.
enum class HandMove { kCloses, kOpens };

/// Tests a grasp with the hand open and closed, everything else as in a state. Each of the two has
/// a world of its own, so that the scene is set anew only when the grasp changes.
class GraspChecker : public GraspTest {
 public:
  GraspChecker(const CollisionContext& open_checkers, const CollisionContext& closed_checkers,
               const CellState& state, const Manipulator& role, HandMove move, AllowedContacts open,
               AllowedContacts closed)
      : role_(role),
        q_(state.q[static_cast<std::size_t>(role.robot)]),
        move_(move),
        open_(open_checkers.make(state, role, role.arm_model->dofs, open)),
        closed_(closed_checkers.make(state, role, role.arm_model->dofs, closed)) {}

  std::optional<BodyPair> handTouches(const Grasp& grasp, const Pose& X_WT) override {
    set(grasp);
    if (auto hit = open_.toolTouches(X_WT)) return hit;
    if (move_ == HandMove::kCloses) {  // a table beside the object may be in the fingers' way
      const Eigen::VectorXd from = role_.fingersOf(q_);
      for (const double part : {0.33, 0.67}) {
        closed_.setPosture(role_.robot, role_.withFingers(q_, from + part * (grasp.closed - from)));
        if (auto hit = closed_.toolTouches(X_WT)) {
          grasp_ = nullptr;
          return hit;
        }
      }
      closed_.setPosture(role_.robot, role_.withFingers(q_, grasp.closed));
    }
    return closed_.toolTouches(X_WT);
  }

  std::optional<BodyPair> armTouches(const Grasp& grasp, const ArmVector& q) override {
    set(grasp);
    if (auto hit = open_.armTouches(q, StateChecker::ArmPart::kAll)) return hit;
    // The arm is where it was; only the fingers are not.
    return closed_.armTouches(q, StateChecker::ArmPart::kToolWithArm);
  }

 private:
  void set(const Grasp& grasp) {
    if (&grasp == grasp_) return;
    grasp_ = &grasp;
    open_.setPosture(role_.robot,
                     move_ == HandMove::kCloses ? q_ : role_.withFingers(q_, grasp.open));
    closed_.setPosture(role_.robot, role_.withFingers(q_, grasp.closed));
  }

  const Manipulator& role_;
  RobotVector q_;
  HandMove move_;
  const Grasp* grasp_ = nullptr;
  StateChecker open_, closed_;
};

}  // namespace

PrunedGrasps ExchangePlanner::pruneGiverAtStart(const PruneEffort& effort) {
  GraspChecker test(checkers_, spare_checkers_, start_, giver_, HandMove::kCloses,
                    {.start_rest = true}, {.giver_hand = true, .start_rest = true});
  const ArmVector home = giver_.armOf(start_.q[static_cast<std::size_t>(giver_.robot)]);
  const auto cost = [&](int, const ArmVector& q) { return travelTime(giver_, home, q); };
  return pruneGrasps(giver_, *problem_.collision, start_.X_WO, {}, cost, test, effort, deadline_);
}

PrunedGrasps ExchangePlanner::pruneReceiverAtGoal(const PruneEffort& effort) {
  CellState state = start_;
  state.X_WO = problem_.task.X_WO_goal;
  GraspChecker test(checkers_, spare_checkers_, state, receiver_, HandMove::kOpens,
                    {.goal_rest = true}, {.receiver_hand = true, .goal_rest = true});
  // The paper's criterion: the dexterity of the placing.
  const auto cost = [&](int, const ArmVector& q) {
    return -receiver_.kinematics->manipulability(q);
  };
  return pruneGrasps(receiver_, *problem_.collision, state.X_WO, {}, cost, test, effort, deadline_);
}

PrunedGrasps ExchangePlanner::pruneReceiverAt(const Pose& X_WH, const FeasibleGrasp& place) {
  CellState state = start_;
  state.X_WO = X_WH;
  // With the giver's arm at its start: that is where it has to get to while the receiver stands
  // here.
  GraspChecker test(checkers_, spare_checkers_, state, receiver_, HandMove::kCloses, {},
                    {.receiver_hand = true});
  const ArmVector home = receiver_.armOf(start_.q[static_cast<std::size_t>(receiver_.robot)]);
  const auto cost = [&](int, const ArmVector& q) {
    return travelTime(receiver_, home, q) + travelTime(receiver_, q, place.configurations.front());
  };
  return pruneGrasps(receiver_, *problem_.collision, X_WH, {place.grasp}, cost, test, PruneEffort{},
                     deadline_);
}

bool ExchangePlanner::reaches(const Manipulator& role, const Pose& X_WT) {
  const bool closed_form = role.kinematics->closedForm();
  if (!closed_form && !role.mapReaches(X_WT)) return false;
  const bool reached = role.reaches(X_WT);
  if (!closed_form && !reached) ++searches_in_vain_;
  return reached;
}

bool ExchangePlanner::giverReaches(const Pose& X_WH, const PrunedGrasps& picks) {
  return std::any_of(picks.kept.begin(), picks.kept.end(), [&](const FeasibleGrasp& pick) {
    return reaches(giver_, X_WH * graspOf(giver_, pick).X_OT);
  });
}

bool ExchangePlanner::receiverReaches(const Pose& X_WH, const FeasibleGrasp& place) {
  return reaches(receiver_, X_WH * graspOf(receiver_, place).X_OT);
}

PrunedGrasps ExchangePlanner::pruneGiverAt(const Pose& X_WH, const FeasibleGrasp& receive,
                                           const PrunedGrasps& picks) {
  CellState state = start_;
  state.X_WO = X_WH;
  RobotVector& robot = state.q[static_cast<std::size_t>(receiver_.robot)];
  robot = receiver_.withFingers(receiver_.withArm(std::move(robot), receive.configurations.front()),
                                graspOf(receiver_, receive).closed);
  const AllowedContacts both{.giver_hand = true, .receiver_hand = true};
  GraspChecker test(checkers_, spare_checkers_, state, giver_, HandMove::kOpens, both, both);
  std::vector<int> candidates;
  for (const auto& pick : picks.kept) candidates.push_back(pick.grasp);
  const ArmVector home = giver_.armOf(start_.q[static_cast<std::size_t>(giver_.robot)]);
  const auto cost = [&](int grasp, const ArmVector& q) {
    return travelTime(giver_, picks.find(grasp)->configurations.front(), q) +
           travelTime(giver_, q, home);
  };
  return pruneGrasps(giver_, *problem_.collision, X_WH, candidates, cost, test, PruneEffort{},
                     deadline_);
}

// ---- motions

bool ExchangePlanner::keepReachable(const Pose& X_WH, FeasibleGrasp& receive) {
  const Grasp& grasp = graspOf(receiver_, receive);
  const Pose X_WT = X_WH * grasp.X_OT;
  // Mostly the arm cannot fold so far: then no configuration needs to be looked at.
  const Pose X_WT_back = receiver_.backedOff(X_WT, kBackOff.back());
  if (!receiver_.reaches(X_WT_back)) return false;

  // With its fingers as they start: an arm stage moves the arm alone.
  CellState open = start_;
  open.X_WO = X_WH;
  StateChecker checker = checkers_.make(open, receiver_, receiver_.arm_model->dofs, {});
  const auto first = std::find_if(
      receive.configurations.begin(), receive.configurations.end(), [&](const ArmVector& q) {
        return checker.valid(q) && straight(receiver_, q, X_WT, X_WT_back, checker).has_value();
      });
  if (first == receive.configurations.end()) return false;
  receive.configurations.erase(receive.configurations.begin(), first);
  return true;
}

const std::optional<ExchangePlanner::PickMotion>& ExchangePlanner::pickMotion(
    const FeasibleGrasp& pick) {
  const auto [entry, fresh] = picks_.try_emplace(pick.grasp);
  std::optional<PickMotion>& found = entry->second;
  if (!fresh) return found;
  const Grasp& grasp = graspOf(giver_, pick);
  // With its fingers as they start: an arm stage moves the arm alone.
  StateChecker open_checker =
      checkers_.make(start_, giver_, giver_.arm_model->dofs, {.start_rest = true});

  const Pose X_WT = start_.X_WO * grasp.X_OT;
  const Eigen::VectorXd fingers_start =
      giver_.fingersOf(start_.q[static_cast<std::size_t>(giver_.robot)]);

  // Goals enter the goal tree as the search asks for them: each is the pre-grasp of one
  // configuration from which the straight approach and the lift exist.
  struct Candidate {
    ArmVector q_pick;
    JointPath approach, lift;
  };

  std::vector<Candidate> candidates;
  std::size_t next = 0;
  const auto draw = [&](std::uint32_t i, ArmVector& goal) {
    if (i < candidates.size()) {  // drawn in an earlier search
      goal = candidates[i].approach.waypoints.front();
      return true;
    }
    while (next < pick.configurations.size() && next < budget_.configurations) {
      const ArmVector& q = pick.configurations[next++];
      open_checker.activate();
      if (!open_checker.valid(q)) continue;
      const auto back = backOff(giver_, q, X_WT, open_checker);
      if (!back) continue;
      const CellState held = holding(start_, giver_, grasp, q);
      StateChecker held_checker = checkers_.make(held, giver_, giver_.arm_model->dofs,
                                                 {.giver_hand = true, .start_rest = true});
      std::optional<JointPath> lift;
      if (!fingersHit(giver_, start_, q, fingers_start, grasp.closed,
                      {.giver_hand = true, .start_rest = true}) &&
          held_checker.valid(q)) {
        lift = lifted(giver_, q, X_WT, held_checker);
      }
      open_checker.activate();
      if (!lift) continue;
      candidates.push_back({q, reversed(*back), *lift});
      goal = back->waypoints.back();
      return true;
    }
    return false;
  };

  open_checker.activate();
  std::uint32_t goal = 0;
  const ArmVector home = giver_.armOf(start_.q[static_cast<std::size_t>(giver_.robot)]);
  const auto reach = search(giver_, home, draw, open_checker, StageKind::kGiverReach, pick.grasp,
                            Ends::kSeveral, &goal);
  if (!reach || goal >= candidates.size()) return found;
  Candidate& chosen = candidates[goal];
  found = PickMotion{chosen.q_pick, *reach, std::move(chosen.approach), std::move(chosen.lift)};
  return found;
}

const std::optional<ExchangePlanner::PlaceMotion>& ExchangePlanner::placeMotion(
    const FeasibleGrasp& place) {
  const auto [entry, fresh] = places_.try_emplace(place.grasp);
  std::optional<PlaceMotion>& found = entry->second;
  if (!fresh) return found;
  const Grasp& grasp = graspOf(receiver_, place);
  const auto robot = static_cast<std::size_t>(receiver_.robot);
  const Pose& X_WO_goal = problem_.task.X_WO_goal;
  const Pose X_WT = X_WO_goal * grasp.X_OT;

  CellState open = start_;
  open.X_WO = X_WO_goal;
  open.q[robot] = receiver_.withFingers(std::move(open.q[robot]), grasp.open);
  StateChecker open_checker =
      checkers_.make(open, receiver_, receiver_.arm_model->dofs, {.goal_rest = true});
  for (std::size_t i = 0; i < place.configurations.size() && i < budget_.configurations; ++i) {
    const ArmVector& q = place.configurations[i];
    StateChecker held_checker =
        checkers_.make(holding(start_, receiver_, grasp, q), receiver_, receiver_.arm_model->dofs,
                       {.receiver_hand = true, .goal_rest = true});
    if (!held_checker.valid(q)) continue;
    const auto up = lifted(receiver_, q, X_WT, held_checker);
    if (!up) continue;
    open_checker.activate();
    if (!open_checker.valid(q)) continue;
    const auto back = backOff(receiver_, q, X_WT, open_checker);
    if (!back) continue;
    if (fingersHit(receiver_, open, q, grasp.closed, grasp.open, {.receiver_hand = true})) {
      continue;
    }
    const auto home = route(receiver_, back->waypoints.back(), receiver_.armOf(start_.q[robot]),
                            open_checker, StageKind::kReceiverRetreat, place.grasp);
    if (!home) continue;
    found = PlaceMotion{q, reversed(*up), *back, *home};
    return found;
  }
  return found;
}

std::optional<ExchangePlanner::Hands> ExchangePlanner::joinHands(const HandoverTuple& tuple) {
  const Grasp& grasp_g = graspOf(giver_, tuple.give);
  const Grasp& grasp_r = graspOf(receiver_, tuple.receive);
  const auto giver = static_cast<std::size_t>(giver_.robot);
  const auto receiver = static_cast<std::size_t>(receiver_.robot);
  const Pose X_WTg = tuple.X_WH * grasp_g.X_OT;
  const Pose X_WTr = tuple.X_WH * grasp_r.X_OT;
  const AllowedContacts both{.giver_hand = true, .receiver_hand = true};
  // Where these touch each other, they do so whatever the arms do.
  const auto ofHands = [&](BodyId body) {
    const auto in = [&](const std::vector<BodyId>& bodies) {
      return std::find(bodies.begin(), bodies.end(), body) != bodies.end();
    };
    return body == checkers_.objectBody() || in(giver_.hand_bodies) || in(receiver_.hand_bodies);
  };
  const auto most = [&](const FeasibleGrasp& grasp) {
    return std::min(grasp.configurations.size(), budget_.configurations);
  };
  const Pose X_WTg_back = giver_.backedOff(X_WTg, kBackOff.back());
  for (std::size_t i = 0; i < most(tuple.give); ++i) {
    const ArmVector& q_g = tuple.give.configurations[i];
    // Mostly the arm cannot fold so far.
    if (!straightLine(*giver_.kinematics, q_g, giver_.worldToArm(X_WTg),
                      giver_.worldToArm(X_WTg_back))) {
      continue;
    }
    CellState given = holding(start_, giver_, grasp_g, q_g);
    given.X_WO = tuple.X_WH;
    given.holder = nullptr;  // stands still while the receiver comes

    StateChecker arriving =
        checkers_.make(given, receiver_, receiver_.arm_model->dofs, {.giver_hand = true});
    if (!arriving.valid(receiver_.armOf(start_.q[receiver]))) continue;
    for (std::size_t j = 0; j < most(tuple.receive); ++j) {
      const ArmVector& q_r = tuple.receive.configurations[j];
      arriving.activate();
      if (!arriving.valid(q_r)) continue;

      // The receiver has closed its hand; the giver's opens and leaves. Where this fails it costs
      // less to find out than how the receiver comes.
      CellState taken = given;
      taken.q[receiver] =
          receiver_.withFingers(receiver_.withArm(taken.q[receiver], q_r), grasp_r.closed);
      StateChecker closed = checkers_.make(taken, receiver_, receiver_.arm_model->dofs, both);
      if (!closed.valid(q_r)) continue;
      taken.q[giver] = giver_.withFingers(std::move(taken.q[giver]), grasp_g.open);
      StateChecker leaving =
          checkers_.make(taken, giver_, giver_.arm_model->dofs, {.receiver_hand = true});
      if (!leaving.valid(q_g)) continue;
      auto hit = fingersHit(receiver_, given, q_r, receiver_.fingersOf(start_.q[receiver]),
                            grasp_r.closed, both);
      if (!hit) hit = fingersHit(giver_, taken, q_g, grasp_g.closed, grasp_g.open, both);
      if (hit && ofHands(hit->a) && ofHands(hit->b)) return std::nullopt;
      if (hit) continue;
      const auto away = backOff(giver_, q_g, X_WTg, leaving);
      if (!away) continue;
      arriving.activate();
      const auto back = backOff(receiver_, q_r, X_WTr, arriving);
      if (!back) continue;
      return Hands{q_g, q_r, reversed(*back), *away};
    }
  }
  return std::nullopt;
}

std::variant<Exchange, ExchangePlanner::Failure> ExchangePlanner::connect(
    const HandoverTuple& tuple) {
  const Grasp& grasp_g = graspOf(giver_, tuple.give);
  const Grasp& grasp_r = graspOf(receiver_, tuple.receive);
  const auto giver = static_cast<std::size_t>(giver_.robot);
  const auto receiver = static_cast<std::size_t>(receiver_.robot);
  const ArmVector q_g_start = giver_.armOf(start_.q[giver]);
  const ArmVector q_r_start = receiver_.armOf(start_.q[receiver]);

  // What fails most and costs least to find out comes first.
  const auto hands = joinHands(tuple);
  if (!hands) return Failure{kHands};
  const auto& place = placeMotion(tuple.place);
  if (!place) return Failure{toString(StageKind::kReceiverPlace)};

  // The receiver carries it away when the giver is back, whatever comes before. Where no way was
  // found none is sought again: with another grasp the giver's hand, at home, is only opened
  // otherwise.
  const auto stuck = [&](const StuckTransfer& it) {
    return it.place == tuple.place.grasp && it.q_r == hands->q_r;
  };
  if (std::any_of(stuck_.begin(), stuck_.end(), stuck)) {
    return Failure{toString(StageKind::kReceiverTransfer)};
  }
  CellState left = start_;
  left.q[giver] = giver_.withFingers(std::move(left.q[giver]), grasp_g.open);
  left = holding(left, receiver_, grasp_r, hands->q_r);
  StateChecker carrying =
      checkers_.make(left, receiver_, receiver_.arm_model->dofs, {.receiver_hand = true});
  const auto carried = route(receiver_, hands->q_r, place->place.waypoints.front(), carrying,
                             StageKind::kReceiverTransfer, tuple.place.grasp);
  if (!carried) {
    stuck_.push_back({tuple.place.grasp, hands->q_r});
    return Failure{toString(StageKind::kReceiverTransfer)};
  }
  const auto& pick = pickMotion(tuple.pick);
  if (!pick) return Failure{toString(StageKind::kGiverReach)};

  std::vector<StagePath> stages;
  const auto stage = [&](StageKind kind, const Manipulator& mover, const CellState& state,
                         const AllowedContacts& contacts,
                         std::vector<const Manipulator*> holders) -> StagePath& {
    StagePath& added = stages.emplace_back();
    added.kind = kind;
    added.mover = &mover;
    added.state = state;
    added.contacts = contacts;
    added.holders = std::move(holders);
    return added;
  };
  const auto checkerOf = [&](const StagePath& of) {
    return checkers_.make(of.state, *of.mover, of.mover->arm_model->dofs, of.contacts);
  };

  // The giver fetches the object.
  CellState now = start_;
  setArmPath(stage(StageKind::kGiverReach, giver_, now, {}, {}), pick->reach);
  now.q[giver] = giver_.withArm(now.q[giver], pick->approach.waypoints.front());
  setArmPath(stage(StageKind::kGiverApproach, giver_, now, {}, {}), pick->approach);
  now.q[giver] = giver_.withArm(now.q[giver], pick->q_pick);
  setFingerPath(
      stage(StageKind::kGiverGrasp, giver_, now, {.giver_hand = true, .start_rest = true}, {}),
      giver_.fingersOf(now.q[giver]), grasp_g.closed);
  now = holding(now, giver_, grasp_g, pick->q_pick);
  setArmPath(stage(StageKind::kGiverLift, giver_, now, {.giver_hand = true, .start_rest = true},
                   {&giver_}),
             pick->lift);
  now = holding(now, giver_, grasp_g, pick->lift.waypoints.back());
  SeedPaths came_by;  // it may go back by the way that it came
  {
    StagePath& transfer =
        stage(StageKind::kGiverTransfer, giver_, now, {.giver_hand = true}, {&giver_});
    StateChecker checker = checkerOf(transfer);
    const auto path = route(giver_, pick->lift.waypoints.back(), hands->q_g, checker, transfer.kind,
                            tuple.give.grasp);
    if (!path) return Failure{toString(transfer.kind)};
    setArmPath(transfer, *path);
    for (const JointPath* came : {&pick->reach, &*path}) {
      came_by.from_goal.insert(came_by.from_goal.end(), came->waypoints.begin(),
                               came->waypoints.end());
    }
  }

  // The receiver comes and takes it.
  now = holding(now, giver_, grasp_g, hands->q_g);
  now.holder = nullptr;
  now.X_WO = tuple.X_WH;
  {
    StagePath& reach =
        stage(StageKind::kReceiverReach, receiver_, now, {.giver_hand = true}, {&giver_});
    StateChecker checker = checkerOf(reach);
    const auto path =
        route(receiver_, q_r_start, hands->receiver_approach.waypoints.front(), checker, reach.kind,
              tuple.receive.grasp, {reversed(place->home).waypoints, {}});
    if (!path) return Failure{toString(reach.kind)};
    setArmPath(reach, *path);
  }
  now.q[receiver] = receiver_.withArm(now.q[receiver], hands->receiver_approach.waypoints.front());
  setArmPath(stage(StageKind::kReceiverApproach, receiver_, now, {.giver_hand = true}, {&giver_}),
             hands->receiver_approach);
  now.q[receiver] = receiver_.withArm(now.q[receiver], hands->q_r);
  const AllowedContacts both{.giver_hand = true, .receiver_hand = true};
  setFingerPath(stage(StageKind::kReceiverGrasp, receiver_, now, both, {&giver_}),
                receiver_.fingersOf(now.q[receiver]), grasp_r.closed);
  now.q[receiver] = receiver_.withFingers(now.q[receiver], grasp_r.closed);
  setFingerPath(stage(StageKind::kGiverRelease, giver_, now, both, {&giver_, &receiver_}),
                grasp_g.closed, grasp_g.open);
  now.q[giver] = giver_.withFingers(now.q[giver], grasp_g.open);
  {
    StagePath& retreat =
        stage(StageKind::kGiverRetreat, giver_, now, {.receiver_hand = true}, {&receiver_});
    retreat.early_contacts = both;
    StateChecker checker = checkerOf(retreat);
    const auto path = route(giver_, hands->giver_back.waypoints.back(), q_g_start, checker,
                            retreat.kind, tuple.give.grasp, came_by);
    if (!path) return Failure{toString(retreat.kind)};
    setArmPath(retreat, joined(hands->giver_back, *path));
  }

  // And puts it down.
  now.q[giver] = giver_.withArm(now.q[giver], q_g_start);
  now = holding(now, receiver_, grasp_r, hands->q_r);
  setArmPath(
      stage(StageKind::kReceiverTransfer, receiver_, now, {.receiver_hand = true}, {&receiver_}),
      *carried);
  now = holding(now, receiver_, grasp_r, place->place.waypoints.front());
  setArmPath(stage(StageKind::kReceiverPlace, receiver_, now,
                   {.receiver_hand = true, .goal_rest = true}, {&receiver_}),
             place->place);
  now = holding(now, receiver_, grasp_r, place->q_place);
  now.holder = nullptr;
  now.X_WO = problem_.task.X_WO_goal;
  const AllowedContacts releasing{.receiver_hand = true};
  setFingerPath(stage(StageKind::kReceiverRelease, receiver_, now, releasing, {}), grasp_r.closed,
                grasp_r.open);
  now.q[receiver] = receiver_.withFingers(now.q[receiver], grasp_r.open);
  StagePath& retreat = stage(StageKind::kReceiverRetreat, receiver_, now, {}, {});
  retreat.early_contacts = {.receiver_hand = true};
  setArmPath(retreat, joined(place->back, place->home));

  Exchange exchange;
  exchange.stages = std::move(stages);
  exchange.giver_grasp = tuple.give.grasp;
  exchange.receiver_grasp = tuple.receive.grasp;
  exchange.X_WH = tuple.X_WH;
  exchange.dexterity.giver_pick = giver_.kinematics->manipulability(pick->q_pick);
  exchange.dexterity.giver_handover = giver_.kinematics->manipulability(hands->q_g);
  exchange.dexterity.receiver_handover = receiver_.kinematics->manipulability(hands->q_r);
  exchange.dexterity.receiver_place = receiver_.kinematics->manipulability(place->q_place);
  return exchange;
}

}  // namespace handover
