// SPDX-License-Identifier: Apache-2.0
#include "core/planning/transport_problem.hpp"

#include "core/planning/arm_selection.hpp"
#include "core/planning/transport_motions.hpp"
#include "core/planning/stage_timing.hpp"

#include <handover/common/check.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <utility>

namespace handover {
namespace {

constexpr double kNeighbourhood = 0.20;  // [paper] §IV-B: lattice points near the midpoint [m]
constexpr std::size_t kWidePoints = 24;  // lattice points that `wide` adds first, by score
constexpr int kWideTurns = 8;            // rotations about z_shoulder that `wide` adds
constexpr double kWideTilt = 25 * M_PI / 180;  // of the approach axis, which `wide` adds last
constexpr int kWideAzimuths = 3;               // in so many directions
// Handover poses that `wide` asks for at most. Most fall to the cheap test for a straight way
// there; mode all, which counts as the paper does, has no such test.
constexpr std::uint32_t kWidePoses = 8'000;
constexpr std::uint32_t kWidePosesCounted = 1'500;
constexpr std::uint32_t kTiltedPoses = 150'000;  // most fall to a look at each arm's reach
// Of each of the searches that `wide` adds, for arms without a closed form: about a second.
constexpr std::uint32_t kSearchesInVain = 10'000;
constexpr std::size_t kTuplesPerPose = 3;       // tuples of one pose whose motions are tried
constexpr std::uint32_t kConnectAttempts = 60;  // tuples of a request whose motions are tried
constexpr std::uint32_t kHandsAttempts = 600;   // tuples whose hands did not go together

/// Something ended the search before its answer: an outcome by itself.
struct Ended {
  Outcome outcome;
};

NamePair namesOf(const CollisionScene& scene, const BodyContact& contact) {
  return {scene.name(contact.a), scene.name(contact.b)};
}

Failed failed(FailureReason reason, std::string filter, std::string text,
              std::vector<RejectCount> causes) {
  Failed result;
  result.reason = reason;
  result.explanation.filter = std::move(filter);
  result.explanation.text = std::move(text);
  result.explanation.causes = std::move(causes);
  return result;
}

/// The points as a stage carries them, cut at what it may carry.
std::vector<LatticeCell> latticeOf(const std::vector<LatticePoint>& points) {
  std::vector<LatticeCell> cells(std::min(points.size(), bounds::kLattice));
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Eigen::Vector3d& p_W = points[i].p_W;
    cells[i] = {{p_W.x(), p_W.y(), p_W.z()}, points[i].manipulability};
  }
  return cells;
}

/// How far the search goes from the paper's handover poses.
enum class SearchTier { kNone, kTurned, kTilted };

std::vector<ApproachOffset> offsetsOf(SearchTier tier) {
  if (tier == SearchTier::kNone) return {{}};
  std::vector<ApproachOffset> all;
  for (int turn = 0; turn < kWideTurns; ++turn) {
    const double turned = 2 * M_PI * turn / kWideTurns;
    if (tier == SearchTier::kTurned) {
      all.push_back({turned, 0, 0});
      continue;
    }
    for (int azimuth = 0; azimuth < kWideAzimuths; ++azimuth) {
      all.push_back({turned, kWideTilt, 2 * M_PI * azimuth / kWideAzimuths});
    }
  }
  return all;
}

bool noneKept(const std::map<int, PrunedGrasps>& by_arm) {
  return std::all_of(by_arm.begin(), by_arm.end(),
                     [](const auto& entry) { return entry.second.kept.empty(); });
}

/// The search for one request: the paper's candidates first, then what `wide` adds.
class HandoverSearch {
 public:
  HandoverSearch(const TransportProblem& problem, PlanEventSink& sink, const Deadline& deadline)
      : problem_(problem),
        sink_(sink),
        deadline_(deadline),
        world_(problem.collision),
        spare_world_(problem.collision) {}

  Outcome run() {
    try {
      return search();
    } catch (const Ended& ended) {
      return ended.outcome;
    }
  }

