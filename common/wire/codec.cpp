// SPDX-License-Identifier: Apache-2.0
#include "wire/codec.hpp"

#include "wire/status_extensions.hpp"

#include <algorithm>
#include <iterator>
#include <string_view>

namespace handover::wire {
namespace {

using Faults = std::vector<Fault>;

// Enumerations are numbered alike on both sides: the last one and their count pin it down.
template <typename Enum, typename Wire>
constexpr bool alike(Enum last, Wire wire_last) {
  return static_cast<std::uint32_t>(last) == static_cast<std::uint32_t>(wire_last) &&
         EnumNames<Enum>::value.size() == static_cast<std::size_t>(last) + 1;
}

static_assert(alike(SearchMode::kAll, msg::MODE_ALL));
static_assert(alike(SearchWidth::kWide, msg::SEARCH_WIDE));
static_assert(alike(Objective::kDexterity, msg::OBJECTIVE_DEXTERITY));
static_assert(alike(TransportEnd::kHold, msg::END_HOLD));
static_assert(alike(StageAction::kHome, msg::ACTION_HOME));
static_assert(alike(Cause::kDeadline, msg::CAUSE_DEADLINE));
static_assert(static_cast<std::uint32_t>(Cause::kNoIk) == msg::CAUSE_NO_IK);
static_assert(alike(PruningPlace::kGoal, msg::PLACE_GOAL));
static_assert(alike(FailureReason::kInternal, msg::REASON_INTERNAL));
static_assert(static_cast<std::uint32_t>(FailureReason::kNoPath) == msg::REASON_NO_PATH);
static_assert(alike(CancelCause::kDaemonStopping, msg::CANCEL_DAEMON_STOPPING));
static_assert(alike(RejectionReason::kAlreadyAnswered, msg::REJECTION_ALREADY_ANSWERED));
static_assert(alike(DaemonState::kStopping, msg::DAEMON_STOPPING));

// Small parts.

template <typename Out, typename In, typename Convert>
std::vector<Out> mapAll(const std::vector<In>& in, Convert convert) {
  std::vector<Out> out;
  out.reserve(in.size());
  for (const In& item : in) out.push_back(convert(item));
  return out;
}

msg::Vector3 toWire(const std::array<double, 3>& v) {
  msg::Vector3 out;
  out.x(v[0]);
  out.y(v[1]);
  out.z(v[2]);
  return out;
}

std::array<double, 3> fromWire(const msg::Vector3& v) { return {v.x(), v.y(), v.z()}; }

msg::Pose toWire(const PoseValue& X) {
  msg::Pose out;
  out.position(toWire(X.xyz));
  out.orientation().w(X.quat_wxyz[0]);
  out.orientation().x(X.quat_wxyz[1]);
  out.orientation().y(X.quat_wxyz[2]);
  out.orientation().z(X.quat_wxyz[3]);
  return out;
}

PoseValue fromWire(const msg::Pose& X) {
  const auto& quat = X.orientation();
  return {fromWire(X.position()), {quat.w(), quat.x(), quat.y(), quat.z()}};
}

msg::NamePair toWire(const NamePair& pair) {
  msg::NamePair out;
  out.first(pair.first);
  out.second(pair.second);
  return out;
}

NamePair fromWire(const msg::NamePair& pair) { return {pair.first(), pair.second()}; }

msg::SceneOverride toWire(const Override& change) {
  msg::SceneOverride out;
  out.path(change.path);
  out.yaml_value(change.value);
  return out;
}

Override fromWire(const msg::SceneOverride& change) { return {change.path(), change.yaml_value()}; }

msg::ArmName toWire(const ArmName& name) {
  msg::ArmName out;
  out.robot(name.robot);
  out.arm(name.arm);
  return out;
}

ArmName fromWire(const msg::ArmName& name) { return {name.robot(), name.arm()}; }

msg::StageRef toWire(const StageRef& ref) {
  msg::StageRef out;
  out.holder(ref.holder);
  out.action(static_cast<msg::StageAction>(ref.action));
  return out;
}

StageRef fromWire(const msg::StageRef& ref) {
  return {ref.holder(), static_cast<StageAction>(ref.action())};
}

msg::CauseCount toWire(const CauseCount& cause) {
  msg::CauseCount out;
  out.kind(static_cast<msg::CauseKind>(cause.cause));
  out.pair(toWire(cause.pair));
  out.has_stage(cause.stage.has_value());
  out.stage(toWire(cause.stage.value_or(StageRef{})));
  out.count(cause.count);
  return out;
}

CauseCount fromWire(const msg::CauseCount& cause) {
  CauseCount out{static_cast<Cause>(cause.kind()), fromWire(cause.pair()), {}, cause.count()};
  if (cause.has_stage()) out.stage = fromWire(cause.stage());
  return out;
}

msg::Hold toWire(const Hold& hold) {
  msg::Hold out;
  out.object_name(hold.object);
  out.robot(hold.robot);
  out.link(hold.link);
  out.X_LO(toWire(hold.X_LO));
  return out;
}

Hold fromWire(const msg::Hold& hold) {
  return {hold.object_name(), hold.robot(), hold.link(), fromWire(hold.X_LO())};
}

msg::StageProgress toWire(const StageProgress& progress) {
  msg::StageProgress out;
  out.stage(progress.stage);
  out.progress(progress.progress);
  return out;
}

StageProgress fromWire(const msg::StageProgress& progress) {
  return {progress.stage(), progress.progress()};
}

msg::Fault toWire(const Fault& fault) {
  msg::Fault out;
  out.field(fault.field);
  out.message(fault.message);
  return out;
}

Fault fromWire(const msg::Fault& fault) { return {fault.field(), fault.message()}; }

msg::NamedValue toWire(const std::pair<std::string, double>& item) {
  msg::NamedValue out;
  out.name(item.first);
  out.value(item.second);
  return out;
}

std::pair<std::string, double> fromWire(const msg::NamedValue& item) {
  return {item.name(), item.value()};
}

msg::LatticeCell toWire(const LatticeCell& cell) {
  msg::LatticeCell out;
  out.centre(toWire(cell.centre));
  out.score(cell.score);
  return out;
}

LatticeCell fromWire(const msg::LatticeCell& cell) {
  return {fromWire(cell.centre()), cell.score()};
}

msg::Variation toWire(const Variation& variation) {
  msg::Variation out;
  out.path(variation.path);
  out.low(variation.from);
  out.high(variation.to);
  out.choices(variation.choices);
  out.has_facing(variation.facing.has_value());
  if (variation.facing) {
    out.facing_x((*variation.facing)[0]);
    out.facing_y((*variation.facing)[1]);
  }
  return out;
}

Variation fromWire(const msg::Variation& variation) {
  Variation out;
  out.path = variation.path();
  out.from = variation.low();
  out.to = variation.high();
  out.choices = variation.choices();
  if (variation.has_facing()) out.facing = {variation.facing_x(), variation.facing_y()};
  return out;
}

// Named before the templates that call them: the names are looked up there.
msg::RobotSnapshot toWire(const RobotSnapshot& robot);
msg::ObjectSnapshot toWire(const ObjectSnapshot& object);
msg::Holder toWire(const Holder& holder);
msg::ArmScore toWire(const ArmScore& score);
msg::Clearance toWire(const ClearanceQuality& clearance);
msg::Grip toWire(const GripQuality& grip);
msg::FarthestTool toWire(const FarthestTool& tool);
msg::ReachSlice toWire(const ReachSlice& slice);
RobotSnapshot fromWire(const msg::RobotSnapshot& robot);
ArmScore fromWire(const msg::ArmScore& score);
ClearanceQuality fromWire(const msg::Clearance& clearance);
GripQuality fromWire(const msg::Grip& grip);
FarthestTool fromWire(const msg::FarthestTool& tool);
ReachSlice fromWire(const msg::ReachSlice& slice);

template <typename Wire, typename Value>
std::vector<Wire> allToWire(const std::vector<Value>& values) {
  return mapAll<Wire>(values, [](const Value& value) { return toWire(value); });
}

template <typename Value, typename Wire>
std::vector<Value> allFromWire(const std::vector<Wire>& messages) {
  return mapAll<Value>(messages, [](const Wire& message) { return fromWire(message); });
}

// Geometry and scene.

void primitiveToWire(const Geometry& geometry, msg::GeometryPart& out) {
  if (const auto* box = std::get_if<BoxGeometry>(&geometry)) {
    out.kind(msg::GEOMETRY_BOX);
    out.size(toWire(box->size));
  } else if (const auto* sphere = std::get_if<SphereGeometry>(&geometry)) {
    out.kind(msg::GEOMETRY_SPHERE);
    out.radius(sphere->radius);
  } else if (const auto* cylinder = std::get_if<CylinderGeometry>(&geometry)) {
    out.kind(msg::GEOMETRY_CYLINDER);
    out.radius(cylinder->radius);
    out.length(cylinder->length);
  } else if (const auto* mesh = std::get_if<MeshGeometry>(&geometry)) {
    out.kind(msg::GEOMETRY_MESH);
    out.mesh_path(mesh->path);
    out.mesh_scale(toWire(mesh->scale));
  }
}

msg::GeometryPart partToWire(const GeometryPart& part) {
  msg::GeometryPart out;
  out.X_OS(toWire(part.X_OS));
  primitiveToWire(part.geometry, out);
  return out;
}

msg::Geometry toWire(const Geometry& geometry) {
  msg::Geometry out;
  if (const auto* compound = std::get_if<CompoundGeometry>(&geometry)) {
    out.compound(true);
    out.parts(mapAll<msg::GeometryPart>(compound->parts, partToWire));
  } else {
    out.compound(false);
    out.parts().push_back(partToWire({PoseValue{}, geometry}));
  }
  return out;
}

GeometryPart partFromWire(const msg::GeometryPart& part, const std::string& field, Faults& faults) {
  GeometryPart out;
  out.X_OS = fromWire(part.X_OS());
  switch (part.kind()) {
    case msg::GEOMETRY_BOX:
      out.geometry = BoxGeometry{fromWire(part.size())};
      break;
    case msg::GEOMETRY_SPHERE:
      out.geometry = SphereGeometry{part.radius()};
      break;
    case msg::GEOMETRY_CYLINDER:
      out.geometry = CylinderGeometry{part.radius(), part.length()};
      break;
    case msg::GEOMETRY_MESH:
      out.geometry = MeshGeometry{part.mesh_path(), fromWire(part.mesh_scale())};
      break;
    default:
      faults.push_back({field + ".kind", "unknown kind of geometry"});
  }
  return out;
}

Geometry geometryFromWire(const msg::Geometry& geometry, const std::string& field, Faults& faults) {
  if (geometry.parts().size() > bounds::kParts) {
    faults.push_back({field + ".parts", "too many entries"});
    return {};
  }
  if (geometry.compound()) {
    CompoundGeometry compound;
    for (const auto& part : geometry.parts()) {
      compound.parts.push_back(partFromWire(part, field + ".parts", faults));
    }
    return compound;
  }
  if (geometry.parts().size() != 1) {
    faults.push_back({field + ".parts", "a geometry that is not a compound has exactly one part"});
    return {};
  }
  return partFromWire(geometry.parts().front(), field, faults).geometry;
}

msg::JointLimits toWire(const std::string& joint, const JointLimits& limits) {
  msg::JointLimits out;
  out.joint(joint);
  out.continuous(!limits.lower.has_value());
  out.lower(limits.lower.value_or(0));
  out.upper(limits.upper.value_or(0));
  out.velocity(limits.velocity);
  out.acceleration(limits.acceleration);
  out.jerk(limits.jerk);
  return out;
}

JointLimits fromWire(const msg::JointLimits& limits) {
  JointLimits out;
  if (limits.continuous()) {
    out.lower = out.upper = std::nullopt;
  } else {
    out.lower = limits.lower();
    out.upper = limits.upper();
  }
  out.velocity = limits.velocity();
  out.acceleration = limits.acceleration();
  out.jerk = limits.jerk();
  return out;
}

msg::RobotSnapshot toWire(const RobotSnapshot& robot) {
  msg::RobotSnapshot out;
  out.name(robot.name);
  out.urdf(robot.urdf);
  out.srdf(robot.srdf);
  out.yaml(robot.yaml);
  out.urdf_sha256(robot.urdf_sha256);
  out.yaml_sha256(robot.yaml_sha256);
  out.X_WB(toWire(robot.X_WB));
  for (const auto& [joint, position] : robot.q_start) {
    auto& value = out.q_start().emplace_back();
    value.joint(joint);
    value.position(position);
  }
  for (const auto& [joint, limits] : robot.limits) out.limits().push_back(toWire(joint, limits));
  out.resting(allToWire<msg::NamePair>(robot.resting));
  return out;
}

RobotSnapshot fromWire(const msg::RobotSnapshot& robot) {
  RobotSnapshot out;
  out.name = robot.name();
  out.urdf = robot.urdf();
  out.srdf = robot.srdf();
  out.yaml = robot.yaml();
  out.urdf_sha256 = robot.urdf_sha256();
  out.yaml_sha256 = robot.yaml_sha256();
  out.X_WB = fromWire(robot.X_WB());
  for (const auto& value : robot.q_start()) {
    out.q_start.emplace_back(value.joint(), value.position());
  }
  for (const auto& limits : robot.limits()) {
    out.limits.emplace_back(limits.joint(), fromWire(limits));
  }
  out.resting = allFromWire<NamePair>(robot.resting());
  return out;
}

msg::ObjectSnapshot toWire(const ObjectSnapshot& object) {
  msg::ObjectSnapshot out;
  out.name(object.name);
  out.shape(toWire(object.geometry));
  out.X_WO(toWire(object.X_WO));
  out.attached(object.attached_to.has_value());
  const AttachmentSnapshot attachment = object.attached_to.value_or(AttachmentSnapshot{});
  out.attached_robot(attachment.robot);
  out.attached_link(attachment.link);
  out.X_LO(toWire(attachment.X_LO));
  out.touch_links(attachment.touch_links);
  out.resting(object.resting);
  return out;
}

ObjectSnapshot objectFromWire(const msg::ObjectSnapshot& object, Faults& faults) {
  ObjectSnapshot out;
  out.name = object.name();
  out.geometry = geometryFromWire(object.shape(), "scene.objects." + object.name(), faults);
  out.X_WO = fromWire(object.X_WO());
  if (object.attached()) {
    out.attached_to = AttachmentSnapshot{object.attached_robot(), object.attached_link(),
                                         fromWire(object.X_LO()), object.touch_links()};
  }
  out.resting = object.resting();
  return out;
}

msg::Rest toWire(const RestSnapshot& rest) {
  msg::Rest out;
  out.none(rest.none);
  out.objects(rest.objects);
  return out;
}

RestSnapshot fromWire(const msg::Rest& rest) { return {rest.none(), rest.objects()}; }

// Payloads.

void put(msg::PlanEventPayload& out, const Accepted& accepted) {
  msg::Accepted value;
  value.daemon_id(accepted.daemon_id);
  value.epoch(accepted.epoch);
  value.program_version(accepted.program_version);
  value.scene_revision(accepted.scene_revision);
  value.scene_hash(accepted.scene_hash);
  value.queue_place(accepted.queue_place);
  out.accepted_value(std::move(value));
}

Accepted fromWire(const msg::Accepted& value) {
  return {value.daemon_id(),      value.epoch(),      value.program_version(),
          value.scene_revision(), value.scene_hash(), value.queue_place()};
}

void put(msg::PlanEventPayload& out, const SceneSnapshot& scene) {
  msg::SceneSnapshot value;
  value.cell(scene.cell);
  value.task(scene.task);
  value.seed(scene.seed);
  value.scene_hash(scene.scene_hash);
  value.object_name(scene.object);
  value.robots(allToWire<msg::RobotSnapshot>(scene.robots));
  value.objects(allToWire<msg::ObjectSnapshot>(scene.objects));
  value.X_WO_start(toWire(scene.start.X_WO));
  value.held_at_start(scene.start.held_by.has_value());
  value.start_holder(toWire(scene.start.held_by.value_or(ArmName{})));
  value.start_rest(toWire(scene.start.rest));
  value.X_WO_goal(toWire(scene.goal.X_WO));
  value.end(static_cast<msg::TransportEnd>(scene.goal.end));
  value.goal_rest(toWire(scene.goal.rest));
  value.upright(scene.upright.has_value());
  const UprightSnapshot upright = scene.upright.value_or(UprightSnapshot{});
  value.upright_axis(toWire(upright.axis));
  value.upright_within_deg(upright.within_deg);
  out.scene_value(std::move(value));
}

SceneSnapshot sceneFromWire(const msg::SceneSnapshot& value, Faults& faults) {
  SceneSnapshot scene;
  if (value.objects().size() > bounds::kObjects) {
    faults.push_back({"scene.objects", "too many entries"});
    return scene;
  }
  scene.cell = value.cell();
  scene.task = value.task();
  scene.seed = value.seed();
  scene.scene_hash = value.scene_hash();
  scene.object = value.object_name();
  scene.robots = allFromWire<RobotSnapshot>(value.robots());
  for (const auto& object : value.objects()) {
    scene.objects.push_back(objectFromWire(object, faults));
  }
  scene.start.X_WO = fromWire(value.X_WO_start());
  if (value.held_at_start()) scene.start.held_by = fromWire(value.start_holder());
  scene.start.rest = fromWire(value.start_rest());
  scene.goal.X_WO = fromWire(value.X_WO_goal());
  scene.goal.end = static_cast<TransportEnd>(value.end());
  scene.goal.rest = fromWire(value.goal_rest());
  if (value.upright()) {
    scene.upright = UprightSnapshot{fromWire(value.upright_axis()), value.upright_within_deg()};
  }
  return scene;
}

msg::ArmScore toWire(const ArmScore& score) {
  msg::ArmScore out;
  out.arm(toWire(score.arm));
  out.holder(score.holder);
  out.manipulability(score.manipulability);
  out.rejected(static_cast<msg::CauseKind>(score.rejected));
  out.object_name(score.object);
  return out;
}

ArmScore fromWire(const msg::ArmScore& score) {
  return {fromWire(score.arm()), score.holder(), score.manipulability(),
          static_cast<Cause>(score.rejected()), score.object_name()};
}

void put(msg::PlanEventPayload& out, const ArmSelected& arms) {
  msg::ArmSelected value;
  value.holders(allToWire<msg::ArmName>(arms.holders));
  value.scores(allToWire<msg::ArmScore>(arms.scores));
  out.arm_selected_value(std::move(value));
}

ArmSelected fromWire(const msg::ArmSelected& value) {
  return {allFromWire<ArmName>(value.holders()), allFromWire<ArmScore>(value.scores())};
}

void put(msg::PlanEventPayload& out, const GraspsPruned& pruned) {
  msg::GraspsPruned value;
  value.arm(toWire(pruned.arm));
  value.holder(pruned.holder);
  value.place(static_cast<msg::PruningPlace>(pruned.place));
  value.tested(pruned.tested);
  value.kept(pruned.kept);
  value.causes(allToWire<msg::CauseCount>(pruned.causes));
  out.grasps_pruned_value(std::move(value));
}

GraspsPruned fromWire(const msg::GraspsPruned& value) {
  return {fromWire(value.arm()), value.holder(), static_cast<PruningPlace>(value.place()),
          value.tested(),        value.kept(),   allFromWire<CauseCount>(value.causes())};
}

void put(msg::PlanEventPayload& out, const HandoverCandidates& candidates) {
  msg::HandoverCandidates value;
  value.handover(candidates.handover);
  value.giver(toWire(candidates.giver));
  value.receiver(toWire(candidates.receiver));
  value.lattice_points(candidates.lattice_points);
  value.poses_tried(candidates.poses_tried);
  value.poses(candidates.poses);
  value.receiver_grasps(candidates.receiver_grasps);
  value.tuples(candidates.tuples);
  value.causes(allToWire<msg::CauseCount>(candidates.causes));
  value.lattice(allToWire<msg::LatticeCell>(candidates.lattice));
  out.handover_candidates_value(std::move(value));
}

HandoverCandidates fromWire(const msg::HandoverCandidates& value) {
  return {value.handover(),
          fromWire(value.giver()),
          fromWire(value.receiver()),
          value.lattice_points(),
          value.poses_tried(),
          value.poses(),
          value.receiver_grasps(),
          value.tuples(),
          allFromWire<CauseCount>(value.causes()),
          allFromWire<LatticeCell>(value.lattice())};
}

msg::Holder toWire(const Holder& holder) {
  msg::Holder out;
  out.arm(toWire(holder.arm));
  out.tool_link(holder.tool_link);
  if (const auto* hand = std::get_if<FingerGripper>(&holder.gripper)) {
    out.gripper(msg::GRIPPER_FINGERS);
    out.hand_link(hand->palm_link);
    out.finger_links(hand->finger_links);
  } else if (const auto* cup = std::get_if<SuctionGripper>(&holder.gripper)) {
    out.gripper(msg::GRIPPER_SUCTION);
    out.hand_link(cup->cup_link);
    out.cup_axis(toWire(cup->axis));
    out.cup_radius(cup->radius);
  }
  out.X_OT(toWire(holder.X_OT));
  out.grasp(holder.grasp);
  out.dexterity_take(holder.dexterity.take);
  out.dexterity_give(holder.dexterity.give);
  return out;
}

Holder holderFromWire(const msg::Holder& value, Faults& faults) {
  Holder holder;
  holder.arm = fromWire(value.arm());
  holder.tool_link = value.tool_link();
  switch (value.gripper()) {
    case msg::GRIPPER_FINGERS:
      holder.gripper = FingerGripper{value.hand_link(), value.finger_links()};
      break;
    case msg::GRIPPER_SUCTION:
      holder.gripper =
          SuctionGripper{value.hand_link(), fromWire(value.cup_axis()), value.cup_radius()};
      break;
    default:
      faults.push_back({"solution.holders.gripper", "unknown gripper"});
  }
  holder.X_OT = fromWire(value.X_OT());
  holder.grasp = value.grasp();
  holder.dexterity = {value.dexterity_take(), value.dexterity_give()};
  return holder;
}

msg::Clearance toWire(const ClearanceQuality& clearance) {
  msg::Clearance out;
  out.between(clearance.between);
  out.least_m(clearance.least_m);
  out.stage(clearance.stage);
  out.pair(toWire(clearance.pair));
  return out;
}

ClearanceQuality fromWire(const msg::Clearance& clearance) {
  return {clearance.between(), clearance.least_m(), clearance.stage(), fromWire(clearance.pair())};
}

msg::Grip toWire(const GripQuality& grip) {
  msg::Grip out;
  out.holder(grip.holder);
  out.quality(grip.quality);
  out.of_best(grip.of_best);
  return out;
}

GripQuality fromWire(const msg::Grip& grip) {
  return {grip.holder(), grip.quality(), grip.of_best()};
}

msg::PlanQuality toWire(const Quality& quality) {
  msg::PlanQuality out;
  out.duration_s(quality.duration_s);
  out.bound_s(quality.bound_s);
  out.object_s(quality.object_s);
  out.idle_s(allToWire<msg::NamedValue>(quality.idle_s));
  out.clearances(allToWire<msg::Clearance>(quality.clearance));
  out.tilt_deg(quality.tilt_deg);
  out.object_turn_deg(quality.object_turn_deg[0]);
  out.object_turn_least_deg(quality.object_turn_deg[1]);
  out.limit_margin(quality.limit_margin);
  out.grips(allToWire<msg::Grip>(quality.grip));
  out.jerk_share(quality.jerk_share);
  out.cost(quality.cost);
  out.terms(allToWire<msg::NamedValue>(quality.terms));
  return out;
}

Quality fromWire(const msg::PlanQuality& value) {
  using Named = std::pair<std::string, double>;
  Quality quality;
  quality.duration_s = value.duration_s();
  quality.bound_s = value.bound_s();
  quality.object_s = value.object_s();
  quality.idle_s = allFromWire<Named>(value.idle_s());
  quality.clearance = allFromWire<ClearanceQuality>(value.clearances());
  quality.tilt_deg = value.tilt_deg();
  quality.object_turn_deg = {value.object_turn_deg(), value.object_turn_least_deg()};
  quality.limit_margin = value.limit_margin();
  quality.grip = allFromWire<GripQuality>(value.grips());
  quality.jerk_share = value.jerk_share();
  quality.cost = value.cost();
  quality.terms = allFromWire<Named>(value.terms());
  return quality;
}

void put(msg::PlanEventPayload& out, const Solution& solution) {
  msg::Solution value;
  value.index(solution.index);
  value.holders(allToWire<msg::Holder>(solution.holders));
  value.X_WO_handovers(allToWire<msg::Pose>(solution.X_WO_handovers));
  value.stage_count(solution.stage_count);
  value.slack_s(solution.slack_s);
  value.cost(solution.cost);
  value.has_quality(solution.quality.has_value());
  value.quality(toWire(solution.quality.value_or(Quality{})));
  out.solution_value(std::move(value));
}

Solution solutionFromWire(const msg::Solution& value, Faults& faults) {
  Solution solution;
  if (value.holders().size() > bounds::kHolders) {
    faults.push_back({"solution.holders", "too many entries"});
    return solution;
  }
  solution.index = value.index();
  for (const auto& holder : value.holders()) {
    solution.holders.push_back(holderFromWire(holder, faults));
  }
  solution.X_WO_handovers = allFromWire<PoseValue>(value.X_WO_handovers());
  solution.stage_count = value.stage_count();
  solution.slack_s = value.slack_s();
  solution.cost = value.cost();
  if (value.has_quality()) solution.quality = fromWire(value.quality());
  return solution;
}

std::vector<double> flatten(const std::vector<std::vector<double>>& rows) {
  std::vector<double> flat;
  for (const auto& row : rows) flat.insert(flat.end(), row.begin(), row.end());
  return flat;
}

std::vector<std::vector<double>> rowsOf(const std::vector<double>& flat, std::size_t rows,
                                        std::size_t columns, const std::string& field,
                                        Faults& faults) {
  if (rows > bounds::kSamples || columns > bounds::kJoints || flat.size() != rows * columns) {
    faults.push_back({field, "has not one row of joints for each t"});
    return {};
  }
  std::vector<std::vector<double>> out;
  out.reserve(rows);
  for (std::size_t r = 0; r < rows; ++r) {
    const auto begin = flat.begin() + static_cast<std::ptrdiff_t>(r * columns);
    out.emplace_back(begin, begin + static_cast<std::ptrdiff_t>(columns));
  }
  return out;
}

void put(msg::PlanEventPayload& out, const StageTrajectory& stage) {
  msg::StageTrajectory value;
  value.solution(stage.solution);
  value.index(stage.index);
  value.holder(stage.holder);
  value.action(static_cast<msg::StageAction>(stage.action));
  value.robot(stage.robot);
  value.joints(stage.joints);
  value.start(stage.start);
  value.t(stage.t);
  value.q(flatten(stage.q));
  value.qd(flatten(stage.qd));
  value.qdd(flatten(stage.qdd));
  value.holding(allToWire<msg::Hold>(stage.holding));
  value.may_touch(allToWire<msg::NamePair>(stage.may_touch));
  value.after(allToWire<msg::StageProgress>(stage.after));
  out.trajectory_value(std::move(value));
}

StageTrajectory trajectoryFromWire(const msg::StageTrajectory& value, Faults& faults) {
  const auto rows = [&](const std::vector<double>& flat, const char* field) {
    return rowsOf(flat, value.t().size(), value.joints().size(), field, faults);
  };
  StageTrajectory stage;
  stage.solution = value.solution();
  stage.index = value.index();
  stage.holder = value.holder();
  stage.action = static_cast<StageAction>(value.action());
  stage.robot = value.robot();
  stage.joints = value.joints();
  stage.start = value.start();
  stage.t = value.t();
  stage.q = rows(value.q(), "trajectory.q");
  stage.qd = rows(value.qd(), "trajectory.qd");
  stage.qdd = rows(value.qdd(), "trajectory.qdd");
  stage.holding = allFromWire<Hold>(value.holding());
  stage.may_touch = allFromWire<NamePair>(value.may_touch());
  stage.after = allFromWire<StageProgress>(value.after());
  return stage;
}

void put(msg::PlanEventPayload& out, const Note& note) {
  msg::Note value;
  value.code(note.code);
  value.text(note.text);
  out.note_value(std::move(value));
}

Note fromWire(const msg::Note& value) { return {value.code(), value.text()}; }

msg::FarthestTool toWire(const FarthestTool& tool) {
  msg::FarthestTool out;
  out.arm(toWire(tool.arm));
  out.X_WT(toWire(tool.X_WT));
  return out;
}

FarthestTool fromWire(const msg::FarthestTool& tool) {
  return {fromWire(tool.arm()), fromWire(tool.X_WT())};
}

msg::Explanation toWire(const Explanation& why) {
  msg::Explanation out;
  out.filter(why.filter);
  out.text(why.text);
  out.exhaustive(why.exhaustive);
  out.causes(allToWire<msg::CauseCount>(why.causes));
  out.nearest_fix(allToWire<msg::SceneOverride>(why.nearest_fix));
  out.fix_text(why.fix_text);
  out.has_farthest(why.farthest.has_value());
  const Farthest farthest = why.farthest.value_or(Farthest{});
  out.farthest().X_WO(toWire(farthest.X_WO));
  out.farthest().tools(allToWire<msg::FarthestTool>(farthest.tools));
  out.farthest().stage(toWire(farthest.stage));
  return out;
}

Explanation fromWire(const msg::Explanation& value) {
  Explanation why;
  why.filter = value.filter();
  why.text = value.text();
  why.exhaustive = value.exhaustive();
  why.causes = allFromWire<CauseCount>(value.causes());
  why.nearest_fix = allFromWire<Override>(value.nearest_fix());
  why.fix_text = value.fix_text();
  if (value.has_farthest()) {
    const auto& farthest = value.farthest();
    why.farthest = Farthest{fromWire(farthest.X_WO()), allFromWire<FarthestTool>(farthest.tools()),
                            fromWire(farthest.stage())};
  }
  return why;
}

void put(msg::PlanEventPayload& out, const Failure& failure) {
  msg::Failure value;
  value.reason(static_cast<msg::FailureReason>(failure.reason));
  value.why(toWire(failure.explanation));
  out.failure_value(std::move(value));
}

Failure fromWire(const msg::Failure& value) {
  return {static_cast<FailureReason>(value.reason()), fromWire(value.why())};
}

void put(msg::PlanEventPayload& out, const Fix& fix) {
  msg::Fix value;
  value.overrides(allToWire<msg::SceneOverride>(fix.overrides));
  value.text(fix.text);
  out.fix_value(std::move(value));
}

Fix fromWire(const msg::Fix& value) {
  return {allFromWire<Override>(value.overrides()), value.text()};
}

void put(msg::PlanEventPayload& out, const Outcome& outcome) {
  msg::Outcome value;
  if (const auto* done = std::get_if<Done>(&outcome)) {
    value.kind(msg::OUTCOME_DONE);
    value.solution(done->solution);
    value.complete(done->complete);
  } else if (const auto* failed = std::get_if<Failed>(&outcome)) {
    value.kind(msg::OUTCOME_FAILED);
    value.reason(static_cast<msg::FailureReason>(failed->reason));
    value.why(toWire(failed->explanation));
  } else if (const auto* cancelled = std::get_if<Cancelled>(&outcome)) {
    value.kind(msg::OUTCOME_CANCELLED);
    value.cancelled_by(static_cast<msg::CancelCause>(cancelled->cause));
  } else if (const auto* rejected = std::get_if<Rejected>(&outcome)) {
    value.kind(msg::OUTCOME_REJECTED);
    value.rejection(static_cast<msg::RejectionReason>(rejected->reason));
    value.faults(allToWire<msg::Fault>(rejected->faults));
  }
  out.outcome_value(std::move(value));
}

Outcome outcomeFromWire(const msg::Outcome& value, Faults& faults) {
  switch (value.kind()) {
    case msg::OUTCOME_DONE:
      return Done{value.solution(), value.complete()};
    case msg::OUTCOME_FAILED:
      return Failed{static_cast<FailureReason>(value.reason()), fromWire(value.why())};
    case msg::OUTCOME_CANCELLED:
      return Cancelled{static_cast<CancelCause>(value.cancelled_by())};
    case msg::OUTCOME_REJECTED:
      return Rejected{static_cast<RejectionReason>(value.rejection()),
                      allFromWire<Fault>(value.faults())};
    default:
      faults.push_back({"outcome.kind", "unknown outcome"});
  }
  return Cancelled{CancelCause::kAsked};
}

msg::ReachSlice toWire(const ReachSlice& slice) {
  msg::ReachSlice out;
  out.arm(toWire(slice.arm));
  out.tool_link(slice.tool_link);
  out.first_x(slice.first[0]);
  out.first_y(slice.first[1]);
  out.columns(slice.columns);
  out.scores(slice.scores);
  return out;
}

ReachSlice fromWire(const msg::ReachSlice& slice) {
  return {fromWire(slice.arm()),
          slice.tool_link(),
          {slice.first_x(), slice.first_y()},
          slice.columns(),
          slice.scores()};
}

void put(msg::PlanEventPayload& out, const Workspaces& workspaces) {
  msg::Workspaces value;
  value.z(workspaces.z);
  value.slices(allToWire<msg::ReachSlice>(workspaces.slices));
  out.workspaces_value(std::move(value));
}

Workspaces fromWire(const msg::Workspaces& value) {
  return {value.z(), allFromWire<ReachSlice>(value.slices())};
}

PlanEventPayload payloadFromWire(const msg::PlanEventPayload& payload, Faults& faults) {
  switch (payload._d()) {
    case msg::PAYLOAD_ACCEPTED:
      return fromWire(payload.accepted_value());
    case msg::PAYLOAD_SCENE:
      return sceneFromWire(payload.scene_value(), faults);
    case msg::PAYLOAD_ARM_SELECTED:
      return fromWire(payload.arm_selected_value());
    case msg::PAYLOAD_GRASPS_PRUNED:
      return fromWire(payload.grasps_pruned_value());
    case msg::PAYLOAD_HANDOVER_CANDIDATES:
      return fromWire(payload.handover_candidates_value());
    case msg::PAYLOAD_SOLUTION:
      return solutionFromWire(payload.solution_value(), faults);
    case msg::PAYLOAD_TRAJECTORY:
      return trajectoryFromWire(payload.trajectory_value(), faults);
    case msg::PAYLOAD_NOTE:
      return fromWire(payload.note_value());
    case msg::PAYLOAD_FAILURE:
      return fromWire(payload.failure_value());
    case msg::PAYLOAD_FIX:
      return fromWire(payload.fix_value());
    case msg::PAYLOAD_OUTCOME:
      return outcomeFromWire(payload.outcome_value(), faults);
    case msg::PAYLOAD_WORKSPACES:
      return fromWire(payload.workspaces_value());
    default:
      faults.push_back({"payload", "unknown payload"});
  }
  return Accepted{};
}

/// The checked value, or the faults of both passes.
template <typename T>
Decoded<T> checked(T value, Faults faults) {
  Faults more = check(value);
  faults.insert(faults.end(), std::make_move_iterator(more.begin()),
                std::make_move_iterator(more.end()));
  if (faults.size() > bounds::kFaults) faults.resize(bounds::kFaults);
  if (!faults.empty()) return faults;
  return value;
}

Faults versionFaults(std::uint32_t version) {
  if (version == msg::WIRE_VERSION) return {};
  return {{"version",
           "is " + std::to_string(version) + ", must be " + std::to_string(msg::WIRE_VERSION)}};
}

void checkExtensions(const std::vector<msg::KeyValue>& extensions, Faults& faults) {
  if (extensions.size() > 64) faults.push_back({"extensions", "more than 64 entries"});
  for (const auto& item : extensions) {
    if (item.key().size() > 128 || item.value().size() > bounds::kText) {
      faults.push_back({"extensions", "an entry is too long"});
      return;
    }
  }
}

}  // namespace

msg::HandoverRequest encode(const PlanRequest& request) {
  msg::HandoverRequest out;
  out.version(msg::WIRE_VERSION);
  out.request_id(request.id.bytes);
  out.client_id(request.client_id);
  out.cell(request.cell);
  out.task(request.task);
  out.object_name(request.object);
  out.has_goal(request.X_WO_goal.has_value());
  out.X_WO_goal(toWire(request.X_WO_goal.value_or(PoseValue{})));
  out.chain(request.chain);
  out.overrides(allToWire<msg::SceneOverride>(request.overrides));
  out.has_expected_revision(request.expected_revision.has_value());
  out.expected_revision(request.expected_revision.value_or(0));
  out.expected_hash(request.expected_hash);
  out.mode(static_cast<msg::SearchMode>(request.mode));
  out.search(static_cast<msg::SearchWidth>(request.search));
  out.objective(static_cast<msg::ObjectiveKind>(request.objective));
  out.seed(request.seed);
  out.has_deadline(request.deadline_s.has_value());
  out.deadline_s(request.deadline_s.value_or(0));
  out.speed_scale(request.speed_scale);
  out.slack_s(request.slack_s);
  out.wants_fix(request.wants_fix);
  return out;
}

Decoded<PlanRequest> decode(const msg::HandoverRequest& message) {
  Faults faults = versionFaults(message.version());
  checkExtensions(message.extensions(), faults);
  PlanRequest request;
  request.id.bytes = message.request_id();
  request.client_id = message.client_id();
  request.cell = message.cell();
  request.task = message.task();
  request.object = message.object_name();
  if (message.has_goal()) request.X_WO_goal = fromWire(message.X_WO_goal());
  request.chain = message.chain();
  request.overrides = allFromWire<Override>(message.overrides());
  if (message.has_expected_revision()) request.expected_revision = message.expected_revision();
  request.expected_hash = message.expected_hash();
  if (message.mode() != msg::MODE_UNSPECIFIED) {
    request.mode = static_cast<SearchMode>(message.mode());
  }
  if (message.search() != msg::SEARCH_UNSPECIFIED) {
    request.search = static_cast<SearchWidth>(message.search());
  }
  request.objective = static_cast<Objective>(message.objective());
  request.seed = message.seed();
  if (message.has_deadline()) request.deadline_s = message.deadline_s();
  request.speed_scale = message.speed_scale();
  request.slack_s = message.slack_s();
  request.wants_fix = message.wants_fix();
  return checked(std::move(request), std::move(faults));
}

msg::PlanEvent encode(const PlanEvent& event) {
  msg::PlanEvent out;
  out.version(msg::WIRE_VERSION);
  out.request_id(event.request_id.bytes);
  out.answer_id(event.answer_id);
  out.sequence_number(event.sequence);
  out.elapsed_s(event.elapsed_s);
  std::visit([&out](const auto& payload) { put(out.payload(), payload); }, event.payload);
  return out;
}

Decoded<PlanEvent> decode(const msg::PlanEvent& message) {
  Faults faults = versionFaults(message.version());
  checkExtensions(message.extensions(), faults);
  PlanEvent event;
  event.request_id.bytes = message.request_id();
  event.answer_id = message.answer_id();
  event.sequence = message.sequence_number();
  event.elapsed_s = message.elapsed_s();
  event.payload = payloadFromWire(message.payload(), faults);
  return checked(std::move(event), std::move(faults));
}

msg::DaemonStatus encode(const DaemonStatus& status) {
  msg::DaemonStatus out;
  out.version(msg::WIRE_VERSION);
  out.daemon_id(status.id);
  out.program_version(status.version);
  out.state(static_cast<msg::DaemonState>(status.state));
  for (const CellInfo& cell : status.cells) {
    auto& item = out.cells().emplace_back();
    item.name(cell.name);
    item.tasks(cell.tasks);
    item.scene_revision(cell.revision);
    item.scene_hash(cell.scene_hash);
    item.variations(allToWire<msg::Variation>(cell.variations));
  }
  out.queued(status.queued);
  out.running(status.running);
  out.accepted_count(status.counters.accepted);
  out.done_count(status.counters.done);
  out.failed_count(status.counters.failed);
  out.cancelled_count(status.counters.cancelled);
  out.rejected_count(status.counters.rejected);
  out.refused_count(status.refused);
  out.clients(status.clients);
  out.memory_bytes(status.memory_bytes);
  out.extensions(extensionsOf(status));
  return out;
}

Decoded<DaemonStatus> decode(const msg::DaemonStatus& message) {
  Faults faults = versionFaults(message.version());
  checkExtensions(message.extensions(), faults);
  DaemonStatus status;
  status.id = message.daemon_id();
  status.version = message.program_version();
  status.state = static_cast<DaemonState>(message.state());
  for (const auto& cell : message.cells()) {
    CellInfo& info = status.cells.emplace_back();
    info.name = cell.name();
    info.tasks = cell.tasks();
    info.revision = cell.scene_revision();
    info.scene_hash = cell.scene_hash();
    info.variations = allFromWire<Variation>(cell.variations());
  }
  status.queued = message.queued();
  status.running = message.running();
  status.counters = {message.accepted_count(), message.done_count(), message.failed_count(),
                     message.cancelled_count(), message.rejected_count()};
  status.refused = message.refused_count();
  status.clients = message.clients();
  status.memory_bytes = message.memory_bytes();
  takeExtensions(message.extensions(), status);
  return checked(std::move(status), std::move(faults));
}

msg::HandoverCancel encodeCancel(const RequestId& id) {
  msg::HandoverCancel out;
  out.version(msg::WIRE_VERSION);
  out.request_id(id.bytes);
  return out;
}

msg::Leader encode(const Claim& claim) {
  msg::Leader out;
  out.version(msg::WIRE_VERSION);
  out.cell_key(claim.cell);
  out.daemon_id(claim.daemon);
  out.epoch(claim.epoch);
  return out;
}

Decoded<Claim> decode(const msg::Leader& message) {
  Faults faults = versionFaults(message.version());
  checkExtensions(message.extensions(), faults);
  if (message.epoch() < 1 || message.epoch() > kMostEpoch) {
    faults.push_back({"epoch", "must be from 1 to " + std::to_string(kMostEpoch)});
  }
  if (!faults.empty()) return faults;
  return Claim{message.cell_key(), message.daemon_id(), message.epoch()};
}

Decoded<RequestId> decode(const msg::HandoverCancel& message) {
  Faults faults = versionFaults(message.version());
  checkExtensions(message.extensions(), faults);
  if (!faults.empty()) return faults;
  return RequestId{message.request_id()};
}

}  // namespace handover::wire
