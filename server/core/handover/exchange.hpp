// SPDX-License-Identifier: Apache-2.0
// The motions of one handover: from a tuple of grasps and a handover pose to fourteen stage paths
// ([paper] §IV-E: IKBiRRT for reach, pick, handover and place).
#pragma once

#include "core/handover/collision_context.hpp"
#include "core/handover/prune_grasps.hpp"
#include "core/motion/ikbirrt.hpp"

#include <map>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace handover {

/// A stage before timing: a polyline over some joints of one robot, and the world it happens in.
struct StagePath {
  StageKind kind = StageKind::kUnspecified;
  const Manipulator* mover = nullptr;
  std::vector<int> dofs;  ///< of the mover's robot, as the waypoints list them
  std::vector<Eigen::VectorXd> waypoints;
  CellState state;                          ///< everything as the stage begins
  AllowedContacts contacts;                 ///< beyond the standing pairs, during the whole stage
  AllowedContacts early_contacts;           ///< in the first 5 mm of motion only
  std::vector<const Manipulator*> holders;  ///< who holds the object
};

/// A complete handover before timing.
struct Exchange {
  std::vector<StagePath> stages;  ///< all fourteen, in order
  int giver_grasp = -1, receiver_grasp = -1;
  Pose X_WH = Pose::Identity();
  Dexterity dexterity;  ///< at the configurations that the stages reach
};

/// [paper] Alg. 2: one of the set ℋ.
struct HandoverTuple {
  Pose X_WH = Pose::Identity();
  FeasibleGrasp place;    ///< g_r at the goal
  FeasibleGrasp receive;  ///< g_r at the handover
  FeasibleGrasp pick;     ///< g_g at the start
  FeasibleGrasp give;     ///< g_g at the handover, the receiver's hand in place
};

/// How hard the search tries; counts, never seconds.
struct ExchangeBudget {
  std::uint32_t rrt_iterations = 1000;
  std::uint32_t shortcut_attempts = 16;
  std::size_t configurations = 4;  ///< of a grasp, tried as ends of motions
};

/// Plans the motions of tuples between one giver arm and one receiver arm, keeping what tuples
/// share: the pick depends on g_g alone, the placing on g_r alone. Not thread-safe.
class ExchangePlanner {
 public:
  /// @param spare_world  a second world over the same scene: tests that take turns keep theirs set.
  ExchangePlanner(const HandoverProblem& problem, const Manipulator& giver,
                  const Manipulator& receiver, CollisionWorld& world, CollisionWorld& spare_world,
                  const ExchangeBudget& budget, const Deadline& deadline);

  /// Alg. 1 with O at the start, by the giver ([paper] §IV-C), and at the goal, by the receiver.
  PrunedGrasps pruneGiverAtStart(const PruneEffort& effort);
  PrunedGrasps pruneReceiverAtGoal(const PruneEffort& effort);
  /// Alg. 3's last step: the receiver's grasp with O at X_WH, the giver's arm at its start.
  PrunedGrasps pruneReceiverAt(const Pose& X_WH, const FeasibleGrasp& place);
  /// Whether the giver's arm has any configuration at all with O at X_WH, by a grasp it can pick
  /// with: asked first, as most poses fail here and it costs the least.
  bool giverReaches(const Pose& X_WH, const PrunedGrasps& picks);
  /// Whether the receiver's arm has any with its grasp there.
  bool receiverReaches(const Pose& X_WH, const FeasibleGrasp& place);

  /// How often these two have searched for a configuration by least squares and found none, which
  /// takes a hundred times as long as the closed form.
  std::uint32_t searchesInVain() const { return searches_in_vain_; }

  /// Alg. 2: the giver's grasps (of those it can pick with) with O at X_WH and the receiver's hand
  /// in place.
  PrunedGrasps pruneGiverAt(const Pose& X_WH, const FeasibleGrasp& receive,
                            const PrunedGrasps& picks);

  /// Leaves out the receiver's first configurations at the handover up to one that can be come to
  /// straight with the giver out of the way; false, nothing changed, if there is none.
  bool keepReachable(const Pose& X_WH, FeasibleGrasp& receive);

  /// All motions of a tuple, or the stage at which none was found.
  struct Failure {
    std::string at;  ///< a stage's name or kHands
  };

  static constexpr const char* kHands = "hands";  ///< both hands at the object, coming and leaving

  std::variant<Exchange, Failure> connect(const HandoverTuple& tuple);

