// SPDX-License-Identifier: Apache-2.0
// Grasps and motions of one chain of arms: from an object pose to the grasps that are feasible
// there ([paper] Alg. 1), from a tuple of grasps and handover poses to stage paths (§IV-E).
#pragma once

#include "core/planning/free_motion.hpp"
#include "core/planning/linear_motion.hpp"
#include "core/planning/transport_path.hpp"

#include <deque>
#include <map>
#include <optional>
#include <set>
#include <variant>
#include <vector>

namespace handover {

/// A stage for which no motion was found.
struct MotionFailure {
  StageRef stage;
  Cause cause = Cause::kNoPath;
  NamePair pair;  ///< kTiming: what touches on the timed curve
};

/// Keeps what tuples share: the picking depends on the first holder's grasp alone, the placing on
/// the last one's alone. One per worker.
class TransportMotions {
 public:
  /// @param spare_world  a second world over the same scene: tests that take turns keep theirs set.
  /// @pre the arguments outlive this.
  TransportMotions(const TransportProblem& problem, std::vector<const Manipulator*> holders,
                   CollisionWorld& world, CollisionWorld& spare_world, const Deadline& deadline);

  /// Alg. 1 with O at the start, by the first holder ([paper] §IV-C); what it holds already if it
  /// starts in the hand.
  PrunedGrasps pruneFirstAtStart(const PruneEffort& effort);
  /// Alg. 1 with O at the goal, by the last holder (§IV-B).
  PrunedGrasps pruneLastAtGoal(const PruneEffort& effort);
  /// Alg. 3's last step: the grasp of handover's receiver with O at X_WH, the giver's arm at its
  /// start, where it has to get to while the receiver still stands there.
  /// @param give  the same grasp where the receiver gives the object on, or puts it down.
  PrunedGrasps pruneReceiverAt(std::size_t handover, const Pose& X_WH, const FeasibleGrasp& give);
  /// Alg. 2: the giver's grasps, of those it can take with, with O at X_WH and the receiver's hand
  /// in place.
  PrunedGrasps pruneGiverAt(std::size_t handover, const Pose& X_WH, const FeasibleGrasp& receive,
                            const PrunedGrasps& takes);

  /// Whether the giver's arm has any configuration at all with O at X_WH, by a grasp it can take
  /// with; whether the receiver's has any with its grasp. Asked first: most poses fail here.
  /// @param receive  grasps of the giver that are known to be in the way of this one are left out.
  bool giverReaches(std::size_t handover, const Pose& X_WH, int receive, const PrunedGrasps& takes);
  /// The hands that meet where every grasp of the giver is known to be in the receiver's way.
  std::optional<BodyPair> handsInTheWay(std::size_t handover, int receive,
                                        const PrunedGrasps& takes);
  bool receiverReaches(std::size_t handover, const Pose& X_WH, int grasp);

  /// How often these two have asked for a configuration by least squares and found none, which
  /// takes a hundred times as long as the closed form.
  std::uint32_t failedIkSolves() const { return failed_ik_solves_; }

  /// How often these two have asked for a configuration at all.
  std::uint32_t ikLooks() const { return ik_looks_; }

  /// How many searches for a free motion by trees have found nothing.
  std::uint32_t failedTrees() const { return free_motion_.failedTrees(); }

  /// How many ways of one giver, to where it gives the object or home, were sought in vain: the
  /// most of one stage.
  std::uint32_t failedWays() const { return most_failed_ways_; }

  /// Drops the receiver's leading configurations until one has a collision-free straight approach,
  /// the giver out of the way; false, nothing changed, if none has.
  bool keepApproachable(std::size_t handover, const Pose& X_WH, FeasibleGrasp& receive);

  /// Whether both hands can be at the object at a handover, come and leave, whatever comes before.
  /// @param tuple  set from the giver's give and the receiver's take on.
  bool handsMeet(std::size_t handover, const TransportTuple& tuple);

  /// Whether the first holder can take the object by a grasp, whatever follows.
  /// @param patience  how many times the usual effort it may take; less is not tried again.
  bool canTake(const FeasibleGrasp& take, std::uint32_t patience) {
    return pickMotion(take, patience).has_value();
  }

  /// All motions of a tuple, or the stage at which none was found.
  std::variant<TransportPath, MotionFailure> connect(const TransportTuple& tuple);

  const std::vector<const Manipulator*>& holders() const { return holders_; }

  const std::vector<TaskStage>& stages() const { return stages_; }

  CollisionContext& context() { return context_; }

 private:
  struct PickMotion {
    ArmVector q;  ///< at the object
    JointPath reach, approach, lift;
  };

  /// What was found for a grasp, and how patiently it was looked for.
  struct Pick {
    std::optional<PickMotion> motion;
    std::uint32_t patience = 0;
  };

  /// What the last holder does at the goal; the paths are empty where it ends with O in hand.
  struct PlaceMotion {
    ArmVector q;
    JointPath place, retreat, home;
  };

  /// Both hands at the object.
  struct DualGrasp {
    ArmVector q_g, q_r;
    JointPath approach, retreat;  ///< the receiver's, on to q_r; the giver's, back from q_g
  };

