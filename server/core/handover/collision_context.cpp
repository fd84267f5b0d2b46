// SPDX-License-Identifier: Apache-2.0
#include "core/handover/collision_context.hpp"

#include <algorithm>

namespace handover {
namespace {

std::size_t at(int index) { return static_cast<std::size_t>(index); }

/// Bodies of what an object rests on, by name.
std::vector<BodyId> bodiesOf(const HandoverProblem& problem,
                             const std::vector<std::string>& names) {
  std::vector<BodyId> bodies;
  for (const auto& name : names) {
    const int object = problem.scene->findObject(name);
    if (object >= 0) bodies.push_back(problem.collision->objectBody(object));
  }
  return bodies;
}

}  // namespace

std::shared_ptr<const CollisionScene> collisionForTask(const Scene& scene,
                                                       const std::string& object) {
  Scene lifted = scene;
  const int index = lifted.findObject(object);
  if (index >= 0) lifted.objects[at(index)].resting.clear();
  return std::make_shared<const CollisionScene>(lifted);
}

CollisionContext::CollisionContext(const HandoverProblem& problem, const Manipulator& giver,
                                   const Manipulator& receiver, CollisionWorld& world)
    : problem_(problem),
      giver_(giver),
      receiver_(receiver),
      world_(world),
      object_(problem.scene->findObject(problem.task.object)),
      object_body_(problem.collision->objectBody(object_)),
      start_rest_(bodiesOf(problem, problem.scene->objects[at(object_)].resting)),
      goal_rest_(bodiesOf(problem, problem.task.goal_rest)) {}

CellState CollisionContext::startState() const {
  CellState state;
  for (const auto& robot : problem_.scene->robots) state.q.push_back(robot.q_start);
  state.X_WO = problem_.task.X_WO_start;
  return state;
}

BodyPairs CollisionContext::allowed(const AllowedContacts& contacts) const {
  BodyPairs pairs(problem_.collision->bodies());
  const std::vector<BodyId> object{object_body_};
  if (contacts.giver_hand) pairs.insert(giver_.hand_bodies, object);
  if (contacts.receiver_hand) pairs.insert(receiver_.hand_bodies, object);
  if (contacts.start_rest) pairs.insert(start_rest_, object);
  if (contacts.goal_rest) pairs.insert(goal_rest_, object);
  return pairs;
}

std::vector<NamePair> CollisionContext::names(const AllowedContacts& contacts) const {
  std::vector<NamePair> pairs;
  const auto add = [&](const std::vector<BodyId>& bodies) {
    for (const BodyId body : bodies) {
      pairs.emplace_back(problem_.collision->name(body), problem_.task.object);
    }
  };
  if (contacts.giver_hand) add(giver_.hand_bodies);
  if (contacts.receiver_hand) add(receiver_.hand_bodies);
  if (contacts.start_rest) add(start_rest_);
  if (contacts.goal_rest) add(goal_rest_);
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

StateChecker CollisionContext::make(const CellState& state, const Manipulator& mover,
                                    const std::vector<int>& dofs,
                                    const AllowedContacts& contacts) const {
  const bool holding = state.holder == &mover;
  StateChecker checker = pattern(mover, dofs, holding, contacts);
  for (std::size_t robot = 0; robot < state.q.size(); ++robot) {
    checker.setPosture(static_cast<int>(robot), state.q[robot]);
  }
  checker.setObject(object_, state.X_WO);
  if (holding) checker.setHold(state.X_TO);
  return checker;
}

const StateChecker& CollisionContext::pattern(const Manipulator& mover,
                                              const std::vector<int>& dofs, bool holding,
                                              const AllowedContacts& contacts) const {
  for (const Pattern& it : patterns_) {
    if (it.robot == mover.robot && it.holding == holding && it.contacts == contacts &&
        it.dofs == dofs) {
      return it.checker;
    }
  }
  StateCheckerSetup setup(*problem_.collision, mover.robot, dofs);
  if (holding) setup.held = HeldObject{object_, mover.arm_model->tool_link, Pose::Identity()};
  setup.allowed = allowed(contacts);
  // Motions of the fingers have no tool that moves with them.
  if (dofs == mover.arm_model->dofs) setup.tool_link = mover.arm_model->tool_link;
  patterns_.push_back(
      {mover.robot, dofs, holding, contacts, StateChecker(world_, std::move(setup))});
  return patterns_.back().checker;
}

}  // namespace handover
