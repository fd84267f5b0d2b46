// SPDX-License-Identifier: Apache-2.0
// What a request says and what the answer's stages carry, as plain values: shared by the planning
// core that makes them, the wire that carries them and the client that reads them.
//
// Units: m, rad, s. Joint order is always by the names beside the numbers.
#pragma once

#include <handover/common/geometry.hpp>
#include <handover/common/pose.hpp>
#include <handover/common/request_id.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace handover {

// The request.

/// Stop at the first plan · the best tuple · every tuple.
enum class SearchMode { kFirst, kBest, kAll };

/// The paper's candidates only · widened after them.
enum class SearchWidth { kPaper, kWide };

/// A change of the cell for one request: PATH = keys of the cell file joined by dots, VALUE = YAML.
struct Override {
  std::string path;
  std::string value;
  bool operator==(const Override&) const = default;
};

/// One handover request, as a client sends it.
struct PlanRequest {
  RequestId id;
  std::string client_id;  ///< [a-z0-9_-]{1,64}
  std::string cell;
  std::string task;  ///< empty: object, goal, giver, receiver are given below
  std::string object;
  std::optional<PoseValue> X_WO_goal;
  std::string giver, receiver;          ///< robot names
  std::string giver_arm, receiver_arm;  ///< empty: the planner's choice
  std::vector<Override> overrides;
  std::optional<std::uint64_t> expected_revision;  ///< rejected when the scene has another one
  SearchMode mode = SearchMode::kBest;
  SearchWidth search = SearchWidth::kWide;
  std::uint64_t seed = 1;
  std::optional<double> deadline_s;  ///< from the daemon's acceptance
  double speed_scale = 1.0;          ///< in (0, 1]: slows the timing, not the path
  bool operator==(const PlanRequest&) const = default;
};

// The scene as the plan file shows it.

struct JointLimits {
  double lower = 0, upper = 0;  ///< [rad] or [m]
  double velocity = 0;          ///< [rad/s]
  double acceleration = 0;      ///< [rad/s^2]
  bool operator==(const JointLimits&) const = default;
};

/// Two names: [link, object], [object, object] or [robot/link, ...], as said at the member.
using NamePair = std::pair<std::string, std::string>;

struct RobotSnapshot {
  std::string name;
  std::string urdf;                                     ///< path relative to the root
  std::string urdf_sha256;                              ///< 64 hex digits
  std::string srdf;                                     ///< path relative to the root
  PoseValue X_WB;                                       ///< of the URDF's root link
  std::vector<std::pair<std::string, double>> q_start;  ///< every non-fixed joint, mimic ones too
  std::vector<std::pair<std::string, JointLimits>> limits;  ///< of the same joints
  std::vector<NamePair> resting;                            ///< [link, object name]
  bool operator==(const RobotSnapshot&) const = default;
};

struct AttachmentSnapshot {
  std::string robot, link;
  PoseValue X_LO;
  std::vector<std::string> touch_links;
  bool operator==(const AttachmentSnapshot&) const = default;
};

struct ObjectSnapshot {
  std::string name;
  Geometry geometry;
  PoseValue X_WO;  ///< at the start
  std::optional<AttachmentSnapshot> attached_to;
  std::vector<std::string> resting;  ///< names of objects that it may rest on or against
  bool operator==(const ObjectSnapshot&) const = default;
};

// Stages of the answer.

struct Accepted {
  std::uint32_t queue_place = 0;  ///< requests ahead of this one
  std::uint64_t scene_revision = 0;
  bool operator==(const Accepted&) const = default;
};

/// The scene after the request's overrides.
struct SceneSnapshot {
  std::string cell, task;
  std::uint64_t seed = 0;
  std::string scene_hash;  ///< hex digits
  std::string object, giver, receiver;
  PoseValue X_WO_start, X_WO_goal;
  std::vector<RobotSnapshot> robots;
  std::vector<ObjectSnapshot> objects;
  bool operator==(const SceneSnapshot&) const = default;
};

/// §IV-A: the arms, and the manipulability of the map's voxel that chose them (0: not reached).
struct ArmScore {
  std::string robot, arm;
  double manipulability = 0;
  std::string rejected;  ///< why the arm is out of the question; empty if it is not
  bool operator==(const ArmScore&) const = default;
};

struct ArmSelected {
  std::string giver_arm, receiver_arm;
  std::vector<ArmScore> scores;  ///< every arm of both robots
  bool operator==(const ArmSelected&) const = default;
};

/// A reject cause and how often it struck; `cause` is one of no_ik, limits, self_collision,
/// collision (then `pair` names the two bodies) or another word that the stage explains.
struct RejectCount {
  std::string cause;
  NamePair pair;
  std::uint32_t count = 0;
  bool operator==(const RejectCount&) const = default;
};

/// Alg. 1 PruneGrasps at the start (giver) or at the goal (receiver).
struct GraspsPruned {
  std::string robot, arm;
  std::uint32_t tested = 0, kept = 0;
  std::vector<RejectCount> rejects;
  bool operator==(const GraspsPruned&) const = default;
};

inline constexpr double kLatticeEdge = 0.05;  ///< of the world lattice's cells [m]

