// SPDX-License-Identifier: Apache-2.0
// The messages of an answer (design §4) as plain values: shared by the planning core that makes
// them, the wire that carries them and the client that reads them. A stage is a motion, an event a
// message.
//
// Units: m, rad, s. Joint order is always by the names beside the numbers.
#pragma once

#include <handover/common/plan_request.hpp>
#include <handover/common/scene_snapshot.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace handover {

struct Accepted {
  std::array<std::uint8_t, 16> daemon_id{};
  std::uint64_t epoch = 0;  ///< of the daemon's leadership for the cell; 0: it shares the cell
  std::string program_version;
  std::uint64_t scene_revision = 0;
  std::string scene_hash;         ///< of the cell's first task, before overrides; hex digits
  std::uint32_t queue_place = 0;  ///< requests ahead of this one
  bool operator==(const Accepted&) const = default;
};

// Why candidates fall.

/// A step at which a candidate fell. Of an arm: kNotInMap to kExcluded; of a grasp or a pose: kNoIk
/// to kGrip; of motions: kStraightApproach to kTiming.
enum class Cause {
  kUnspecified = 0,
  kNotInMap,     ///< the reachability map does not know the place
  kHoldsObject,  ///< the arm's hand holds another object
  kNoGripper,
  kNoGrasps,       ///< no grasp set, or an empty one
  kExcluded,       ///< by the request
  kNoIk,           ///< out of reach
  kLimits,         ///< reached only beyond joint limits
  kSelfCollision,  ///< two bodies of one robot
  kCollision,
  kTilt,              ///< the object would lean too far
  kGrip,              ///< the gripper does not fit the object there
  kHandsMeet,         ///< both hands at the object, coming and leaving
  kStraightApproach,  ///< no straight way to or from the object
  kNoPath,            ///< no path found
  kTiming,            ///< the timed curve touches something
  kUnsupported,       ///< the object rests on nothing
  kDeadline,          ///< passed before anything was counted
};

template <>
struct EnumNames<Cause> {
  static constexpr std::array value{
      "unspecified", "not_in_map",  "holds_object", "no_gripper",        "no_grasps",
      "excluded",    "no_ik",       "limits",       "self_collision",    "collision",
      "tilt",        "grip",        "hands_meet",   "straight_approach", "no_path",
      "timing",      "unsupported", "deadline"};
};

/// What a stage does (design §5, Stages).
enum class StageAction {
  kUnspecified = 0,
  kReach,
  kApproach,
  kGrasp,
  kLift,
  kCarry,
  kPlace,
  kRelease,
  kRetreat,
  kHome,
};

template <>
struct EnumNames<StageAction> {
  static constexpr std::array value{"unspecified", "reach", "approach", "grasp",   "lift",
                                    "carry",       "place", "release",  "retreat", "home"};
};

/// A stage by what it does and which holder of the chain does it.
struct StageRef {
  std::uint32_t holder = 0;
  StageAction action = StageAction::kUnspecified;
  auto operator<=>(const StageRef&) const = default;
};

/// A cause and how often it struck. `pair`: the two bodies that touch, in alphabetical order, or
/// ("robot/arm", "") or (object, "") where the cause speaks of one thing; empty: none.
struct CauseCount {
  Cause cause = Cause::kUnspecified;
  NamePair pair;
  std::optional<StageRef> stage;  ///< of motions: where it struck
  std::uint32_t count = 0;
  bool operator==(const CauseCount&) const = default;
};

// The funnel.

/// §IV-A: an arm, and the manipulability of the map's voxel that ranks it (0: not reached).
struct ArmScore {
  ArmName arm;
  std::uint32_t holder = 0;  ///< place in the chain that it was ranked for
  double manipulability = 0;
  Cause rejected = Cause::kUnspecified;  ///< why the arm is out; unspecified: it is not
  std::string object;                    ///< kHoldsObject: what it holds
  bool operator==(const ArmScore&) const = default;
};