 private:
  /// One giver arm with one receiver arm.
  struct Pairing {
    int giver_arm, receiver_arm;
    const Manipulator* giver;
    const Manipulator* receiver;
    std::unique_ptr<ExchangePlanner> exchange;
    std::vector<LatticePoint> points;
    std::vector<const FeasibleGrasp*> place_order;  ///< 𝒢_r, most dexterous placing first
  };

  Outcome search();
  void checkStart();
  void checkGoal();
  void checkDeadline() const;
  const PrunedGrasps& giverGrasps(Pairing& pairing);
  const PrunedGrasps& receiverGrasps(Pairing& pairing);
  void emitPruned(const Manipulator& role, const PrunedGrasps& pruned);
  bool open(Pairing& pairing);

  bool wide() const { return problem_.search == SearchWidth::kWide; }

  static double handsApart(const Pairing& pairing);
  bool tryPoses(Pairing& pairing, SearchTier tier);
  bool tryPose(Pairing& pairing, const FeasibleGrasp& place, const LatticePoint& point,
               const ApproachOffset& offset, HandoverCandidates& counts, CauseTally& rejects);
  bool tryTuples(Pairing& pairing, std::vector<HandoverTuple> tuples, std::size_t most);
  void keepSolution(const Pairing& pairing, const Exchange& exchange,
                    std::vector<StageTrajectory> trajectories);
  void emitFinal();
  Outcome explain() const;

  bool spent() const { return connects_ >= kConnectAttempts || hands_ >= kHandsAttempts; }

