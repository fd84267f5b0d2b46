// SPDX-License-Identifier: Apache-2.0
// What a transport is, without any search: one object, a chain of holders, and the stages that
// follow from them (design §5, Stages). What may touch, who holds and what must come before what is
// derived from the object's state, by one function each; nothing lists stages by name.
#pragma once

#include "core/task/object_state.hpp"

#include <handover/common/plan_event.hpp>

#include <vector>

namespace handover {

/// The shape of a task.
struct Transport {
  std::size_t holders = 2;     ///< length of the chain, in [1, HolderSet::kMost]
  bool held_at_start = false;  ///< the first holder has the object in hand
  TransportEnd end = TransportEnd::kRelease;
};

/// Which solver plans a stage.
enum class StageType {
  kFree,     ///< an arm, any way
  kLinear,   ///< an arm, its tool on a straight line
  kGrip,     ///< a gripper, until it holds
  kRelease,  ///< a gripper, until it does not
};

StageType typeOf(StageAction action);

struct TaskStage {
  std::size_t holder = 0;  ///< who moves
  StageAction action = StageAction::kUnspecified;
  ObjectState before, after;
  bool operator==(const TaskStage&) const = default;
};

/// The stages in the order in which they could be done one after the other; a stage's index is its
/// place there. @throws std::invalid_argument for chains of no holders or too many.
std::vector<TaskStage> makeStages(const Transport& transport);

/// Whether the object moves with the stage's holder.
bool carries(const TaskStage& stage);

/// Contacts with the object beyond the standing pairs.
struct AllowedContacts {
  HolderSet hands;
  bool start_rest = false, goal_rest = false;
  bool operator==(const AllowedContacts&) const = default;
};

/// Those of a whole stage: of hands that hold before or after it, and of what bears the object
/// before or after it.
AllowedContacts allowedContacts(const TaskStage& stage);

/// Those of its first part: a retreating hand may touch for kClearDistance, too.
AllowedContacts departingContacts(const TaskStage& stage);

/// How far the tool's origin goes in a retreat until the hand has left the object [m].
inline constexpr double kClearDistance = 0.005;

/// How far a stage has to be before another may start.
enum class Progress {
  kEnd,
  kClear,  ///< of a retreat: kClearDistance away
};

struct Precedence {
  std::size_t stage = 0;
  Progress progress = Progress::kEnd;
  bool operator==(const Precedence&) const = default;
};

/// What must have happened before a stage starts (design §5, Order), by rising stage; what follows
/// from what these need in turn is left out.
/// @param arms  per holder, a number of its arm: equal numbers are one arm.
std::vector<Precedence> precedenceOf(const std::vector<TaskStage>& stages, std::size_t stage,
                                     const std::vector<int>& arms);

/// Whether an arm may pass from a stage to the next one in the list without stopping.
bool joinable(const TaskStage& stage, const TaskStage& next);

}  // namespace handover