struct ArmSelected {
  std::vector<ArmName> holders;  ///< the first choice for each; an empty arm: none
  std::vector<ArmScore> scores;  ///< every arm looked at
  bool operator==(const ArmSelected&) const = default;
};

/// Where a grasp set was pruned.
enum class PruningPlace { kUnspecified = 0, kStart, kGoal };

template <>
struct EnumNames<PruningPlace> {
  static constexpr std::array value{"unspecified", "start", "goal"};
};

/// Alg. 1 PruneGrasps: the first holder's grasps at the start, the last one's at the goal.
struct GraspsPruned {
  ArmName arm;
  std::uint32_t holder = 0;
  PruningPlace place = PruningPlace::kUnspecified;
  std::uint32_t tested = 0, kept = 0;
  std::vector<CauseCount> causes;
  bool operator==(const GraspsPruned&) const = default;
};

inline constexpr double kLatticeEdge = 0.05;  ///< of the world lattice's cells [m]

/// A cell of the world lattice, which is anchored at the world's origin.
struct LatticeCell {
  std::array<double, 3> centre{};
  double score = 0;  ///< mean of both arms' map entries
  bool operator==(const LatticeCell&) const = default;
};

/// Alg. 2 and 3 for one handover of the chain: poses tried, and those whose pruned giver set is not
/// empty.
struct HandoverCandidates {
  std::uint32_t handover = 0;  ///< from holder `handover` to the next
  ArmName giver, receiver;
  std::uint32_t lattice_points = 0;   ///< that both arms reach near the shoulders' midpoint
  std::uint32_t poses_tried = 0;      ///< X_WH asked for
  std::uint32_t poses = 0;            ///< X_WH with a giver grasp: the paper's "handover poses"
  std::uint32_t receiver_grasps = 0;  ///< of the receiver that have such a pose
  std::uint32_t tuples = 0;           ///< (X_WH, g_r, g_g): summed sizes of the giver's sets
  std::vector<CauseCount> causes;
  /// The cells that both arms reach near the midpoint, best first, cut at bounds::kLattice; where a
  /// pair of arms has several of these events, in its first only.
  std::vector<LatticeCell> lattice;
  bool operator==(const HandoverCandidates&) const = default;
};

// Plans.

struct FingerGripper {
  std::string palm_link;
  std::vector<std::string> finger_links;
  bool operator==(const FingerGripper&) const = default;
};

struct SuctionGripper {
  std::string cup_link;
  std::array<double, 3> axis{0, 0, 1};  ///< in the cup link, towards the object
  double radius = 0;                    ///< [m]
  bool operator==(const SuctionGripper&) const = default;
};

using GripperSnapshot = std::variant<FingerGripper, SuctionGripper>;

/// Yoshikawa manipulability sqrt(det(J J^T)) where a holder takes the object and where it gives it.
struct Dexterity {
  double take = 0, give = 0;
  bool operator==(const Dexterity&) const = default;
};

struct Holder {
  ArmName arm;
  std::string tool_link;
  GripperSnapshot gripper;
  PoseValue X_OT;
  std::uint32_t grasp = 0;  ///< index in the grasp set
  Dexterity dexterity;
  bool operator==(const Holder&) const = default;
};

/// What a plan is like (design §5, Quality).
struct ClearanceQuality {
  std::string between;  ///< furniture, robots or object
  double least_m = 0;
  std::uint32_t stage = 0;
  NamePair pair;  ///< empty: none within 0.05 m
  bool operator==(const ClearanceQuality&) const = default;
};

struct GripQuality {
  std::uint32_t holder = 0;
  double quality = 0, of_best = 0;
  bool operator==(const GripQuality&) const = default;
};

