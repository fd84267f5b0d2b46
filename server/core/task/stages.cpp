// SPDX-License-Identifier: Apache-2.0
#include "core/task/stages.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace handover {
namespace {

using enum StageAction;

/// Builds the list, keeping the object's state.
class StageList {
 public:
  explicit StageList(ObjectState start) : state_(start) {}

  void add(std::size_t holder, StageAction action) {
    TaskStage stage{holder, action, state_, state_};
    if (action == kGrasp) stage.after.holders.insert(holder);
    if (action == kRelease) stage.after.holders.erase(holder);
    if (action == kLift) stage.after.support = Support::kNone;
    if (action == kPlace) stage.after.support = Support::kGoal;
    state_ = stage.after;
    stages_.push_back(stage);
  }

  std::vector<TaskStage> take() { return std::move(stages_); }

 private:
  ObjectState state_;
  std::vector<TaskStage> stages_;
};

std::size_t find(const std::vector<TaskStage>& stages, std::size_t holder, StageAction action) {
  std::size_t i = 0;
  while (i < stages.size() && (stages[i].holder != holder || stages[i].action != action)) ++i;
  return i;
}

/// The last stage before `stage` that the same arm moves in; stages.size() if there is none.
std::size_t previousOfArm(const std::vector<TaskStage>& stages, std::size_t stage,
                          const std::vector<int>& arms) {
  const int arm = arms.at(stages[stage].holder);
  for (std::size_t i = stage; i-- > 0;) {
    if (arms.at(stages[i].holder) == arm) return i;
  }
  return stages.size();
}

}  // namespace

StageType typeOf(StageAction action) {
  switch (action) {
    case kUnspecified:
    case kReach:
    case kCarry:
    case kHome:
      return StageType::kFree;
    case kApproach:
    case kLift:
    case kPlace:
    case kRetreat:
      return StageType::kLinear;
    case kGrasp:
      return StageType::kGrip;
    case kRelease:
      return StageType::kRelease;
  }
  return StageType::kFree;
}

std::vector<TaskStage> makeStages(const Transport& transport) {
  if (transport.holders < 1 || transport.holders > HolderSet::kMost) {
    throw std::invalid_argument("a chain of " + std::to_string(transport.holders) + " holders");
  }
  const bool held = transport.held_at_start;
  StageList list(held ? ObjectState{{0}, Support::kNone} : ObjectState{{}, Support::kStart});
  const auto take = [&](std::size_t holder) {
    for (const StageAction action : {kReach, kApproach, kGrasp}) list.add(holder, action);
  };
  const auto leave = [&](std::size_t holder) {
    for (const StageAction action : {kRelease, kRetreat, kHome}) list.add(holder, action);
  };
  if (!held) {
    take(0);
    list.add(0, kLift);
  }
  list.add(0, kCarry);
  for (std::size_t holder = 1; holder < transport.holders; ++holder) {
    take(holder);
    leave(holder - 1);
    list.add(holder, kCarry);
  }
  if (transport.end == TransportEnd::kRelease) {
    list.add(transport.holders - 1, kPlace);
    leave(transport.holders - 1);
  }
  return list.take();
}

bool carries(const TaskStage& stage) {
  return stage.action == kLift || stage.action == kCarry || stage.action == kPlace;
}

AllowedContacts allowedContacts(const TaskStage& stage) {
  const auto bears = [&](Support support) {
    return stage.before.support == support || stage.after.support == support;
  };
  // At rest, before anybody has touched it and after all have left, what bears it moves no more
  // than the object does: no stage could change whether they touch.
  const bool loaded = !(stage.before.holders | stage.after.holders).empty();
  return {stage.before.holders | stage.after.holders, loaded && bears(Support::kStart),
          loaded && bears(Support::kGoal)};
}

AllowedContacts departingContacts(const TaskStage& stage) {
  AllowedContacts contacts = allowedContacts(stage);
  if (stage.action == kRetreat) contacts.hands.insert(stage.holder);
  return contacts;
}

std::vector<Precedence> precedenceOf(const std::vector<TaskStage>& stages, std::size_t stage,
                                     const std::vector<int>& arms) {
  const TaskStage& it = stages.at(stage);
  std::vector<Precedence> before;
  const auto require = [&](std::size_t holder, StageAction action, Progress progress) {
    const std::size_t other = find(stages, holder, action);
    if (other < stages.size()) before.push_back({other, progress});
  };
  const bool has_giver = it.holder > 0;
  if (it.action == kGrasp && has_giver) require(it.holder - 1, kCarry, Progress::kEnd);
  if (it.action == kCarry && has_giver) require(it.holder - 1, kRetreat, Progress::kClear);
  if (it.action == kRelease) require(it.holder + 1, kGrasp, Progress::kEnd);
  const std::size_t own = previousOfArm(stages, stage, arms);
  if (own < stages.size()) before.push_back({own, Progress::kEnd});
  std::sort(before.begin(), before.end(),
            [](const Precedence& a, const Precedence& b) { return a.stage < b.stage; });
  return before;
}

bool joinable(const TaskStage& stage, const TaskStage& next) {
  if (stage.holder != next.holder) return false;
  return (stage.action == kReach && next.action == kApproach) ||
         (stage.action == kLift && next.action == kCarry) ||
         (stage.action == kCarry && next.action == kPlace) ||
         (stage.action == kRetreat && next.action == kHome);
}

}  // namespace handover
