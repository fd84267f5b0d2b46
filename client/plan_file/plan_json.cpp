// SPDX-License-Identifier: Apache-2.0
#include "plan_file/plan_json.hpp"

namespace handover::client {
namespace {

Json toJson(const PoseValue& X) { return {{"xyz", X.xyz}, {"quat_wxyz", X.quat_wxyz}}; }

Json toJson(const NamePair& pair) { return Json::array({pair.first, pair.second}); }

std::string nameOf(const ArmName& name) {
  return name.arm.empty() ? name.robot : name.robot + "/" + name.arm;
}

Json toJson(const ArmName& name) { return nameOf(name); }

Json toJson(const Override& change) { return {{"path", change.path}, {"value", change.value}}; }

Json toJson(const Fault& fault) { return {{"field", fault.field}, {"message", fault.message}}; }

Json toJson(const StageRef& ref) {
  return {{"holder", ref.holder}, {"action", toString(ref.action)}};
}

Json toJson(const StageProgress& progress) {
  return Json::array({Json(progress.stage), Json(progress.progress)});
}

Json toJson(const Hold& hold) {
  return {{"object", hold.object},
          {"robot", hold.robot},
          {"link", hold.link},
          {"X_LO", toJson(hold.X_LO)}};
}

/// A single thing that a cause speaks of is no pair: it stands in `about`.
Json toJson(const CauseCount& cause) {
  const auto& [first, second] = cause.pair;
  const bool pair = !first.empty() && !second.empty();
  Json json = {{"cause", toString(cause.cause)},
               {"pair", pair ? toJson(cause.pair) : Json()},
               {"count", cause.count}};
  if (!pair && !(first + second).empty()) {
    json["about"] = first + second;
  } else if (sumsOtherPairs(cause)) {
    json["about"] = kOtherPairs;
  }
  if (cause.stage) json["stage"] = toJson(*cause.stage);
  return json;
}

Json toJson(const FarthestTool& tool) {
  return {{"robot", tool.arm.robot}, {"arm", tool.arm.arm}, {"X_WT", toJson(tool.X_WT)}};
}

Json toJson(const ArmScore& score) {
  Json json = {{"robot", score.arm.robot},
               {"arm", score.arm.arm},
               {"holder", score.holder},
               {"manipulability", score.manipulability}};
  if (score.rejected != Cause::kUnspecified) json["rejected"] = toString(score.rejected);
  if (!score.object.empty()) json["object"] = score.object;
  return json;
}

Json toJson(const ReachSlice& slice) {
  return {{"robot", slice.arm.robot}, {"arm", slice.arm.arm},     {"tool_link", slice.tool_link},
          {"first", slice.first},     {"columns", slice.columns}, {"scores", slice.scores}};
}

Json toJson(const LatticeCell& cell) { return {{"centre", cell.centre}, {"score", cell.score}}; }

Json toJson(const ClearanceQuality& clearance) {
  return {{"between", clearance.between},
          {"least_m", clearance.least_m},
          {"stage", clearance.stage},
          {"pair", clearance.pair == NamePair{} ? Json() : toJson(clearance.pair)}};
}

Json toJson(const GripQuality& grip) {
  return {{"holder", grip.holder}, {"quality", grip.quality}, {"of_best", grip.of_best}};
}

Json toJson(const std::vector<std::pair<std::string, double>>& numbers) {
  Json json = Json::object();
  for (const auto& [name, value] : numbers) json[name] = value;
  return json;
}

Json toJson(const Geometry& geometry) {
  if (const auto* box = std::get_if<BoxGeometry>(&geometry)) {
    return {{"type", "box"}, {"size", box->size}};
  }
  if (const auto* sphere = std::get_if<SphereGeometry>(&geometry)) {
    return {{"type", "sphere"}, {"radius", sphere->radius}};
  }
  if (const auto* cylinder = std::get_if<CylinderGeometry>(&geometry)) {
    return {{"type", "cylinder"}, {"radius", cylinder->radius}, {"length", cylinder->length}};
  }
  if (const auto* mesh = std::get_if<MeshGeometry>(&geometry)) {
    return {{"type", "mesh"}, {"path", mesh->path}, {"scale", mesh->scale}};
  }
  Json parts = Json::array();
  for (const auto& part : std::get<CompoundGeometry>(geometry).parts) {
    parts.push_back({{"X_OS", toJson(part.X_OS)}, {"geometry", toJson(part.geometry)}});
  }
  return {{"type", "compound"}, {"parts", std::move(parts)}};
}

Json bound(const std::optional<double>& limit) { return limit ? Json(*limit) : Json(); }

Json toJson(const RobotSnapshot& robot);
Json toJson(const ObjectSnapshot& object);
Json toJson(const Holder& holder);

// Those of the header too: the names are looked up at the template.
using client::toJson;

template <typename T>
Json listOf(const std::vector<T>& items) {
  Json list = Json::array();
  for (const T& item : items) list.push_back(toJson(item));
  return list;
}

Json toJson(const RobotSnapshot& robot) {
  Json limits = Json::object();
  for (const auto& [joint, l] : robot.limits) {
    limits[joint] = Json::array(
        {bound(l.lower), bound(l.upper), Json(l.velocity), Json(l.acceleration), Json(l.jerk)});
  }
  return {{"name", robot.name},
          {"urdf", robot.urdf},
          {"urdf_sha256", robot.urdf_sha256},
          {"srdf", robot.srdf},
          {"yaml", robot.yaml},
          {"yaml_sha256", robot.yaml_sha256},
          {"X_WB", toJson(robot.X_WB)},
          {"q_start", toJson(robot.q_start)},
          {"limits", std::move(limits)},
          {"resting", listOf(robot.resting)}};
}

Json toJson(const ObjectSnapshot& object) {
  Json attached;
  if (object.attached_to) {
    attached = {{"robot", object.attached_to->robot},
                {"link", object.attached_to->link},
                {"X_LO", toJson(object.attached_to->X_LO)},
                {"touch_links", object.attached_to->touch_links}};
  }
  return {{"name", object.name},
          {"geometry", toJson(object.geometry)},
          {"X_WO", toJson(object.X_WO)},
          {"attached_to", std::move(attached)},
          {"resting", object.resting}};
}

Json toJson(const RestSnapshot& rest) { return rest.none ? Json("none") : Json(rest.objects); }

Json handOf(const GripperSnapshot& gripper) {
  if (const auto* cup = std::get_if<SuctionGripper>(&gripper)) {
    return {{"cup_link", cup->cup_link}, {"axis", cup->axis}, {"radius", cup->radius}};
  }
  const auto& hand = std::get<FingerGripper>(gripper);
  return {{"palm", hand.palm_link}, {"fingers", hand.finger_links}};
}

Json toJson(const Holder& holder) {
  const bool fingers = std::holds_alternative<FingerGripper>(holder.gripper);
  return {{"robot", holder.arm.robot},
          {"arm", holder.arm.arm},
          {"tool_link", holder.tool_link},
          {"gripper", fingers ? "fingers" : "suction"},
          {"hand", handOf(holder.gripper)},
          {"X_OT", toJson(holder.X_OT)},
          {"dexterity", {{"take", holder.dexterity.take}, {"give", holder.dexterity.give}}}};
}

Json farthestOf(const std::optional<Farthest>& farthest) {
  if (!farthest) return nullptr;
  return {{"X_WO", toJson(farthest->X_WO)},
          {"tools", listOf(farthest->tools)},
          {"stage", toJson(farthest->stage)}};
}

}  // namespace

bool sumsOtherPairs(const CauseCount& cause) {
  const bool collision = cause.cause == Cause::kCollision || cause.cause == Cause::kSelfCollision;
  return collision && cause.pair.first.empty() && cause.pair.second.empty();
}

Json toJson(const SceneSnapshot& scene) {
  Json upright;
  if (scene.upright) {
    upright = {{"axis", scene.upright->axis}, {"within_deg", scene.upright->within_deg}};
  }
  const auto& [start, goal] = std::tie(scene.start, scene.goal);
  return {{"cell", scene.cell},
          {"task", scene.task},
          {"seed", scene.seed},
          {"scene_hash", scene.scene_hash},
          {"object", scene.object},
          {"robots", listOf(scene.robots)},
          {"objects", listOf(scene.objects)},
          {"start",
           {{"X_WO", toJson(start.X_WO)},
            {"held_by", start.held_by ? toJson(*start.held_by) : Json()},
            {"rest", toJson(start.rest)}}},
          {"goal",
           {{"X_WO", toJson(goal.X_WO)}, {"end", toString(goal.end)}, {"rest", toJson(goal.rest)}}},
          {"upright", std::move(upright)}};
}

Json toJson(const Quality& quality) {
  return {{"duration_s", quality.duration_s},
          {"bound_s", quality.bound_s},
          {"object_s", quality.object_s},
          {"idle_s", toJson(quality.idle_s)},
          {"clearance", listOf(quality.clearance)},
          {"tilt_deg", quality.tilt_deg},
          {"object_turn_deg", quality.object_turn_deg},
          {"limit_margin", quality.limit_margin},
          {"grip", listOf(quality.grip)},
          {"jerk_share", quality.jerk_share},
          {"cost", quality.cost},
          {"terms", toJson(quality.terms)}};
}

Json toJson(const Failure& failure) {
  const Explanation& why = failure.explanation;
  Json causes = listOf(why.causes);
  if (causes.empty()) {
    causes.push_back({{"cause", toString(failure.reason)}, {"pair", nullptr}, {"count", 1}});
  }
  return {{"reason", toString(failure.reason)},
          {"text", why.text},
          {"filter", why.filter},
          {"exhaustive", why.exhaustive},
          {"causes", std::move(causes)},
          {"nearest_fix", why.nearest_fix.empty() ? Json() : listOf(why.nearest_fix)},
          {"fix_text", why.fix_text},
          {"farthest", farthestOf(why.farthest)}};
}

Json planJson(const Solution& solution, const std::vector<const StageTrajectory*>& stages) {
  Json list = Json::array();
  for (const StageTrajectory* stage : stages) list.push_back(toJson(*stage));
  return {{"holders", listOf(solution.holders)},
          {"handovers", listOf(solution.X_WO_handovers)},
          {"stages", std::move(list)},
          {"slack_s", solution.slack_s}};
}

Json toJson(const Accepted& accepted) {
  return {{"daemon_id", RequestId{accepted.daemon_id}.hex()},
          {"epoch", accepted.epoch},
          {"program_version", accepted.program_version},
          {"scene_revision", accepted.scene_revision},
          {"scene_hash", accepted.scene_hash},
          {"queue_place", accepted.queue_place}};
}

Json toJson(const ArmSelected& arms) {
  return {{"holders", listOf(arms.holders)}, {"scores", listOf(arms.scores)}};
}

Json toJson(const GraspsPruned& pruned) {
  return {
      {"arm", toJson(pruned.arm)}, {"holder", pruned.holder}, {"place", toString(pruned.place)},
      {"tested", pruned.tested},   {"kept", pruned.kept},     {"causes", listOf(pruned.causes)}};
}

Json toJson(const HandoverCandidates& candidates) {
  return {{"handover", candidates.handover},
          {"giver", toJson(candidates.giver)},
          {"receiver", toJson(candidates.receiver)},
          {"lattice_points", candidates.lattice_points},
          {"poses_tried", candidates.poses_tried},
          {"poses", candidates.poses},
          {"receiver_grasps", candidates.receiver_grasps},
          {"tuples", candidates.tuples},
          {"causes", listOf(candidates.causes)},
          {"lattice", listOf(candidates.lattice)}};
}

Json toJson(const Solution& solution) {
  Json grasps = Json::array();
  for (const Holder& holder : solution.holders) grasps.push_back(holder.grasp);
  return {{"index", solution.index},
          {"holders", listOf(solution.holders)},
          {"grasps", std::move(grasps)},
          {"handovers", listOf(solution.X_WO_handovers)},
          {"stage_count", solution.stage_count},
          {"slack_s", solution.slack_s},
          {"cost", solution.cost},
          {"quality", solution.quality ? toJson(*solution.quality) : Json()}};
}

Json toJson(const StageTrajectory& stage) {
  return {{"index", stage.index},
          {"holder", stage.holder},
          {"action", toString(stage.action)},
          {"robot", stage.robot},
          {"joints", stage.joints},
          {"start", stage.start},
          {"t", stage.t},
          {"q", stage.q},
          {"qd", stage.qd},
          {"qdd", stage.qdd},
          {"holding", listOf(stage.holding)},
          {"may_touch", listOf(stage.may_touch)},
          {"after", listOf(stage.after)}};
}

Json toJson(const Note& note) { return {{"code", note.code}, {"text", note.text}}; }

Json toJson(const Fix& fix) { return {{"overrides", listOf(fix.overrides)}, {"text", fix.text}}; }

Json toJson(const Workspaces& workspaces) {
  return {{"z", workspaces.z}, {"edge", kLatticeEdge}, {"slices", listOf(workspaces.slices)}};
}

Json toJson(const Outcome& outcome) {
  if (const auto* done = std::get_if<Done>(&outcome)) {
    return {{"outcome", "done"}, {"solution", done->solution}, {"complete", done->complete}};
  }
  if (const auto* failed = std::get_if<Failed>(&outcome)) {
    return {{"outcome", "failed"},
            {"reason", toString(failed->reason)},
            {"exhaustive", failed->explanation.exhaustive},
            {"explanation", toJson(Failure{failed->reason, failed->explanation})}};
  }
  if (const auto* rejected = std::get_if<Rejected>(&outcome)) {
    return {{"outcome", "rejected"},
            {"reason", toString(rejected->reason)},
            {"faults", listOf(rejected->faults)}};
  }
  return {{"outcome", "cancelled"}, {"cause", toString(std::get<Cancelled>(outcome).cause)}};
}

}  // namespace handover::client