struct Quality {
  double duration_s = 0, bound_s = 0, object_s = 0;
  std::vector<std::pair<std::string, double>> idle_s;  ///< by robot
  std::vector<ClearanceQuality> clearance;
  double tilt_deg = 0;
  std::array<double, 2> object_turn_deg{};  ///< in all, and the least from start to goal
  double limit_margin = 0;
  std::vector<GripQuality> grip;
  double jerk_share = 0;
  double cost = 0;
  std::vector<std::pair<std::string, double>> terms;
  bool operator==(const Quality&) const = default;
};

struct Solution {
  std::uint32_t index = 0;
  std::vector<Holder> holders;
  std::vector<PoseValue> X_WO_handovers;  ///< one fewer than holders
  std::uint32_t stage_count = 0;          ///< trajectories that follow
  double slack_s = 0;
  double cost = 0;                 ///< under the request's objective; lower is better
  std::optional<Quality> quality;  ///< nullopt: not computed
  bool operator==(const Solution&) const = default;
};

struct Hold {
  std::string object, robot, link;
  PoseValue X_LO;
  bool operator==(const Hold&) const = default;
};

/// Stage `stage` has run `progress` seconds of its own time.
struct StageProgress {
  std::uint32_t stage = 0;
  double progress = 0;  ///< [s]
  bool operator==(const StageProgress&) const = default;
};

/// One timed stage: between samples q(t) is the quintic Hermite curve of (q, qd, qdd).
struct StageTrajectory {
  std::uint32_t solution = 0;  ///< index of the Solution that it belongs to
  std::uint32_t index = 0;     ///< place in the order in which stages could run one by one
  std::uint32_t holder = 0;    ///< who moves: place in the chain
  StageAction action = StageAction::kUnspecified;
  std::string robot;
  std::vector<std::string> joints;              ///< no mimic joints; none for suction
  double start = 0;                             ///< [s] from the plan's start
  std::vector<double> t;                        ///< strictly rising from 0
  std::vector<std::vector<double>> q, qd, qdd;  ///< [sample][joint]
  std::vector<Hold> holding;                    ///< every hold in the cell as the stage begins
  std::vector<NamePair> may_touch;              ///< `robot/link` or object names
  std::vector<StageProgress> after;             ///< what must have happened before it starts
  bool operator==(const StageTrajectory&) const = default;
};

/// Something the client may want to know, e.g. that one arm could do it alone.
struct Note {
  std::string code;  ///< [a-z_]+
  std::string text;
  bool operator==(const Note&) const = default;
};

// The end.

enum class FailureReason {
  kUnspecified = 0,
  kStartUnreachable,
  kGoalUnreachable,
  kNoGrasp,  ///< the hand cannot hold the object at all
  kNoGraspAtStart,
  kNoGraspAtGoal,
  kNoCommonWorkspace,
  kNoHandoverPose,
  kNoPath,
  kStartInCollision,
  kGoalInCollision,
  kStartUnsupported,
  kGoalUnsupported,
  kDeadline,
  kInternal,
};

template <>
struct EnumNames<FailureReason> {
  static constexpr std::array value{"unspecified",
                                    "start_unreachable",
                                    "goal_unreachable",
                                    "no_grasp",
                                    "no_grasp_at_start",
                                    "no_grasp_at_goal",
                                    "no_common_workspace",
                                    "no_handover_pose",
                                    "no_path",
                                    "start_in_collision",
                                    "goal_in_collision",
                                    "start_unsupported",
                                    "goal_unsupported",
                                    "deadline",
                                    "internal"};
};

/// Tools about the object where the search came farthest.
struct FarthestTool {
  ArmName arm;
  PoseValue X_WT;
  bool operator==(const FarthestTool&) const = default;
};

struct Farthest {
  PoseValue X_WO;
  std::vector<FarthestTool> tools;
  StageRef stage;
  bool operator==(const Farthest&) const = default;
};

