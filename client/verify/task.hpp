// SPDX-License-Identifier: Apache-2.0
// What the stages of a plan are together: whose they are, which run on without a stop, which move
// the same joints.
#pragma once

#include "verify/scene.hpp"

#include <string>
#include <utility>
#include <vector>

namespace handover::verify {

/// Places of a holder's stages in the list; -1: it has none of that action.
struct HolderStages {
  int reach = -1, approach = -1, grasp = -1, lift = -1, carry = -1;
  int place = -1, release = -1, retreat = -1, home = -1;
};

/// The arms (nearly always one) whose joints move the same links. Its stages never overlap, so that
/// its whole posture follows from how far it has come in them.
struct Actor {
  int robot = -1;
  std::vector<int> stages;   ///< by index
  std::vector<bool> joints;  ///< per joint of the robot: independent ones of its arms and grippers
};

struct Task {
  bool held_at_start = false;    ///< the first holder has O in hand
  bool ends_held = false;        ///< the last one keeps it
  std::vector<HolderStages> of;  ///< per holder
  std::vector<int> previous;     ///< per stage: the one before of the same arm, or -1
  std::vector<bool> joined;      ///< per stage: goes on from `previous` without a stop
  std::vector<int> run_of;       ///< per stage: joined stages are one run
  std::vector<std::vector<int>> runs;
  std::vector<Actor> actors;
  std::vector<int> actor_of_stage, actor_of_holder;
  /// Per holder that retreats: its own time in the retreat at which the tool link's origin is first
  /// 5 mm from where that began, and the later of it and what the next carry waits for.
  std::vector<double> first_5mm, hand_leaves;

  int last() const { return static_cast<int>(of.size()) - 1; }
};

/// Holder and action of every stage of such a chain, in the contract's order.
std::vector<std::pair<int, std::string>> expectedStages(int holders, bool held_at_start,
                                                        bool ends_held);

/// @pre the stages are those of expectedStages() and their samples are sound. first_5mm and
/// hand_leaves are left empty.
Task makeTask(const Scene& scene);

}  // namespace handover::verify