  const CollisionContext& checkers() const { return checkers_; }

 private:
  struct PickMotion {
    ArmVector q_pick;
    JointPath reach, approach, lift;
  };

  struct PlaceMotion {
    ArmVector q_place;
    JointPath place, back, home;  ///< from above down to q_place; straight back; from there home
  };

  struct Hands {
    ArmVector q_g, q_r;
    JointPath receiver_approach, giver_back;  ///< straight on to q_r; straight back from q_g
  };

  /// Where an arm has found its way before, much else as now.
  struct SeedPaths {
    std::vector<ArmVector> from_start, from_goal;  ///< in the order that they lead away from there
  };

  /// A way to the placing of a grasp that was not found.
  struct StuckTransfer {
    int place;
    ArmVector q_r;  ///< where it began
  };

  bool reaches(const Manipulator& role, const Pose& X_WT);
  const std::optional<PickMotion>& pickMotion(const FeasibleGrasp& pick);
  const std::optional<PlaceMotion>& placeMotion(const FeasibleGrasp& place);
  std::optional<Hands> joinHands(const HandoverTuple& tuple);

  /// The state with the object in the role's hand, closed by the grasp, at an arm configuration.
  CellState holding(CellState state, const Manipulator& role, const Grasp& grasp,
                    const ArmVector& q) const;
  /// What the fingers touch, if anything, while they go straight from one posture to another, the
  /// arm at a configuration, all else as in the state.
  std::optional<BodyContact> fingersHit(const Manipulator& role, CellState state,
                                        const ArmVector& q, const Eigen::VectorXd& from,
                                        const Eigen::VectorXd& to,
                                        const AllowedContacts& contacts) const;
  std::optional<JointPath> straight(const Manipulator& role, const ArmVector& q, const Pose& X_WT,
                                    const Pose& X_WT_end, StateChecker& checker);
  /// The straight line of the greatest of the distances (falling) that is free; end_at(distance)
  /// is where it leads.
  template <typename EndAt>
  std::optional<JointPath> longestStraight(const Manipulator& role, const ArmVector& q,
                                           const Pose& X_WT, std::span<const double> distances,
                                           const EndAt& end_at, StateChecker& checker);
  /// Straight back from a grasp, against its approach; straight up with the object.
  std::optional<JointPath> backOff(const Manipulator& role, const ArmVector& q, const Pose& X_WT,
                                   StateChecker& checker);
  std::optional<JointPath> lifted(const Manipulator& role, const ArmVector& q, const Pose& X_WT,
                                  StateChecker& checker);
  std::optional<JointPath> route(const Manipulator& role, const ArmVector& from,
                                 const ArmVector& to, StateChecker& checker, StageKind kind,
                                 int grasp, const SeedPaths& known = {});
  /// Configurations that a way which is not straight may well lead through.
  std::vector<ArmVector> viasBetween(const Manipulator& role, const ArmVector& from,
                                     const ArmVector& to) const;
  /// The straight way, else the quickest one through some of those and of the `known`, if any.
  std::optional<JointPath> throughVia(const Manipulator& role, const MotionProblem& motion,
                                      const ArmVector& from, const ArmVector& to,
                                      const std::vector<ArmVector>& known,
                                      std::uint32_t checks) const;
  enum class Ends { kOne, kSeveral };

  /// The ways of throughVia(), else IKBiRRT and shortcuts. `ends` says whether there are several
  /// goals to choose from.
  std::optional<JointPath> search(const Manipulator& role, const ArmVector& from,
                                  const GoalSampler& goals, StateChecker& checker, StageKind kind,
                                  int grasp, Ends ends, std::uint32_t* goal = nullptr,
                                  const SeedPaths& known = {});
  MotionProblem motionProblem(const Manipulator& role, StateChecker& checker) const;
  std::uint64_t seedFor(StageKind kind, int grasp) const;

  const HandoverProblem& problem_;
  const Manipulator& giver_;
  const Manipulator& receiver_;
  const ExchangeBudget budget_;
  const Deadline& deadline_;
  CollisionContext checkers_;
  CollisionContext spare_checkers_;
  CellState start_;
  std::map<int, std::optional<PickMotion>> picks_;    ///< by giver grasp
  std::map<int, std::optional<PlaceMotion>> places_;  ///< by receiver grasp
  std::vector<StuckTransfer> stuck_;
  std::uint32_t searches_in_vain_ = 0;
};

}  // namespace handover