  const TransportProblem& problem_;
  PlanEventSink& sink_;
  const Deadline& deadline_;
  CollisionWorld world_, spare_world_;
  std::map<std::pair<int, int>, Manipulator> manipulators_;  ///< by robot and arm
  std::map<int, PrunedGrasps> given_, received_;             ///< by arm
  CauseTally handover_rejects_, motion_rejects_;
  std::optional<std::pair<Solution, std::vector<StageTrajectory>>> final_;
  std::vector<std::vector<HandoverTuple>> poses_;  ///< mode all: tuples by pose, as found
  std::uint32_t tuples_seen_ = 0, connects_ = 0, hands_ = 0, lattice_points_ = 0;
  std::uint32_t poses_asked_ = 0;
  bool cut_ = false;  ///< some handover poses were not looked at, or not to the end
};

void HandoverSearch::checkDeadline() const {
  switch (deadline_.state()) {
    case Deadline::State::kOpen:
      return;
    case Deadline::State::kCancelled:
      throw Ended{Cancelled{}};
    case Deadline::State::kPassed:
      throw Ended{failed(FailureReason::kDeadline, "deadline",
                         "The deadline passed before a plan was found.", motion_rejects_.counts())};
  }
}

/// Nothing that can move may touch anything before the plan begins.
void HandoverSearch::checkStart() {
  const Scene& scene = *problem_.scene;
  const int object = scene.findObject(problem_.task.object);
  std::vector<BodyId> moving{problem_.collision->objectBody(object)};
  for (int robot = 0; robot < static_cast<int>(scene.robots.size()); ++robot) {
    const RobotModel& model = *scene.robots[static_cast<std::size_t>(robot)].model;
    std::vector<int> dofs;
    for (const Arm& arm : model.arms) dofs.insert(dofs.end(), arm.dofs.begin(), arm.dofs.end());
    for (const Hand& hand : model.hands)
      dofs.insert(dofs.end(), hand.dofs.begin(), hand.dofs.end());
    for (const BodyId body : problem_.collision->linkBodies(robot, model.linksMovedBy(dofs))) {
      if (body >= 0) moving.push_back(body);
    }
  }
  BodyPairs allowed(problem_.collision->bodies());
  for (const auto& rest : scene.objects[static_cast<std::size_t>(object)].resting) {
    if (const int under = scene.findObject(rest); under >= 0) {
      allowed.insert(problem_.collision->objectBody(under), moving.front());
    }
  }
  world_.reset();
  world_.setPose(moving.front(), problem_.task.X_WO_start);
  CauseTally hits;
  for (const BodyContact& contact : world_.contacts(world_.makePairs(moving, allowed))) {
    hits.add("collision", namesOf(*problem_.collision, contact));
  }
  if (hits.total() == 0) return;
  const auto causes = hits.counts();
  throw Ended{failed(
      FailureReason::kStartInCollision, "start",
      "At the start " + causes.front().pair.first + " touches " + causes.front().pair.second + ".",
      causes)};
}

/// The object at its goal may touch what it is to rest on and arms that can move away.
void HandoverSearch::checkGoal() {
  const Scene& scene = *problem_.scene;
  const BodyId object = problem_.collision->objectBody(scene.findObject(problem_.task.object));
  BodyPairs allowed(problem_.collision->bodies());
  for (const auto& rest : problem_.task.goal_rest) {
    if (const int under = scene.findObject(rest); under >= 0) {
      allowed.insert(problem_.collision->objectBody(under), object);
    }
  }
  for (int robot = 0; robot < static_cast<int>(scene.robots.size()); ++robot) {
    const RobotModel& model = *scene.robots[static_cast<std::size_t>(robot)].model;
    for (int arm = 0; arm < static_cast<int>(model.arms.size()); ++arm) {
      if (!unfitReason(problem_, robot, arm).empty()) continue;
      for (const BodyId body : problem_.collision->linkBodies(
               robot, model.linksMovedBy(model.arms[static_cast<std::size_t>(arm)].dofs))) {
        if (body >= 0) allowed.insert(body, object);
      }
    }
  }
  world_.reset();
  world_.setPose(object, problem_.task.X_WO_goal);
  CauseTally hits;
  for (const BodyContact& contact : world_.contacts(world_.makePairs({object}, allowed))) {
    hits.add("collision", namesOf(*problem_.collision, contact));
  }
  if (hits.total() == 0) return;
  const auto causes = hits.counts();
  throw Ended{failed(
      FailureReason::kGoalInCollision, "goal",
      "At its goal " + causes.front().pair.first + " touches " + causes.front().pair.second + ".",
      causes)};
}

void HandoverSearch::emitPruned(const Manipulator& role, const PrunedGrasps& pruned) {
  sink_.emit(GraspsPruned{role.robotName(), role.armName(), pruned.tested,
                          static_cast<std::uint32_t>(pruned.kept.size()), pruned.rejects.counts()});
}

const PrunedGrasps& HandoverSearch::giverGrasps(Pairing& pairing) {
  const auto [entry, fresh] = given_.try_emplace(pairing.giver_arm);
  if (fresh) {
    entry->second = pairing.exchange->pruneGiverAtStart(PruneEffort{});
    if (wide() && noneKept(given_)) {
      entry->second = pairing.exchange->pruneGiverAtStart(kThoroughPruning);
    }
    checkDeadline();
    emitPruned(*pairing.giver, entry->second);
  }
  return entry->second;
}

const PrunedGrasps& HandoverSearch::receiverGrasps(Pairing& pairing) {
  const auto [entry, fresh] = received_.try_emplace(pairing.receiver_arm);
  if (fresh) {
    entry->second = pairing.exchange->pruneReceiverAtGoal(PruneEffort{});
    if (wide() && noneKept(received_)) {
      entry->second = pairing.exchange->pruneReceiverAtGoal(kThoroughPruning);
    }
    checkDeadline();
    emitPruned(*pairing.receiver, entry->second);
  }
  return entry->second;
}

/// Prunes both sets and crosses the maps; false when nothing is left of one of the sets.
bool HandoverSearch::open(Pairing& pairing) {
  const PrunedGrasps& given = giverGrasps(pairing);
  if (given.kept.empty()) return false;
  const PrunedGrasps& received = receiverGrasps(pairing);
  if (received.kept.empty()) return false;
  for (const auto& grasp : received.kept) pairing.place_order.push_back(&grasp);
  std::stable_sort(pairing.place_order.begin(), pairing.place_order.end(),
                   [](const FeasibleGrasp* a, const FeasibleGrasp* b) {
                     return a->manipulability > b->manipulability;
                   });
  pairing.points = crossMaps(pairing.giver->map, pairing.receiver->map, kNeighbourhood);
  lattice_points_ += static_cast<std::uint32_t>(pairing.points.size());
  return true;
}

bool HandoverSearch::tryTuples(Pairing& pairing, std::vector<HandoverTuple> tuples,
                               std::size_t most) {
  // The paper's choice: r's manipulability at the placing; then the giver's arm, ties by
  // generation.
  std::stable_sort(tuples.begin(), tuples.end(),
                   [](const HandoverTuple& a, const HandoverTuple& b) {
                     return std::pair(a.place.manipulability, a.give.manipulability) >
                            std::pair(b.place.manipulability, b.give.manipulability);
                   });
  if (tuples.empty()) return false;
  std::size_t searched = 0;
  for (std::size_t i = 0; i < tuples.size() && searched < most && !spent(); ++i) {
    checkDeadline();
    const auto connected = pairing.exchange->connect(tuples[i]);
    checkDeadline();
    if (const auto* failure = std::get_if<ExchangePlanner::Failure>(&connected)) {
      motion_rejects_.add(failure->at);
      // The tuples of a pose share g_r: where it cannot be placed, none of them can.
      if (failure->at == toString(StageKind::kReceiverPlace)) return false;
      // Hands that do not go together are found out cheaply; only searches for motions are counted.
      if (failure->at == ExchangePlanner::kHands) {
        ++hands_;
      } else {
        ++connects_;
        ++searched;
      }
      continue;
    }
    ++connects_;
    ++searched;
    const Exchange& exchange = std::get<Exchange>(connected);
    auto timed = timeStages(problem_, pairing.exchange->checkers(), exchange, 0);
    if (const auto* failure = std::get_if<TimingFailure>(&timed)) {
      motion_rejects_.add("timing " + failure->stage, {failure->detail, {}});
      continue;
    }
    keepSolution(pairing, exchange, std::get<std::vector<StageTrajectory>>(std::move(timed)));
    return true;
  }
  return false;
}

bool HandoverSearch::tryPose(Pairing& pairing, const FeasibleGrasp& place,
                             const LatticePoint& point, const ApproachOffset& offset,
                             HandoverCandidates& counts, CauseTally& rejects) {
  const Manipulator& receiver = *pairing.receiver;
  const Grasp& grasp = receiver.grasps->grasps[static_cast<std::size_t>(place.grasp)];
  const Pose X_WT_goal = problem_.task.X_WO_goal * grasp.X_OT;
  Pose X_WT = Pose::Identity();
  X_WT.linear() =
      handoverRotation(X_WT_goal.linear(), receiver.arm_model->approach_axis,
                       pairing.giver->map.p_WShoulder, receiver.map.p_WShoulder, offset);
  X_WT.translation() = point.p_W;
  const Pose X_WH = X_WT * grasp.X_OT.inverse();
  ++counts.poses_tried;

  // One look, and the giver takes one for each of its grasps.
  if (!pairing.exchange->receiverReaches(X_WH, place)) {
    rejects.add("no_ik");
    return false;
  }
  if (!pairing.exchange->giverReaches(X_WH, given_.at(pairing.giver_arm))) {
    rejects.add("no_ik");
    return false;
  }
  PrunedGrasps receive = pairing.exchange->pruneReceiverAt(X_WH, place);
  rejects.add(receive.rejects);
  if (receive.kept.empty()) return false;
  FeasibleGrasp& received = receive.kept.front();
  // The paper counts this pose whether or not there is a straight way to it.
  if (problem_.mode != SearchMode::kAll && !pairing.exchange->keepReachable(X_WH, received)) {
    rejects.add(toString(StageKind::kReceiverApproach));
    cut_ = true;
    return false;
  }
  const PrunedGrasps give =
      pairing.exchange->pruneGiverAt(X_WH, received, given_.at(pairing.giver_arm));
  rejects.add(give.rejects);
  if (give.kept.empty()) return false;
  ++counts.poses;
  counts.tuples += static_cast<std::uint32_t>(give.kept.size());
  tuples_seen_ += static_cast<std::uint32_t>(give.kept.size());

  std::vector<HandoverTuple> tuples;
  for (const FeasibleGrasp& given : give.kept) {
    tuples.push_back(
        {X_WH, place, received, *given_.at(pairing.giver_arm).find(given.grasp), given});
  }
  if (problem_.mode == SearchMode::kAll) {  // counted first, connected afterwards in the same order
    poses_.push_back(std::move(tuples));
    return false;
  }
  return tryTuples(pairing, std::move(tuples), kTuplesPerPose);
}

/// How far apart [m] the tools of two hands at the object can be, at most.
double HandoverSearch::handsApart(const Pairing& pairing) {
  double apart = 0;
  for (const Manipulator* role : {pairing.giver, pairing.receiver}) {
    double most = 0;
    for (const Grasp& grasp : role->grasps->grasps) {
      most = std::max(most, grasp.X_OT.translation().norm());
    }
    apart += most;
  }
  return apart;
}

/// Goes through handover poses, best placing first; true when a plan was emitted.
bool HandoverSearch::tryPoses(Pairing& pairing, SearchTier tier) {
  const bool widened = tier != SearchTier::kNone;
  HandoverCandidates counts;
  CauseTally rejects;
  counts.giver_arm = pairing.giver->armName();
  counts.receiver_arm = pairing.receiver->armName();
  counts.voxels = static_cast<std::uint32_t>(pairing.points.size());
  poses_.clear();

  std::vector<LatticePoint> points = pairing.points;
  if (widened) {
    const double reach_g = pairing.giver->kinematics->reach() + handsApart(pairing);
    const auto more =
        receiverPoints(pairing.giver->map, pairing.receiver->map, kNeighbourhood, reach_g);
    points.insert(points.end(), more.begin(), more.end());
  } else if (!points.empty()) {
    points.resize(1);
  }
  if (points.empty()) return false;
  const std::size_t best_points = std::min(points.size(), kWidePoints);
  bool solved = false;
  const std::uint32_t in_vain = pairing.exchange->searchesInVain();
  const auto tryPoints = [&](std::size_t first, std::size_t end, std::uint32_t most_poses) {
    // Another place more often helps than another turn at the same one: an arm that cannot fold so
    // far there cannot in any turn.
    for (const ApproachOffset& offset : offsetsOf(tier)) {
      for (std::size_t point = first; point < end && !solved; ++point) {
        // The paper's, tried already.
        if (widened && point == 0 && offset.turn == 0 && offset.tilt == 0 &&
            !pairing.points.empty()) {
          continue;
        }
        for (const FeasibleGrasp* place : pairing.place_order) {
          checkDeadline();
          const bool enough =
              counts.poses_tried >= most_poses ||
              (widened && pairing.exchange->searchesInVain() - in_vain >= kSearchesInVain);
          cut_ = cut_ || enough;
          if (enough || spent()) break;
          solved = tryPose(pairing, *place, points[point], offset, counts, rejects);
          if (solved) break;
        }
      }
      if (solved) break;
    }
  };
  if (tier == SearchTier::kTilted) {
    tryPoints(0, points.size(), kTiltedPoses);
  } else {
    tryPoints(0, best_points, problem_.mode == SearchMode::kAll ? kWidePosesCounted : kWidePoses);
    tryPoints(best_points, points.size(), kWidePosesCounted);
  }
  poses_asked_ += counts.poses_tried;
  counts.rejects = rejects.counts();
  handover_rejects_.add(rejects);
  if (!widened) counts.lattice = latticeOf(pairing.points);
  sink_.emit(std::move(counts));
  for (std::size_t i = 0; i < poses_.size() && !solved; ++i) {
    solved = tryTuples(pairing, std::move(poses_[i]), kTuplesPerPose);
  }
  if (solved) emitFinal();
  return solved;
}

Outcome HandoverSearch::search() {
  sink_.emit(snapshot(*problem_.scene, problem_.task, problem_.seed));
  checkDeadline();
  checkStart();
  checkGoal();

  const int giver = problem_.scene->findRobot(problem_.task.giver);
  const int receiver = problem_.scene->findRobot(problem_.task.receiver);
  ArmRanking givers =
      rankArms(problem_, giver, problem_.task.X_WO_start, problem_.giver_arm, problem_.search);
  ArmRanking receivers =
      rankArms(problem_, receiver, problem_.task.X_WO_goal, problem_.receiver_arm, problem_.search);
  if (problem_.search == SearchWidth::kPaper && givers.arms.size() > 1) givers.arms.resize(1);

  ArmSelected selected;
  const auto nameOf = [&](int robot, const ArmRanking& ranking) -> std::string {
    if (ranking.arms.empty()) return {};
    const auto& model = *problem_.scene->robots[static_cast<std::size_t>(robot)].model;
    return model.arms[static_cast<std::size_t>(ranking.arms.front().arm)].name;
  };
  selected.giver_arm = nameOf(giver, givers);
  selected.receiver_arm = nameOf(receiver, receivers);
  selected.scores = givers.scores;
  selected.scores.insert(selected.scores.end(), receivers.scores.begin(), receivers.scores.end());
  sink_.emit(selected);
  const auto armCauses = [](const ArmRanking& ranking) {
    CauseTally tally;
    for (const auto& score : ranking.scores)
      tally.add(score.rejected, {score.robot + "/" + score.arm, {}});
    return tally.counts(8);
  };
  if (givers.arms.empty()) {
    return failed(FailureReason::kStartUnreachable, "giver_arms",
                  "No arm of " + problem_.task.giver + " can reach " + problem_.task.object +
                      " at its start.",
                  armCauses(givers));
  }
  if (receivers.arms.empty()) {
    return failed(FailureReason::kGoalUnreachable, "receiver_arms",
                  "No arm of " + problem_.task.receiver + " can reach " + problem_.task.object +
                      " at its goal.",
                  armCauses(receivers));
  }

  for (const auto& [robot, ranking] :
       {std::pair(giver, &givers), std::pair(receiver, &receivers)}) {
    for (const auto& ranked : ranking->arms)
      manipulators_.emplace(std::pair(robot, ranked.arm),
                            makeManipulator(problem_, robot, ranked.arm));
  }
  std::vector<Pairing> pairings;
  for (const auto& g : givers.arms) {
    for (const auto& r : receivers.arms) {
      Pairing& pairing = pairings.emplace_back();
      pairing.giver_arm = g.arm;
      pairing.receiver_arm = r.arm;
      pairing.giver = &manipulators_.at({giver, g.arm});
      pairing.receiver = &manipulators_.at({receiver, r.arm});
      pairing.exchange =
          std::make_unique<ExchangePlanner>(problem_, *pairing.giver, *pairing.receiver, world_,
                                            spare_world_, ExchangeBudget{}, deadline_);
    }
  }
  std::vector<bool> usable(pairings.size());
  for (std::size_t i = 0; i < pairings.size(); ++i) {
    usable[i] = open(pairings[i]);
    if (usable[i] && tryPoses(pairings[i], SearchTier::kNone)) return Done{0, true};
  }
  if (wide()) {
    for (const SearchTier tier : {SearchTier::kTurned, SearchTier::kTilted}) {
      for (std::size_t i = 0; i < pairings.size(); ++i) {
        if (usable[i] && tryPoses(pairings[i], tier)) return Done{0, true};
      }
    }
  }
  return explain();
}

/// No plan: names the first filter that emptied.
Outcome HandoverSearch::explain() const {
  const auto emptied = [](const std::map<int, PrunedGrasps>& sets, CauseTally& tally) {
    for (const auto& [arm, pruned] : sets) tally.add(pruned.rejects);
    return noneKept(sets);
  };
  const auto tested = [this](const std::string& robot, const std::map<int, PrunedGrasps>& sets) {
    const int index = problem_.scene->findRobot(robot);
    std::string text;
    for (const auto& [arm, pruned] : sets) {
      text += text.empty() ? " Tested: " : ", ";
      text += std::to_string(pruned.tested) + " of arm " + manipulators_.at({index, arm}).armName();
    }
    return text + ".";
  };
  CauseTally tally;
  if (emptied(given_, tally)) {
    return failed(FailureReason::kNoGraspAtStart, "giver_grasps",
                  problem_.task.giver + " has no free grasp of " + problem_.task.object +
                      " at its start." + tested(problem_.task.giver, given_),
                  tally.counts());
  }
  tally = {};
  if (emptied(received_, tally)) {
    return failed(FailureReason::kNoGraspAtGoal, "receiver_grasps",
                  problem_.task.receiver + " has no free grasp of " + problem_.task.object +
                      " at its goal." + tested(problem_.task.receiver, received_),
                  tally.counts());
  }
  if (lattice_points_ == 0 && tuples_seen_ == 0) {
    return failed(FailureReason::kNoCommonWorkspace, "common_workspace",
                  "No point near the middle of the shoulders is in reach of both robots.", {});
  }
  if (tuples_seen_ == 0) {
    const std::string which =
        wide() && !cut_ ? "No handover pose"
                        : "None of the " + std::to_string(poses_asked_) + " handover poses tried";
    return failed(FailureReason::kNoHandoverPose, "handover_poses",
                  which + " lets both hands hold " + problem_.task.object + ".",
                  handover_rejects_.counts());
  }
  const std::vector<RejectCount> stages = motion_rejects_.counts();
  std::string text = "Grasps and handover poses exist, but no motion between them was found";
  if (!stages.empty()) {
    text += "; most tries, " + std::to_string(stages.front().count) + " of " +
            std::to_string(motion_rejects_.total()) + ", ended at " + stages.front().cause;
  }
  return failed(FailureReason::kNoPath, "motions", text + ".", stages);
}

void HandoverSearch::keepSolution(const Pairing& pairing, const Exchange& exchange,
                                  std::vector<StageTrajectory> trajectories) {
  Solution solution;
  solution.giver_arm = pairing.giver->armName();
  solution.receiver_arm = pairing.receiver->armName();
  solution.giver_tool_link = pairing.giver->toolLink();
  solution.receiver_tool_link = pairing.receiver->toolLink();
  solution.giver_grasp = static_cast<std::uint32_t>(exchange.giver_grasp);
  solution.receiver_grasp = static_cast<std::uint32_t>(exchange.receiver_grasp);
  solution.X_WO_handover = toValue(exchange.X_WH);
  const auto graspPose = [](const Manipulator& role, int grasp) {
    return toValue(role.grasps->grasps[static_cast<std::size_t>(grasp)].X_OT);
  };
  solution.X_OT_giver = graspPose(*pairing.giver, exchange.giver_grasp);
  solution.X_OT_receiver = graspPose(*pairing.receiver, exchange.receiver_grasp);
  solution.dexterity = exchange.dexterity;
  final_ = std::pair(std::move(solution), std::move(trajectories));
}

/// After the counts of its search, so that a reader sees the funnel before the plan.
void HandoverSearch::emitFinal() {
  sink_.emit(final_->first);
  for (auto& trajectory : final_->second) sink_.emit(std::move(trajectory));
}

}  // namespace

