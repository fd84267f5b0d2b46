// SPDX-License-Identifier: Apache-2.0
#include "json_writer.hpp"

#include <handover/client/plan_file.hpp>

#include <algorithm>
#include <stdexcept>

namespace handover::client {
namespace {

Json toJson(const PoseValue& X) { return {{"xyz", X.xyz}, {"quat_wxyz", X.quat_wxyz}}; }

Json toJson(const NamePair& pair) { return Json::array({pair.first, pair.second}); }

// Named before the template that calls them: the names are looked up there.
Json toJson(const RobotSnapshot& robot);
Json toJson(const ObjectSnapshot& object);
Json toJson(const Hold& hold);
Json toJson(const RejectCount& reject);
Json toJson(const ArmScore& score);
Json toJson(const ArmSelected& arms);
Json toJson(const GraspsPruned& pruned);
Json toJson(const HandoverCandidates& candidates);
Json toJson(const Override& change);
Json toJson(const Fault& fault);

template <typename T>
Json listOf(const std::vector<T>& items) {
  Json list = Json::array();
  for (const T& item : items) list.push_back(toJson(item));
  return list;
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

Json toJson(const RobotSnapshot& robot) {
  Json q_start = Json::object();
  for (const auto& [joint, position] : robot.q_start) q_start[joint] = position;
  Json limits = Json::object();
  for (const auto& [joint, l] : robot.limits) {
    limits[joint] = {l.lower, l.upper, l.velocity, l.acceleration};
  }
  return {{"name", robot.name},
          {"urdf", robot.urdf},
          {"urdf_sha256", robot.urdf_sha256},
          {"srdf", robot.srdf},
          {"X_WB", toJson(robot.X_WB)},
          {"q_start", std::move(q_start)},
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

Json toJson(const Hold& hold) {
  return {{"object", hold.object},
          {"robot", hold.robot},
          {"link", hold.link},
          {"X_LO", toJson(hold.X_LO)}};
}

Json toJson(const StageTrajectory& stage) {
  return {{"index", stage.index},
          {"kind", toString(stage.kind)},
          {"robot", stage.robot},
          {"joints", stage.joints},
          {"start", stage.start},
          {"t", stage.t},
          {"q", stage.q},
          {"qd", stage.qd},
          {"holding", listOf(stage.holding)},
          {"may_touch", listOf(stage.may_touch)}};
}

Json toJson(const Dexterity& dexterity) {
  return {{"receiver_place", dexterity.receiver_place},
          {"receiver_handover", dexterity.receiver_handover},
          {"giver_pick", dexterity.giver_pick},
          {"giver_handover", dexterity.giver_handover}};
}

Json toJson(const RejectCount& reject) {
  Json json = {{"cause", reject.cause}};
  if (reject.pair != NamePair{}) json["pair"] = toJson(reject.pair);
  json["count"] = reject.count;
  return json;
}

Json toJson(const ArmScore& score) {
  Json json = {
      {"robot", score.robot}, {"arm", score.arm}, {"manipulability", score.manipulability}};
  if (!score.rejected.empty()) json["rejected"] = score.rejected;
  return json;
}

Json toJson(const ArmSelected& arms) {
  return {{"giver_arm", arms.giver_arm},
          {"receiver_arm", arms.receiver_arm},
          {"scores", listOf(arms.scores)}};
}

Json toJson(const GraspsPruned& pruned) {
  return {{"robot", pruned.robot},
          {"arm", pruned.arm},
          {"tested", pruned.tested},
          {"kept", pruned.kept},
          {"rejects", listOf(pruned.rejects)}};
}

Json toJson(const HandoverCandidates& candidates) {
  return {{"giver_arm", candidates.giver_arm},
          {"receiver_arm", candidates.receiver_arm},
          {"voxels", candidates.voxels},
          {"poses_tried", candidates.poses_tried},
          {"poses", candidates.poses},
          {"tuples", candidates.tuples},
          {"rejects", listOf(candidates.rejects)}};
}

Json toJson(const Accepted& accepted) {
  return {{"queue_place", accepted.queue_place}, {"scene_revision", accepted.scene_revision}};
}

Json toJson(const SceneSnapshot& scene) {
  return {{"cell", scene.cell},
          {"task", scene.task},
          {"seed", scene.seed},
          {"scene_hash", scene.scene_hash},
          {"object", scene.object},
          {"giver", scene.giver},
          {"receiver", scene.receiver},
          {"X_WO_start", toJson(scene.X_WO_start)},
          {"X_WO_goal", toJson(scene.X_WO_goal)},
          {"robots", listOf(scene.robots)},
          {"objects", listOf(scene.objects)}};
}

Json toJson(const Solution& solution) {
  return {{"index", solution.index},
          {"giver_arm", solution.giver_arm},
          {"receiver_arm", solution.receiver_arm},
          {"giver_tool_link", solution.giver_tool_link},
          {"receiver_tool_link", solution.receiver_tool_link},
          {"giver_grasp", solution.giver_grasp},
          {"receiver_grasp", solution.receiver_grasp},
          {"X_WO_handover", toJson(solution.X_WO_handover)},
          {"X_OT_giver", toJson(solution.X_OT_giver)},
          {"X_OT_receiver", toJson(solution.X_OT_receiver)},
          {"dexterity", toJson(solution.dexterity)}};
}

Json toJson(const Override& change) { return {{"path", change.path}, {"value", change.value}}; }

Json toJson(const Explanation& why) {
  return {{"filter", why.filter},
          {"text", why.text},
          {"causes", listOf(why.causes)},
          {"nearest_fix", why.nearest_fix.empty() ? Json() : listOf(why.nearest_fix)},
          {"fix_text", why.fix_text}};
}

Json toJson(const Fault& fault) { return {{"field", fault.field}, {"message", fault.message}}; }

Json toJson(const Outcome& outcome) {
  if (const auto* done = std::get_if<Done>(&outcome)) {
    return {{"outcome", "done"}, {"solution", done->solution}, {"complete", done->complete}};
  }
  if (const auto* failed = std::get_if<Failed>(&outcome)) {
    return {{"outcome", "failed"},
            {"reason", toString(failed->reason)},
            {"explanation", toJson(failed->explanation)}};
  }
  if (const auto* rejected = std::get_if<Rejected>(&outcome)) {
    return {{"outcome", "rejected"},
            {"reason", rejected->reason},
            {"faults", listOf(rejected->faults)}};
  }
  return {{"outcome", "cancelled"}};
}

}  // namespace

void PlanFile::add(const PlanEvent& stage) {
  const std::string name = payloadName(stage.payload);
  const auto known = [&](const auto& entry) { return entry.first == name; };
  if (std::none_of(elapsed_.begin(), elapsed_.end(), known)) {
    elapsed_.emplace_back(name, stage.elapsed_s);
  }
  last_elapsed_s_ = stage.elapsed_s;
  std::visit([this](const auto& payload) { take(payload); }, stage.payload);
}

void PlanFile::take(const Accepted& accepted) { accepted_ = accepted; }

void PlanFile::take(const SceneSnapshot& scene) { scene_ = scene; }

void PlanFile::take(const ArmSelected& arms) { arms_.push_back(arms); }

void PlanFile::take(const GraspsPruned& pruned) { pruned_.push_back(pruned); }

void PlanFile::take(const HandoverCandidates& candidates) { candidates_.push_back(candidates); }

void PlanFile::take(const Solution& solution) { solutions_[solution.index] = solution; }

void PlanFile::take(const StageTrajectory& stage) {
  auto& stages = stages_[stage.solution];
  stages[stage.index] = stage;
  if (!first_plan_s_ && stages.size() == static_cast<std::size_t>(kStageCount)) {
    first_plan_s_ = last_elapsed_s_;
  }
}

void PlanFile::take(const Outcome& outcome) { outcome_ = outcome; }

const Solution* PlanFile::solution() const {
  const auto* done = outcome_ ? std::get_if<Done>(&*outcome_) : nullptr;
  if (done == nullptr) return nullptr;
  const auto found = solutions_.find(done->solution);
  return found == solutions_.end() ? nullptr : &found->second;
}

std::vector<const StageTrajectory*> PlanFile::trajectories() const {
  std::vector<const StageTrajectory*> all;
  const Solution* chosen = solution();
  const auto found = chosen == nullptr ? stages_.end() : stages_.find(chosen->index);
  if (found == stages_.end()) return all;
  for (const auto& [index, stage] : found->second) all.push_back(&stage);
  return all;
}

MotionTime PlanFile::motionTime() const {
  double end = 0, sum = 0;
  for (const StageTrajectory* stage : trajectories()) {
    const double duration = stage->t.empty() ? 0.0 : stage->t.back();
    end = std::max(end, stage->start + duration);
    sum += duration;
  }
  return {end, std::max(0.0, sum - end)};
}

bool PlanFile::complete() const {
  return scene_ && solution() != nullptr &&
         trajectories().size() == static_cast<std::size_t>(kStageCount);
}

std::string PlanFile::text() const {
  if (!complete()) throw std::logic_error("the stream holds no whole plan");
  const Solution& chosen = *solution();
  const SceneSnapshot& scene = *scene_;
  Json stages = Json::array();
  for (const auto* stage : trajectories()) stages.push_back(toJson(*stage));

  Json plan = {{"cell", scene.cell},
               {"task", scene.task},
               {"seed", scene.seed},
               {"scene_hash", scene.scene_hash},
               {"object", scene.object},
               {"giver", scene.giver},
               {"receiver", scene.receiver},
               {"giver_arm", chosen.giver_arm},
               {"receiver_arm", chosen.receiver_arm},
               {"giver_tool_link", chosen.giver_tool_link},
               {"receiver_tool_link", chosen.receiver_tool_link},
               {"robots", listOf(scene.robots)},
               {"objects", listOf(scene.objects)},
               {"X_WO_start", toJson(scene.X_WO_start)},
               {"X_WO_goal", toJson(scene.X_WO_goal)},
               {"X_WO_handover", toJson(chosen.X_WO_handover)},
               {"X_OT_giver", toJson(chosen.X_OT_giver)},
               {"X_OT_receiver", toJson(chosen.X_OT_receiver)},
               {"dexterity", toJson(chosen.dexterity)},
               {"stages", std::move(stages)}};

  Json stage_times = Json::object();
  for (const auto& [name, seconds] : elapsed_) stage_times[name] = seconds;
  const MotionTime motion = motionTime();
  Json timing = {{"total_s", last_elapsed_s_},
                 {"first_plan_s", first_plan_s_ ? Json(*first_plan_s_) : Json()},
                 {"first_of_each_s", std::move(stage_times)},
                 {"motion_s", motion.motion_s},
                 {"overlap_saves_s", motion.overlap_saves_s},
                 {"scene_revision", accepted_.scene_revision}};
  Json funnel = {{"arm_selected", listOf(arms_)},
                 {"grasps_pruned", listOf(pruned_)},
                 {"handover_candidates", listOf(candidates_)},
                 {"solutions", solutions_.size()},
                 {"giver_grasp", chosen.giver_grasp},
                 {"receiver_grasp", chosen.receiver_grasp}};
  const Json file = {{"format", "handover-plan/1"},
                     {"plan", std::move(plan)},
                     {"complete", std::get<Done>(*outcome_).complete},
                     {"timing", std::move(timing)},
                     {"funnel", std::move(funnel)},
                     {"explanation", nullptr}};
  return pretty(file) + "\n";
}

const char* payloadName(const PlanEventPayload& payload) {
  static constexpr const char* kNames[] = {
      "accepted", "scene",      "arm_selected", "grasps_pruned", "handover_candidates",
      "solution", "trajectory", "outcome"};
  static_assert(std::size(kNames) == std::variant_size_v<PlanEventPayload>);
  return kNames[payload.index()];
}

std::string jsonLine(const PlanEvent& stage) {
  Json json = {{"request_id", stage.request_id.hex()},
               {"sequence", stage.sequence},
               {"elapsed_s", stage.elapsed_s},
               {"type", payloadName(stage.payload)}};
  Json payload = std::visit([](const auto& value) { return toJson(value); }, stage.payload);
  if (const auto* trajectory = std::get_if<StageTrajectory>(&stage.payload)) {
    payload["solution"] = trajectory->solution;
  }
  json.update(payload);
  return compact(json);
}

}  // namespace handover::client
