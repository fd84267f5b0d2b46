// SPDX-License-Identifier: Apache-2.0
#include "dense_search.hpp"

#include "core/planning/arm_selection.hpp"
#include "core/planning/scene_validity.hpp"
#include "core/planning/stage_timing.hpp"
#include "core/planning/transport_motions.hpp"
#include "random_order.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>

namespace handover::dense {
namespace {

constexpr double kEdge = 0.025;  // of the lattice [m]
constexpr int kTurns = 24;       // about z_shoulder
constexpr double kTilts[] = {25 * M_PI / 180, 50 * M_PI / 180};
constexpr int kAzimuths = 6;  // in which the approach axis is tilted
constexpr int kRolls = 6;     // about each of the twelve directions of the even rotations
// Tuples whose hands go together but whose motions were not found are tried again at the end, so
// many of them with so many times the planner's budget.
constexpr std::size_t kTriedAgain = 600;
constexpr std::uint32_t kMoreIterations = 100;

/// One giver arm with one receiver arm, and its part of the grid: points x rotations x places.
struct Pairing {
  Manipulator giver, receiver;
  std::unique_ptr<TransportMotions> motions, thorough;
  PrunedGrasps picks, places;
  std::vector<Eigen::Vector3d> points;       ///< of the receiver's tool, in the world
  std::vector<Eigen::Matrix3d> from_paper;   ///< turns and tilts, applied to the paper's rotation
  std::vector<Eigen::Matrix3d> even;         ///< rotations of the receiver's tool in the world
  std::vector<Eigen::Matrix3d> R_WTr_paper;  ///< by place
  Eigen::Vector3d z_shoulder;

  std::uint64_t rotations() const { return from_paper.size() + even.size(); }

