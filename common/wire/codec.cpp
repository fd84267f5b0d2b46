// SPDX-License-Identifier: Apache-2.0
#include "wire/codec.hpp"

#include <iterator>

namespace handover::wire {
namespace {

using Faults = std::vector<Fault>;

// Enumerations are numbered alike on both sides; the ends and one in the middle pin it down.
static_assert(static_cast<int>(StageKind::kGiverReach) == msg::STAGE_GIVER_REACH);
static_assert(static_cast<int>(StageKind::kReceiverGrasp) == msg::STAGE_RECEIVER_GRASP);
static_assert(static_cast<int>(StageKind::kReceiverRetreat) == msg::STAGE_RECEIVER_RETREAT);
static_assert(static_cast<int>(FailureReason::kStartUnreachable) == msg::REASON_START_UNREACHABLE);
static_assert(static_cast<int>(FailureReason::kNoHandoverPose) == msg::REASON_NO_HANDOVER_POSE);
static_assert(static_cast<int>(FailureReason::kInternal) == msg::REASON_INTERNAL);
static_assert(static_cast<int>(DaemonState::kStopping) == msg::DAEMON_STOPPING);

constexpr std::pair<msg::RejectReason, const char*> kRejections[] = {
    {msg::REJECT_BAD_REQUEST, "bad_request"},
    {msg::REJECT_UNKNOWN_CELL, "unknown_cell"},
    {msg::REJECT_BUSY, "busy"},
    {msg::REJECT_SCENE_CHANGED, "scene_changed"}};

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

msg::RejectCount toWire(const RejectCount& reject) {
  msg::RejectCount out;
  out.cause(reject.cause);
  out.pair(toWire(reject.pair));
  out.hits(reject.count);
  return out;
}

RejectCount fromWire(const msg::RejectCount& reject) {
  return {reject.cause(), fromWire(reject.pair()), reject.hits()};
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

msg::CellVariation toWire(const Variation& variation) {
  msg::CellVariation out;
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

Variation fromWire(const msg::CellVariation& variation) {
  Variation out;
  out.path = variation.path();
  out.from = variation.low();
  out.to = variation.high();
  out.choices = variation.choices();
  if (variation.has_facing()) out.facing = {variation.facing_x(), variation.facing_y()};
  return out;
}

msg::RobotState toWire(const RobotSnapshot& robot);
msg::ObjectState toWire(const ObjectSnapshot& object);
RobotSnapshot fromWire(const msg::RobotState& robot);

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
      faults.push_back({field + ".kind", "is not a kind of geometry"});
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

msg::RobotState toWire(const RobotSnapshot& robot) {
  msg::RobotState out;
  out.name(robot.name);
  out.urdf(robot.urdf);
  out.urdf_sha256(robot.urdf_sha256);
  out.srdf(robot.srdf);
  out.X_WB(toWire(robot.X_WB));
  for (const auto& [joint, position] : robot.q_start) {
    auto& value = out.q_start().emplace_back();
    value.joint(joint);
    value.position(position);
  }
  for (const auto& [joint, limits] : robot.limits) {
    auto& limit = out.limits().emplace_back();
    limit.joint(joint);
    limit.lower(limits.lower);
    limit.upper(limits.upper);
    limit.velocity(limits.velocity);
    limit.acceleration(limits.acceleration);
  }
  out.resting(allToWire<msg::NamePair>(robot.resting));
  return out;
}

RobotSnapshot fromWire(const msg::RobotState& robot) {
  RobotSnapshot out;
  out.name = robot.name();
  out.urdf = robot.urdf();
  out.urdf_sha256 = robot.urdf_sha256();
  out.srdf = robot.srdf();
  out.X_WB = fromWire(robot.X_WB());
  for (const auto& value : robot.q_start()) {
    out.q_start.emplace_back(value.joint(), value.position());
  }
  for (const auto& limit : robot.limits()) {
    out.limits.emplace_back(limit.joint(), JointLimits{limit.lower(), limit.upper(),
                                                       limit.velocity(), limit.acceleration()});
  }
  out.resting = allFromWire<NamePair>(robot.resting());
  return out;
}

msg::ObjectState toWire(const ObjectSnapshot& object) {
  msg::ObjectState out;
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

ObjectSnapshot objectFromWire(const msg::ObjectState& object, Faults& faults) {
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

// Payloads.

void put(msg::PlanEventPayload& out, const Accepted& accepted) {
  msg::Accepted value;
  value.queue_place(accepted.queue_place);
  value.scene_revision(accepted.scene_revision);
  out.accepted_value(std::move(value));
}

Accepted fromWire(const msg::Accepted& value) {
  return {value.queue_place(), value.scene_revision()};
}

void put(msg::PlanEventPayload& out, const SceneSnapshot& scene) {
  msg::SceneSnapshot value;
  value.cell(scene.cell);
  value.task(scene.task);
  value.seed(scene.seed);
  value.scene_hash(scene.scene_hash);
  value.object_name(scene.object);
  value.giver(scene.giver);
  value.receiver(scene.receiver);
  value.X_WO_start(toWire(scene.X_WO_start));
  value.X_WO_goal(toWire(scene.X_WO_goal));
  value.robots(allToWire<msg::RobotState>(scene.robots));
  value.objects(allToWire<msg::ObjectState>(scene.objects));
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
  scene.giver = value.giver();
  scene.receiver = value.receiver();
  scene.X_WO_start = fromWire(value.X_WO_start());
  scene.X_WO_goal = fromWire(value.X_WO_goal());
  scene.robots = allFromWire<RobotSnapshot>(value.robots());
  for (const auto& object : value.objects()) {
    scene.objects.push_back(objectFromWire(object, faults));
  }
  return scene;
}

void put(msg::PlanEventPayload& out, const ArmSelected& arms) {
  msg::ArmSelected value;
  value.giver_arm(arms.giver_arm);
  value.receiver_arm(arms.receiver_arm);
  for (const ArmScore& score : arms.scores) {
    auto& item = value.scores().emplace_back();
    item.robot(score.robot);
    item.arm(score.arm);
    item.manipulability(score.manipulability);
    item.rejected(score.rejected);
  }
  out.arm_selected_value(std::move(value));
}

ArmSelected fromWire(const msg::ArmSelected& value) {
  ArmSelected arms{value.giver_arm(), value.receiver_arm(), {}};
  for (const auto& s : value.scores()) {
    arms.scores.push_back({s.robot(), s.arm(), s.manipulability(), s.rejected()});
  }
  return arms;
}

void put(msg::PlanEventPayload& out, const GraspsPruned& pruned) {
  msg::GraspsPruned value;
  value.robot(pruned.robot);
  value.arm(pruned.arm);
  value.tested(pruned.tested);
  value.kept(pruned.kept);
  value.rejects(allToWire<msg::RejectCount>(pruned.rejects));
  out.grasps_pruned_value(std::move(value));
}

GraspsPruned fromWire(const msg::GraspsPruned& value) {
  return {value.robot(), value.arm(), value.tested(), value.kept(),
          allFromWire<RejectCount>(value.rejects())};
}

void put(msg::PlanEventPayload& out, const HandoverCandidates& candidates) {
  msg::HandoverCandidates value;
  value.giver_arm(candidates.giver_arm);
  value.receiver_arm(candidates.receiver_arm);
  value.voxels(candidates.voxels);
  value.poses_tried(candidates.poses_tried);
  value.poses(candidates.poses);
  value.tuples(candidates.tuples);
  value.rejects(allToWire<msg::RejectCount>(candidates.rejects));
  value.lattice(allToWire<msg::LatticeCell>(candidates.lattice));
  out.handover_candidates_value(std::move(value));
}

HandoverCandidates fromWire(const msg::HandoverCandidates& value) {
  return {value.giver_arm(),
          value.receiver_arm(),
          value.voxels(),
          value.poses_tried(),
          value.poses(),
          value.tuples(),
          allFromWire<RejectCount>(value.rejects()),
          allFromWire<LatticeCell>(value.lattice())};
}

void put(msg::PlanEventPayload& out, const Solution& solution) {
  msg::Solution value;
  value.index(solution.index);
  value.giver_arm(solution.giver_arm);
  value.receiver_arm(solution.receiver_arm);
  value.giver_tool_link(solution.giver_tool_link);
  value.receiver_tool_link(solution.receiver_tool_link);
  value.giver_grasp(solution.giver_grasp);
  value.receiver_grasp(solution.receiver_grasp);
  value.X_WO_handover(toWire(solution.X_WO_handover));
  value.X_OT_giver(toWire(solution.X_OT_giver));
  value.X_OT_receiver(toWire(solution.X_OT_receiver));
  value.dexterity_receiver_place(solution.dexterity.receiver_place);
  value.dexterity_receiver_handover(solution.dexterity.receiver_handover);
  value.dexterity_giver_pick(solution.dexterity.giver_pick);
  value.dexterity_giver_handover(solution.dexterity.giver_handover);
  out.solution_value(std::move(value));
}

Solution fromWire(const msg::Solution& value) {
  Solution solution;
  solution.index = value.index();
  solution.giver_arm = value.giver_arm();
  solution.receiver_arm = value.receiver_arm();
  solution.giver_tool_link = value.giver_tool_link();
  solution.receiver_tool_link = value.receiver_tool_link();
  solution.giver_grasp = value.giver_grasp();
  solution.receiver_grasp = value.receiver_grasp();
  solution.X_WO_handover = fromWire(value.X_WO_handover());
  solution.X_OT_giver = fromWire(value.X_OT_giver());
  solution.X_OT_receiver = fromWire(value.X_OT_receiver());
  solution.dexterity = {value.dexterity_receiver_place(), value.dexterity_receiver_handover(),
                        value.dexterity_giver_pick(), value.dexterity_giver_handover()};
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
  msg::Trajectory value;
  value.solution(stage.solution);
  value.index(stage.index);
  value.kind(static_cast<msg::StageKind>(stage.kind));
  value.robot(stage.robot);
  value.joints(stage.joints);
  value.start(stage.start);
  value.t(stage.t);
  value.q(flatten(stage.q));
  value.qd(flatten(stage.qd));
  for (const Hold& hold : stage.holding) {
    auto& item = value.holding().emplace_back();
    item.object_name(hold.object);
    item.robot(hold.robot);
    item.link(hold.link);
    item.X_LO(toWire(hold.X_LO));
  }
  value.may_touch(allToWire<msg::NamePair>(stage.may_touch));
  out.trajectory_value(std::move(value));
}

StageTrajectory trajectoryFromWire(const msg::Trajectory& value, Faults& faults) {
  StageTrajectory stage;
  stage.solution = value.solution();
  stage.index = value.index();
  stage.kind = static_cast<StageKind>(value.kind());
  stage.robot = value.robot();
  stage.joints = value.joints();
  stage.start = value.start();
  stage.t = value.t();
  stage.q = rowsOf(value.q(), value.t().size(), value.joints().size(), "trajectory.q", faults);
  stage.qd = rowsOf(value.qd(), value.t().size(), value.joints().size(), "trajectory.qd", faults);
  for (const auto& hold : value.holding()) {
    stage.holding.push_back({hold.object_name(), hold.robot(), hold.link(), fromWire(hold.X_LO())});
  }
  stage.may_touch = allFromWire<NamePair>(value.may_touch());
  return stage;
}

msg::Explanation toWire(const Explanation& why) {
  msg::Explanation out;
  out.filter(why.filter);
  out.text(why.text);
  out.causes(allToWire<msg::RejectCount>(why.causes));
  out.nearest_fix(allToWire<msg::SceneOverride>(why.nearest_fix));
  out.fix_text(why.fix_text);
  return out;
}

Explanation fromWire(const msg::Explanation& why) {
  return {why.filter(), why.text(), allFromWire<RejectCount>(why.causes()),
          allFromWire<Override>(why.nearest_fix()), why.fix_text()};
}

void put(msg::PlanEventPayload& out, const Outcome& outcome) {
  msg::Outcome value;
  if (const auto* done = std::get_if<Done>(&outcome)) {
    value.kind(msg::OUTCOME_DONE);
    value.solution(done->solution);
    value.complete(done->complete);
  } else if (const auto* failed = std::get_if<Failed>(&outcome)) {
    value.kind(msg::OUTCOME_FAILED);
    value.failure(static_cast<msg::FailureReason>(failed->reason));
    value.why(toWire(failed->explanation));
  } else if (std::holds_alternative<Cancelled>(outcome)) {
    value.kind(msg::OUTCOME_CANCELLED);
  } else if (const auto* rejected = std::get_if<Rejected>(&outcome)) {
    value.kind(msg::OUTCOME_REJECTED);
    for (const auto& [reason, text] : kRejections) {
      if (rejected->reason == text) value.rejection(reason);
    }
    for (const Fault& fault : rejected->faults) {
      auto& item = value.faults().emplace_back();
      item.field(fault.field);
      item.message(fault.message);
    }
  }
  out.outcome_value(std::move(value));
}

Outcome outcomeFromWire(const msg::Outcome& value, Faults& faults) {
  switch (value.kind()) {
    case msg::OUTCOME_DONE:
      return Done{value.solution(), value.complete()};
    case msg::OUTCOME_FAILED:
      return Failed{static_cast<FailureReason>(value.failure()), fromWire(value.why())};
    case msg::OUTCOME_CANCELLED:
      return Cancelled{};
    case msg::OUTCOME_REJECTED: {
      Rejected rejected;
      for (const auto& [reason, text] : kRejections) {
        if (value.rejection() == reason) rejected.reason = text;
      }
      for (const auto& fault : value.faults()) {
        rejected.faults.push_back({fault.field(), fault.message()});
      }
      return rejected;
    }
    default:
      faults.push_back({"outcome.kind", "is not an outcome"});
  }
  return Cancelled{};
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
      return fromWire(payload.solution_value());
    case msg::PAYLOAD_TRAJECTORY:
      return trajectoryFromWire(payload.trajectory_value(), faults);
    case msg::PAYLOAD_OUTCOME:
      return outcomeFromWire(payload.outcome_value(), faults);
    default:
      faults.push_back({"payload", "is not a payload"});
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
  out.giver(request.giver);
  out.receiver(request.receiver);
  out.giver_arm(request.giver_arm);
  out.receiver_arm(request.receiver_arm);
  out.overrides(allToWire<msg::SceneOverride>(request.overrides));
  out.has_expected_revision(request.expected_revision.has_value());
  out.expected_revision(request.expected_revision.value_or(0));
  switch (request.mode) {
    case SearchMode::kFirst:
      out.mode(msg::MODE_FIRST);
      break;
    case SearchMode::kBest:
      out.mode(msg::MODE_BEST);
      break;
    case SearchMode::kAll:
      out.mode(msg::MODE_ALL);
      break;
  }
  switch (request.search) {
    case SearchWidth::kPaper:
      out.search(msg::SEARCH_PAPER);
      break;
    case SearchWidth::kWide:
      out.search(msg::SEARCH_WIDE);
      break;
  }
  out.seed(request.seed);
  out.has_deadline(request.deadline_s.has_value());
  out.deadline_s(request.deadline_s.value_or(0));
  out.speed_scale(request.speed_scale);
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
  request.giver = message.giver();
  request.receiver = message.receiver();
  request.giver_arm = message.giver_arm();
  request.receiver_arm = message.receiver_arm();
  request.overrides = allFromWire<Override>(message.overrides());
  if (message.has_expected_revision()) request.expected_revision = message.expected_revision();
  switch (message.mode()) {
    case msg::MODE_FIRST:
      request.mode = SearchMode::kFirst;
      break;
    case msg::MODE_UNSPECIFIED:
    case msg::MODE_BEST:
      request.mode = SearchMode::kBest;
      break;
    case msg::MODE_ALL:
      request.mode = SearchMode::kAll;
      break;
    default:
      faults.push_back({"mode", "is not a mode"});
  }
  switch (message.search()) {
    case msg::SEARCH_PAPER:
      request.search = SearchWidth::kPaper;
      break;
    case msg::SEARCH_UNSPECIFIED:
    case msg::SEARCH_WIDE:
      request.search = SearchWidth::kWide;
      break;
    default:
      faults.push_back({"search", "is not a search"});
  }
  request.seed = message.seed();
  if (message.has_deadline()) request.deadline_s = message.deadline_s();
  request.speed_scale = message.speed_scale();
  return checked(std::move(request), std::move(faults));
}

msg::PlanEvent encode(const PlanEvent& stage) {
  msg::PlanEvent out;
  out.version(msg::WIRE_VERSION);
  out.request_id(stage.request_id.bytes);
  out.sequence_number(stage.sequence);
  out.elapsed_s(stage.elapsed_s);
  std::visit([&out](const auto& payload) { put(out.payload(), payload); }, stage.payload);
  return out;
}

Decoded<PlanEvent> decode(const msg::PlanEvent& message) {
  Faults faults = versionFaults(message.version());
  checkExtensions(message.extensions(), faults);
  PlanEvent stage;
  stage.request_id.bytes = message.request_id();
  stage.sequence = message.sequence_number();
  stage.elapsed_s = message.elapsed_s();
  stage.payload = payloadFromWire(message.payload(), faults);
  return checked(std::move(stage), std::move(faults));
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
    item.variations(allToWire<msg::CellVariation>(cell.variations));
  }
  out.queued(status.queued);
  out.running(status.running);
  out.accepted_count(status.counters.accepted);
  out.done_count(status.counters.done);
  out.failed_count(status.counters.failed);
  out.cancelled_count(status.counters.cancelled);
  out.rejected_count(status.counters.rejected);
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
    info.variations = allFromWire<Variation>(cell.variations());
  }
  status.queued = message.queued();
  status.running = message.running();
  status.counters = {message.accepted_count(), message.done_count(), message.failed_count(),
                     message.cancelled_count(), message.rejected_count()};
  return checked(std::move(status), std::move(faults));
}

msg::HandoverCancel encodeCancel(const RequestId& id) {
  msg::HandoverCancel out;
  out.version(msg::WIRE_VERSION);
  out.request_id(id.bytes);
  return out;
}

Decoded<RequestId> decode(const msg::HandoverCancel& message) {
  Faults faults = versionFaults(message.version());
  checkExtensions(message.extensions(), faults);
  if (!faults.empty()) return faults;
  return RequestId{message.request_id()};
}

}  // namespace handover::wire