/// Why there is no plan: the filter that emptied and the counts per cause (most frequent first).
struct Explanation {
  std::string filter;       ///< a word of the pipeline, e.g. "grasps_at_goal"
  std::string text;         ///< one plain sentence for people
  bool exhaustive = false;  ///< everything within what the search covers was tried
  std::vector<CauseCount> causes;
  std::vector<Override> nearest_fix;  ///< empty when none was looked for or found
  std::string fix_text;
  std::optional<Farthest> farthest;
  bool operator==(const Explanation&) const = default;
};

/// The reason, as soon as it is known.
struct Failure {
  FailureReason reason = FailureReason::kUnspecified;
  Explanation explanation;
  bool operator==(const Failure&) const = default;
};

/// What would help.
struct Fix {
  std::vector<Override> overrides;
  std::string text;
  bool operator==(const Fix&) const = default;
};

struct Done {
  std::uint32_t solution = 0;  ///< index of the final solution
  bool complete = true;        ///< false: cut by the deadline, a better one might exist
  bool operator==(const Done&) const = default;
};

struct Failed {
  FailureReason reason = FailureReason::kUnspecified;
  Explanation explanation;
  bool operator==(const Failed&) const = default;
};

/// Who ended it.
enum class CancelCause { kUnspecified = 0, kAsked, kDisposed, kClientLost, kDaemonStopping };

template <>
struct EnumNames<CancelCause> {
  static constexpr std::array value{"unspecified", "asked", "disposed", "client_lost",
                                    "daemon_stopping"};
};

struct Cancelled {
  CancelCause cause = CancelCause::kUnspecified;
  bool operator==(const Cancelled&) const = default;
};

struct Fault {
  std::string field, message;
  bool operator==(const Fault&) const = default;
};

enum class RejectionReason {
  kUnspecified = 0,
  kBadRequest,
  kUnknownCell,
  kBusy,
  kSceneChanged,
  kAlreadyAnswered,
};

template <>
struct EnumNames<RejectionReason> {
  static constexpr std::array value{"unspecified", "bad_request",   "unknown_cell",
                                    "busy",        "scene_changed", "already_answered"};
};

struct Rejected {
  RejectionReason reason = RejectionReason::kUnspecified;
  std::vector<Fault> faults;  ///< every fault, by field
  bool operator==(const Rejected&) const = default;
};

using Outcome = std::variant<Done, Failed, Cancelled, Rejected>;

/// Where an arm's tool comes in a horizontal plane, by the arm's reachability map: cells of edge
/// kLatticeEdge, row by row along y, each row along x.
struct ReachSlice {
  ArmName arm;
  std::string tool_link;          ///< whose origin the map is about
  std::array<double, 2> first{};  ///< centre of the first cell, x and y in W [m]
  std::uint32_t columns = 0;      ///< cells of a row; 0: none, the plane is out of reach
  std::vector<double> scores;     ///< the map's entries; 0: not reached
  bool operator==(const ReachSlice&) const = default;
};

/// Of a failure: the workspaces of the arms that it is about, as slices of their maps.
struct Workspaces {
  double z = 0;  ///< of the plane, in W [m]
  std::vector<ReachSlice> slices;
  bool operator==(const Workspaces&) const = default;
};

using PlanEventPayload =
    std::variant<Accepted, SceneSnapshot, ArmSelected, GraspsPruned, HandoverCandidates, Solution,
                 StageTrajectory, Note, Failure, Fix, Outcome, Workspaces>;

/// A daemon's answer, once begun.
using AnswerId = std::array<std::uint8_t, 16>;

/// One message of an answer's stream.
struct PlanEvent {
  RequestId request_id;
  AnswerId answer_id{};        ///< random for each time that a daemon begins to answer
  std::uint32_t sequence = 0;  ///< from 0 without gaps
  double elapsed_s = 0;        ///< since the daemon took the request
  PlanEventPayload payload;
  bool operator==(const PlanEvent&) const = default;
};

}  // namespace handover