  std::uint64_t size() const { return points.size() * rotations() * places.kept.size(); }
};

/// How far apart [m] the tools of two hands at the object are, at most.
double handsApart(const Pairing& pairing) {
  double most = 0;
  for (const FeasibleGrasp& pick : pairing.picks.kept) {
    const Grasp& given = pairing.giver.grasp(pick.grasp);
    for (const FeasibleGrasp& place : pairing.places.kept) {
      const Grasp& taken = pairing.receiver.grasp(place.grasp);
      most = std::max(most, (given.X_OT.translation() - taken.X_OT.translation()).norm());
    }
  }
  return most;
}

/// How far from its shoulder an arm can put its tool, at most: maps are sampled, so a voxel more.
double reachOf(const PlacedMap& map) {
  return map.map->reach(map.X_WA.inverse() * map.p_WShoulder) + map.map->voxelSize();
}

/// Where the receiver's tool can be while the giver's is at the same object.
std::vector<Eigen::Vector3d> overlapOfReach(const Pairing& pairing) {
  const Eigen::Vector3d& centre = pairing.receiver.map.p_WShoulder;
  const double reach_r = reachOf(pairing.receiver.map);
  const double reach_g = reachOf(pairing.giver.map) + handsApart(pairing);
  std::vector<Eigen::Vector3d> points;
  const int steps = static_cast<int>(std::ceil(reach_r / kEdge));
  for (int i = -steps; i <= steps; ++i) {
    for (int j = -steps; j <= steps; ++j) {
      for (int k = -steps; k <= steps; ++k) {
        const Eigen::Vector3d p_W = centre + kEdge * Eigen::Vector3d(i, j, k);
        if ((p_W - centre).norm() <= reach_r &&
            (p_W - pairing.giver.map.p_WShoulder).norm() <= reach_g) {
          points.push_back(p_W);
        }
      }
    }
  }
  return points;
}

/// The twelve corners of an icosahedron.
std::vector<Eigen::Vector3d> evenDirections() {
  std::vector<Eigen::Vector3d> directions;
  const double golden = 0.5 * (1 + std::sqrt(5.0));
  for (const double a : {1.0, -1.0}) {
    for (const double b : {golden, -golden}) {
      for (const auto& corner :
           {Eigen::Vector3d(0, a, b), Eigen::Vector3d(a, b, 0), Eigen::Vector3d(b, 0, a)}) {
        directions.push_back(corner.normalized());
      }
    }
  }
  return directions;
}

Eigen::Matrix3d rotation(double angle, const Eigen::Vector3d& axis) {
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

void setGrid(const TransportProblem& problem, Pairing& pairing) {
  const Manipulator& receiver = pairing.receiver;
  const Eigen::Vector3d& approach_T = receiver.arm_model->approach_axis;
  const Eigen::Vector3d z = (pairing.giver.map.p_WShoulder - receiver.map.p_WShoulder).normalized();
  pairing.z_shoulder = z;
  pairing.points = overlapOfReach(pairing);
  const Eigen::Vector3d across = z.unitOrthogonal();
  for (int turn = 0; turn < kTurns; ++turn) {
    const Eigen::Matrix3d R_turn = rotation(2 * M_PI * turn / kTurns, z);
    pairing.from_paper.push_back(R_turn);
    for (const double tilt : kTilts) {
      for (int azimuth = 0; azimuth < kAzimuths; ++azimuth) {
        const Eigen::Vector3d axis = rotation(2 * M_PI * azimuth / kAzimuths, z) * across;
        pairing.from_paper.push_back(rotation(tilt, axis) * R_turn);
      }
    }
  }
  for (const Eigen::Vector3d& direction : evenDirections()) {
    const auto R_WT = Eigen::Quaterniond::FromTwoVectors(approach_T, direction);
    for (int roll = 0; roll < kRolls; ++roll) {
      pairing.even.push_back(rotation(2 * M_PI * roll / kRolls, direction) * R_WT);
    }
  }
  for (const FeasibleGrasp& place : pairing.places.kept) {
    const Pose X_WT_goal = problem.task.X_WO_goal * receiver.grasp(place.grasp).X_OT;
    pairing.R_WTr_paper.push_back(handoverRotation(
        X_WT_goal.linear(), approach_T, pairing.giver.map.p_WShoulder, receiver.map.p_WShoulder));
  }
}

/// Whether the giver's arm reaches any of its grasps; asked of the arm alone, as maps have holes.
bool giverReaches(const Pairing& pairing, const Pose& X_WH) {
  return std::any_of(pairing.picks.kept.begin(), pairing.picks.kept.end(),
                     [&](const FeasibleGrasp& pick) {
                       return pairing.giver.reaches(X_WH * pairing.giver.grasp(pick.grasp).X_OT);
                     });
}

TransportProblem withMoreIterations(TransportProblem problem) {
  problem.settings.free_motion.rrt_iterations *= kMoreIterations;
  return problem;
}

void requireTwoHolders(const SceneTask& task) {
  if (task.chain.size() == 2) return;
  const std::string has =
      task.chain.empty() ? "leaves the chain open" : "has " + std::to_string(task.chain.size());
  throw std::runtime_error("a dense search needs a chain of two holders; the task " + has);
}

class DenseSearch {
 public:
  explicit DenseSearch(const TransportProblem& problem)
      : problem_(problem), world_(problem.collision), spare_world_(problem.collision) {
    requireTwoHolders(problem_.task);
    answer_.invalid = checkScene(problem_, world_, problem_.task);
    if (answer_.invalid) return;
    more_ = withMoreIterations(problem_);
    const SceneTask& task = problem_.task;
    for (const ChainHolder& g : fitArms(problem_, task.held_by.value_or(task.chain.front()))) {
      for (const ChainHolder& r : fitArms(problem_, task.chain.back())) {
        if (!(g == r)) addPairing(g, r);
      }
    }
  }

  DenseAnswer run(std::uint64_t most_poses) {
    if (answer_.grid == 0) return answer_;
    const RandomOrder order(answer_.grid, problem_.seed);
    const std::uint64_t poses = std::min(most_poses, answer_.grid);
    while (answer_.poses < poses && !answer_.plan) tryPose(order(answer_.poses++));
    for (std::size_t i = 0; i < again_.size() && !answer_.plan; ++i) {
      const auto& [pairing, tuple] = again_[i];
      if (connects(*pairing, *pairing->thorough, tuple, answer_.tuples_again) == Connected::kYes) {
        answer_.plan->thorough = true;
      }
    }
    return answer_;
  }

 private:
  void addPairing(const ChainHolder& g, const ChainHolder& r) {
    auto pairing = std::make_unique<Pairing>();
    pairing->giver = makeManipulator(problem_, g.robot, g.arm);
    pairing->receiver = makeManipulator(problem_, r.robot, r.arm);
    const auto motionsFor = [&](const TransportProblem& problem) {
      const std::vector<const Manipulator*> holders{&pairing->giver, &pairing->receiver};
      return std::make_unique<TransportMotions>(problem, holders, world_, spare_world_, never_);
    };
    pairing->motions = motionsFor(problem_);
    pairing->thorough = motionsFor(more_);
    const PruneEffort& effort = problem_.settings.thorough_pruning;
    pairing->picks = pairing->motions->pruneFirstAtStart(effort);
    pairing->places = pairing->motions->pruneLastAtGoal(effort);
    answer_.giver_grasps |= !pairing->picks.kept.empty();
    answer_.receiver_grasps |= !pairing->places.kept.empty();
    if (pairing->picks.kept.empty() || pairing->places.kept.empty()) return;
    setGrid(problem_, *pairing);
    answer_.grid += pairing->size();
    pairings_.push_back(std::move(pairing));
  }

  void tryPose(std::uint64_t number) {
    std::size_t p = 0;
    while (number >= pairings_[p]->size()) number -= pairings_[p++]->size();
    Pairing& pairing = *pairings_[p];
    const auto place_index = static_cast<std::size_t>(number % pairing.places.kept.size());
    number /= pairing.places.kept.size();
    const auto rotation_index = static_cast<std::size_t>(number % pairing.rotations());
    const auto point_index = static_cast<std::size_t>(number / pairing.rotations());

    const FeasibleGrasp& place = pairing.places.kept[place_index];
    const Grasp& grasp = pairing.receiver.grasp(place.grasp);
    Pose X_WTr = Pose::Identity();
    X_WTr.translation() = pairing.points[point_index];
    X_WTr.linear() =
        rotation_index < pairing.from_paper.size()
            ? Eigen::Matrix3d(pairing.from_paper[rotation_index] * pairing.R_WTr_paper[place_index])
            : pairing.even[rotation_index - pairing.from_paper.size()];
    const Pose X_WH = X_WTr * grasp.X_OT.inverse();

    // Cheap tests before dear ones.
    if (!pairing.receiver.reaches(X_WTr)) {
      ++answer_.counts.receiver_reaches_not;
      return;
    }
    if (!giverReaches(pairing, X_WH)) {
      ++answer_.counts.giver_reaches_not;
      return;
    }
    PrunedGrasps receive = pairing.motions->pruneReceiverAt(0, X_WH, place);
    if (receive.kept.empty()) {
      ++answer_.counts.receiver_touches;
      return;
    }
    FeasibleGrasp& received = receive.kept.front();
    if (!pairing.motions->keepApproachable(0, X_WH, received)) {
      ++answer_.counts.receiver_comes_not;
      return;
    }
    const PrunedGrasps give = pairing.motions->pruneGiverAt(0, X_WH, received, pairing.picks);
    if (give.kept.empty()) {
      ++answer_.counts.giver_touches;
      return;
    }
    ++answer_.counts.held_by_both;
    for (const FeasibleGrasp& given : give.kept) {
      const TransportTuple tuple{{X_WH},
                                 {{*pairing.picks.find(given.grasp), given}, {received, place}}};
      const Connected connected = connects(pairing, *pairing.motions, tuple, answer_.tuples);
      if (connected == Connected::kYes) return;
      if (connected == Connected::kNoMotion && again_.size() < kTriedAgain) {
        again_.emplace_back(&pairing, tuple);
      }
    }
  }

  enum class Connected { kYes, kNoHands, kNoMotion };

  Connected connects(const Pairing& pairing, TransportMotions& motions, const TransportTuple& tuple,
                     CauseTally& rejects) {
    const auto connected = motions.connect(tuple);
    if (const auto* failure = std::get_if<MotionFailure>(&connected)) {
      rejects.add(failure->cause, failure->stage, failure->pair);
      return failure->cause == Cause::kHandsMeet ? Connected::kNoHands : Connected::kNoMotion;
    }
    const auto timed =
        timeStages(problem_, motions.context(), std::get<TransportPath>(connected), Deadline());
    if (const auto* failure = std::get_if<MotionFailure>(&timed)) {
      rejects.add(failure->cause, failure->stage, failure->pair);
      return Connected::kNoMotion;
    }
    answer_.plan = foundPlan(pairing, tuple);
    return Connected::kYes;
  }

  static FoundPlan foundPlan(const Pairing& pairing, const TransportTuple& tuple) {
    const HolderGrasp& received = tuple.holders.back();
    FoundPlan plan;
    plan.giver = pairing.giver.name();
    plan.receiver = pairing.receiver.name();
    plan.giver_grasp = tuple.holders.front().give.grasp;
    plan.receiver_grasp = received.take.grasp;
    const Pose X_WTr = tuple.X_WH.front() * pairing.receiver.grasp(plan.receiver_grasp).X_OT;
    plan.p_WTr = X_WTr.translation();
    const PlacedMap &map_g = pairing.giver.map, &map_r = pairing.receiver.map;
    plan.from_midpoint = (plan.p_WTr - 0.5 * (map_g.p_WShoulder + map_r.p_WShoulder)).norm();
    plan.both_maps = map_g(plan.p_WTr) > 0 && map_r(plan.p_WTr) > 0;
    plan.near_map = map_r.near(plan.p_WTr);
    const Eigen::Vector3d approach_W = X_WTr.linear() * pairing.receiver.arm_model->approach_axis;
    const Eigen::Vector3d& z = pairing.z_shoulder;
    plan.tilt = std::atan2(approach_W.cross(z).norm(), approach_W.dot(z));
    // What is left when the tilt is undone is a turn about z_shoulder.
    const Eigen::Matrix3d R_upright =
        Eigen::Quaterniond::FromTwoVectors(approach_W, z) * X_WTr.linear();
    const auto place = static_cast<std::size_t>(pairing.places.find(received.give.grasp) -
                                                pairing.places.kept.data());
    const Eigen::AngleAxisd turn(R_upright * pairing.R_WTr_paper[place].transpose());
    plan.turn = turn.angle() * (turn.axis().dot(z) < 0 ? -1 : 1);
    return plan;
  }

  TransportProblem problem_;  ///< its task's rests are found here
  TransportProblem more_;     ///< the same with the larger budget
  const Deadline never_;
  CollisionWorld world_, spare_world_;
  std::vector<std::unique_ptr<Pairing>> pairings_;
  std::vector<std::pair<Pairing*, TransportTuple>> again_;
  DenseAnswer answer_;
};

}  // namespace

DenseAnswer searchDensely(const TransportProblem& problem, std::uint64_t most_poses) {
  return DenseSearch(problem).run(most_poses);
}

}  // namespace handover::dense
