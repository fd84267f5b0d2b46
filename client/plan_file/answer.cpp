// SPDX-License-Identifier: Apache-2.0
#include "plan_file/plan_json.hpp"

#include <handover/client/answer.hpp>

#include <algorithm>
#include <iterator>
#include <stdexcept>

namespace handover::client {
namespace {

template <typename T>
Json listOf(const std::vector<T>& items) {
  Json list = Json::array();
  for (const T& item : items) list.push_back(toJson(item));
  return list;
}

/// Of the file, not of a stream: the cells are too many.
Json funnelOf(const std::vector<HandoverCandidates>& all) {
  Json list = Json::array();
  for (const HandoverCandidates& candidates : all) {
    list.push_back(toJson(candidates));
    list.back().erase("lattice");
  }
  return list;
}

template <typename T>
Json orNull(const std::optional<T>& value) {
  return value ? Json(*value) : Json();
}

}  // namespace

void Answer::add(const PlanEvent& event) {
  if (id_ && *id_ != event.answer_id) *this = Answer();
  id_ = event.answer_id;
  const std::string name = payloadName(event.payload);
  const auto known = [&](const auto& entry) { return entry.first == name; };
  if (std::none_of(elapsed_.begin(), elapsed_.end(), known)) {
    elapsed_.emplace_back(name, event.elapsed_s);
  }
  last_elapsed_s_ = event.elapsed_s;
  std::visit([this](const auto& payload) { take(payload); }, event.payload);
}

void Answer::take(const Accepted& accepted) { accepted_ = accepted; }

void Answer::take(const SceneSnapshot& scene) { scene_ = scene; }

void Answer::take(const ArmSelected& arms) { arms_.push_back(arms); }

void Answer::take(const GraspsPruned& pruned) { pruned_.push_back(pruned); }

void Answer::take(const HandoverCandidates& candidates) { candidates_.push_back(candidates); }

void Answer::take(const Solution& solution) { solutions_[solution.index] = solution; }

void Answer::take(const StageTrajectory& stage) {
  auto& stages = stages_[stage.solution];
  stages[stage.index] = stage;
  const auto solution = solutions_.find(stage.solution);
  if (first_plan_s_ || solution == solutions_.end()) return;
  if (stages.size() != solution->second.stage_count) return;
  first_plan_s_ = last_elapsed_s_;
  first_cost_ = solution->second.cost;
}

void Answer::take(const Note& note) { notes_.push_back(note); }

void Answer::take(const Failure&) {}  // said again by the outcome

void Answer::take(const Fix& fix) { fix_ = fix; }

void Answer::take(const Workspaces& workspaces) { workspaces_ = workspaces; }

void Answer::take(const Outcome& outcome) { outcome_ = outcome; }

const Solution* Answer::solution() const {
  const auto* done = outcome_ ? std::get_if<Done>(&*outcome_) : nullptr;
  if (done == nullptr) return nullptr;
  const auto found = solutions_.find(done->solution);
  return found == solutions_.end() ? nullptr : &found->second;
}

std::vector<const StageTrajectory*> Answer::trajectories() const {
  std::vector<const StageTrajectory*> all;
  const Solution* chosen = solution();
  const auto found = chosen == nullptr ? stages_.end() : stages_.find(chosen->index);
  if (found == stages_.end()) return all;
  for (const auto& [index, stage] : found->second) all.push_back(&stage);
  return all;
}

MotionTime Answer::motionTime() const {
  double end = 0, sum = 0;
  for (const StageTrajectory* stage : trajectories()) {
    const double duration = stage->t.empty() ? 0.0 : stage->t.back();
    end = std::max(end, stage->start + duration);
    sum += duration;
  }
  return {end, std::max(0.0, sum - end)};
}

bool Answer::hasPlan() const {
  return scene_ && solution() != nullptr && trajectories().size() == solution()->stage_count;
}

bool Answer::writable() const { return hasPlan() || failure(); }

std::optional<Failure> Answer::failure() const {
  const auto* failed = outcome_ ? std::get_if<Failed>(&*outcome_) : nullptr;
  if (failed == nullptr) return std::nullopt;
  Failure failure{failed->reason, failed->explanation};
  Explanation& why = failure.explanation;
  if (fix_ && why.nearest_fix.empty()) why.nearest_fix = fix_->overrides;
  if (fix_ && why.fix_text.empty()) why.fix_text = fix_->text;
  return failure;
}

std::string Answer::text() const {
  if (!writable()) throw std::logic_error("the answer holds neither a whole plan nor a failure");
  const Solution* chosen = solution();
  Json first = Json::object();
  for (const auto& [name, seconds] : elapsed_) first[name] = seconds;
  Json timing = {{"total_s", last_elapsed_s_},
                 {"first_plan_s", orNull(first_plan_s_)},
                 {"first_of_each_s", std::move(first)}};
  Json grasps = Json::array();
  if (chosen != nullptr) {
    for (const Holder& holder : chosen->holders) grasps.push_back(holder.grasp);
    const MotionTime motion = motionTime();
    timing["motion_s"] = motion.motion_s;
    timing["overlap_saves_s"] = motion.overlap_saves_s;
  }
  timing["scene_revision"] = accepted_.scene_revision;
  Json funnel = {{"arm_selected", listOf(arms_)},
                 {"grasps_pruned", listOf(pruned_)},
                 {"handover_candidates", funnelOf(candidates_)},
                 {"solutions", solutions_.size()},
                 {"grasps", std::move(grasps)},
                 {"notes", listOf(notes_)}};
  if (workspaces_) funnel["workspaces"] = toJson(*workspaces_);
  const auto* done = std::get_if<Done>(&*outcome_);
  const auto why = failure();
  const bool measured = chosen != nullptr && chosen->quality;
  const Json file = {{"format", "handover-plan/2"},
                     {"scene", scene_ ? toJson(*scene_) : Json()},
                     {"plan", chosen != nullptr ? planJson(*chosen, trajectories()) : Json()},
                     {"quality", measured ? toJson(*chosen->quality) : Json()},
                     {"complete", done != nullptr && done->complete},
                     {"timing", std::move(timing)},
                     {"funnel", std::move(funnel)},
                     {"explanation", why ? toJson(*why) : Json()}};
  return pretty(file) + "\n";
}

const char* payloadName(const PlanEventPayload& payload) {
  static constexpr const char* kNames[] = {
      "accepted", "scene",      "arm_selected", "grasps_pruned", "handover_candidates",
      "solution", "trajectory", "note",         "failure",       "fix",
      "outcome",  "workspaces"};
  static_assert(std::size(kNames) == std::variant_size_v<PlanEventPayload>);
  return kNames[payload.index()];
}

std::string jsonLine(const PlanEvent& event) {
  Json json = {{"request_id", event.request_id.hex()},
               {"answer_id", RequestId{event.answer_id}.hex()},
               {"sequence", event.sequence},
               {"elapsed_s", event.elapsed_s},
               {"type", payloadName(event.payload)}};
  Json payload = std::visit([](const auto& value) { return toJson(value); }, event.payload);
  if (const auto* trajectory = std::get_if<StageTrajectory>(&event.payload)) {
    payload["solution"] = trajectory->solution;
  }
  json.update(payload);
  return compact(json);
}

}  // namespace handover::client