/// A cell of the world lattice, which is anchored at the world's origin.
struct LatticeCell {
  std::array<double, 3> centre{};
  double score = 0;  ///< mean of both arms' map entries
  bool operator==(const LatticeCell&) const = default;
};

/// Alg. 2 and 3: handover poses tried, and those whose pruned giver set is not empty.
struct HandoverCandidates {
  std::string giver_arm, receiver_arm;
  std::uint32_t voxels = 0;       ///< lattice points that both arms reach near the midpoint
  std::uint32_t poses_tried = 0;  ///< X_WH asked for
  std::uint32_t poses = 0;        ///< X_WH with a giver grasp: the paper's "handover poses"
  std::uint32_t tuples = 0;       ///< (X_WH, g_r, g_g)
  std::vector<RejectCount> rejects;
  /// The cells that both arms reach near the midpoint, best first, cut at bounds::kLattice; where a
  /// pair of arms has several of these stages, in its first only.
  std::vector<LatticeCell> lattice;
  bool operator==(const HandoverCandidates&) const = default;
};

/// Yoshikawa manipulability sqrt(det(J J^T)) at the configurations that the trajectories reach.
struct Dexterity {
  double receiver_place = 0, receiver_handover = 0, giver_pick = 0, giver_handover = 0;
  bool operator==(const Dexterity&) const = default;
};

struct Solution {
  std::uint32_t index = 0;
  std::string giver_arm, receiver_arm;
  std::string giver_tool_link, receiver_tool_link;
  std::uint32_t giver_grasp = 0, receiver_grasp = 0;  ///< indices in the grasp sets
  PoseValue X_WO_handover, X_OT_giver, X_OT_receiver;
  Dexterity dexterity;
  bool operator==(const Solution&) const = default;
};

enum class StageKind {
  kUnspecified = 0,
  kGiverReach,
  kGiverApproach,
  kGiverGrasp,
  kGiverLift,
  kGiverTransfer,
  kReceiverReach,
  kReceiverApproach,
  kReceiverGrasp,
  kGiverRelease,
  kGiverRetreat,
  kReceiverTransfer,
  kReceiverPlace,
  kReceiverRelease,
  kReceiverRetreat,
};
inline constexpr int kStageCount = 14;

/// "giver_reach", ...; "unspecified" for kUnspecified.
const char* toString(StageKind kind);

struct Hold {
  std::string object, robot, link;
  PoseValue X_LO;
  bool operator==(const Hold&) const = default;
};

/// One timed stage: between samples q(t) is the cubic Hermite curve of (q, qd).
struct StageTrajectory {
  std::uint32_t solution = 0;  ///< index of the Solution that it belongs to
  std::uint32_t index = 0;     ///< place in the plan, from 0
  StageKind kind = StageKind::kUnspecified;
  std::string robot;
  std::vector<std::string> joints;         ///< no mimic joints
  double start = 0;                        ///< [s] from the plan's start
  std::vector<double> t;                   ///< strictly rising from 0
  std::vector<std::vector<double>> q, qd;  ///< [sample][joint]
  std::vector<Hold> holding;               ///< every hold in the cell during the stage
  std::vector<NamePair> may_touch;         ///< `robot/link` or object names
  bool operator==(const StageTrajectory&) const = default;
};

enum class FailureReason {
  kUnspecified = 0,
  kStartUnreachable,
  kGoalUnreachable,
  kNoGraspAtStart,
  kNoGraspAtGoal,
  kNoCommonWorkspace,
  kNoHandoverPose,
  kNoPath,
  kStartInCollision,
  kGoalInCollision,
  kDeadline,
  kInternal,
};

/// "start_unreachable", ...; "unspecified" for kUnspecified.
const char* toString(FailureReason reason);

/// Why there is no plan: the filter that emptied and the counts per cause (most frequent first).
struct Explanation {
  std::string filter;  ///< a word of the pipeline, e.g. "receiver_grasps"
  std::string text;    ///< one plain sentence for people
  std::vector<RejectCount> causes;
  std::vector<Override> nearest_fix;  ///< empty when none was looked for or found
  std::string fix_text;
  bool operator==(const Explanation&) const = default;
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

struct Cancelled {
  bool operator==(const Cancelled&) const = default;
};

struct Fault {
  std::string field, message;
  bool operator==(const Fault&) const = default;
};

struct Rejected {
  std::string reason;         ///< bad_request, unknown_cell, busy or scene_changed
  std::vector<Fault> faults;  ///< every fault, by field
  bool operator==(const Rejected&) const = default;
};

using Outcome = std::variant<Done, Failed, Cancelled, Rejected>;

using StagePayload = std::variant<Accepted, SceneSnapshot, ArmSelected, GraspsPruned,
                                  HandoverCandidates, Solution, StageTrajectory, Outcome>;

/// One message of the answer's stream.
struct PlanStage {
  RequestId request_id;
  std::uint32_t sequence = 0;  ///< from 0 without gaps
  double elapsed_s = 0;        ///< since the daemon took the request
  StagePayload payload;
  bool operator==(const PlanStage&) const = default;
};

}  // namespace handover