Outcome planHandover(const TransportProblem& problem, PlanEventSink& sink, const Deadline& deadline) {
  return HandoverSearch(problem, sink, deadline).run();
}

bool mapsAllow(const TransportProblem& problem) {
  const int giver = problem.scene->findRobot(problem.task.giver);
  const int receiver = problem.scene->findRobot(problem.task.receiver);
  const auto rolesOf = [&](int robot, const Pose& X_WO, const std::string& only) {
    std::vector<Manipulator> roles;
    for (const auto& ranked : rankArms(problem, robot, X_WO, only, problem.search).arms) {
      roles.push_back(makeManipulator(problem, robot, ranked.arm));
    }
    return roles;
  };
  const auto givers = rolesOf(giver, problem.task.X_WO_start, problem.giver_arm);
  for (const Manipulator& r : rolesOf(receiver, problem.task.X_WO_goal, problem.receiver_arm)) {
    for (const Manipulator& g : givers) {
      if (!crossMaps(g.map, r.map, kNeighbourhood).empty()) return true;
    }
  }
  return false;
}

std::vector<ReachBall> reachBalls(const TransportProblem& problem, int robot,
                                  const std::string& only) {
  const RobotModel& model = *problem.scene->robots[static_cast<std::size_t>(robot)].model;
  std::vector<ReachBall> balls;
  for (int arm = 0; arm < static_cast<int>(model.arms.size()); ++arm) {
    if (!only.empty() && model.arms[static_cast<std::size_t>(arm)].name != only) continue;
    if (!unfitReason(problem, robot, arm).empty()) continue;
    const PlacedMap map = makeManipulator(problem, robot, arm).map;
    balls.push_back({map.p_WShoulder, map.map->reach(map.X_WA.inverse() * map.p_WShoulder)});
  }
  return balls;
}

}  // namespace handover