  /// A free motion that was not found.
  struct FailedMotion {
    std::size_t holder;
    StageAction action;
    int grasp;             ///< of the holder, where it gives the object
    ArmVector q, q_other;  ///< the holder's arm at the handover, and who else is there
    bool operator==(const FailedMotion&) const = default;
  };

  /// Everything that connect() finds, by holder or handover.
  struct Motions {
    std::vector<DualGrasp> dual_grasps;
    std::vector<JointPath> reaches, carries, homes;
    const PickMotion* pick = nullptr;  ///< nullptr: held at the start
    const PlaceMotion* place = nullptr;
  };

  std::size_t last() const { return holders_.size() - 1; }

  const Manipulator& at(std::size_t holder) const { return *holders_[holder]; }

  ArmVector homeOf(const Manipulator& arm) const { return arm.armOf(start_.of(arm)); }

  AllowedContacts contactsOf(std::size_t holder, StageAction action) const;

  /// Of the open hand at the object.
  AllowedContacts besideContacts(std::size_t holder, StageAction action) const {
    return besideObject(contactsOf(holder, action), holder, at(holder));
  }

  bool reaches(const Manipulator& arm, const Pose& X_WT);
  std::uint64_t seedFor(std::size_t holder, StageAction action, int grasp) const;

  const std::optional<PickMotion>& pickMotion(const FeasibleGrasp& take,
                                              std::uint32_t patience = 1);
  const std::optional<PlaceMotion>& placeMotion(const FeasibleGrasp& give);
  std::optional<PlaceMotion> placeAt(const FeasibleGrasp& give, const ArmVector& q);
  std::optional<DualGrasp> dualGrasp(std::size_t handover, const TransportTuple& tuple);
  std::optional<DualGrasp> findDualGrasp(std::size_t handover, const TransportTuple& tuple,
                                         bool& hopeless);
  struct HandPair;
  std::optional<DualGrasp> dualGraspAt(const HandPair& hands, const CellState& given,
                                       const ArmVector& q_g, const ArmVector& q_r,
                                       StateChecker& arriving, bool& hopeless);

  /// As everything stands when holder's carry begins: holders before it at home with open hands.
  CellState stateBefore(std::size_t holder, const TransportTuple& tuple) const;
  /// @param[out] cause  why there is none.
  std::optional<JointPath> carryPath(std::size_t holder, const TransportTuple& tuple,
                                     const Motions& motions, Cause& cause);
  /// Of a chain of one, if there is none to the place chosen: to another configuration there.
  /// @param[out] motions  with that place.
  std::optional<JointPath> carryElsewhere(const TransportTuple& tuple, Motions& motions);
  std::optional<JointPath> reachPath(std::size_t holder, const TransportTuple& tuple,
                                     const Motions& motions);
  std::optional<JointPath> homePath(std::size_t holder, const TransportTuple& tuple,
                                    const Motions& motions);
  MotionFailure noWay(std::size_t holder, StageAction action, Cause cause);
  FailedMotion lastCarry(const TransportTuple& tuple, const Motions& motions) const;
  FailedMotion wayHome(std::size_t holder, const TransportTuple& tuple,
                       const Motions& motions) const;
  /// Why it was not found; none: it has not been sought.
  std::optional<Cause> knownToFail(const FailedMotion& motion) const;
  std::optional<MotionFailure> findMotions(const TransportTuple& tuple, Motions& motions);
  ArmVector takeConfiguration(std::size_t holder, const Motions& motions) const;
  ArmVector giveConfiguration(std::size_t holder, const Motions& motions) const;

  const JointPath& armPath(const TaskStage& stage, const Motions& motions) const;
  /// The stage as it begins `now`, which becomes the state at its end.
  StagePath gripStage(const TaskStage& stage, const Grasp& grasp, CellState& now) const;
  StagePath armStage(const TaskStage& stage, const Grasp& grasp, const JointPath& moves,
                     const TransportTuple& tuple, CellState& now) const;
  TransportPath assemble(const TransportTuple& tuple, const Motions& motions) const;

  const TransportProblem& problem_;
  std::vector<const Manipulator*> holders_;
  std::vector<TaskStage> stages_;
  const Deadline& deadline_;
  CollisionContext context_, spare_context_;
  FreeMotionSolver free_motion_;
  CellState start_;
  std::map<int, Pick> picks_;  ///< by the first holder's grasp
  /// By the last holder's grasp, and the first of its configurations.
  std::map<std::pair<int, std::vector<double>>, std::optional<PlaceMotion>> places_;
  std::deque<PlaceMotion> elsewhere_;  ///< of carryElsewhere()
  std::vector<std::pair<FailedMotion, Cause>> failed_motions_;
  std::map<std::pair<std::size_t, StageAction>, std::uint32_t> failed_ways_;  ///< of givers

  /// Two grasps at one handover.
  struct HandsAt {
    std::size_t handover;
    int give, receive;
    auto operator<=>(const HandsAt&) const = default;
  };

  std::set<HandsAt> hopeless_hands_;
  std::map<std::pair<std::size_t, int>, HandConflicts> hand_conflicts_;  ///< by receiver's grasp
  std::uint32_t failed_ik_solves_ = 0, ik_looks_ = 0, most_failed_ways_ = 0;
};

}  // namespace handover
