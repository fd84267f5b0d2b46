// SPDX-License-Identifier: Apache-2.0
#include "core/planning/collision_context.hpp"

#include <algorithm>
#include <cmath>

namespace handover {
namespace {

/// Bodies of what an object rests on, by name.
std::vector<BodyId> bodiesOf(const TransportProblem& problem, const TaskRest& rest) {
  std::vector<BodyId> bodies;
  for (const auto& name : rest.objects.value_or(std::vector<std::string>())) {
    const ObjectId object = problem.scene->findObject(name);
    if (object.valid()) bodies.push_back(problem.collision->objectBody(object));
  }
  return bodies;
}

}  // namespace

CellState holding(CellState state, const Manipulator& manipulator, const Grasp& grasp,
                  const ArmVector& q) {
  RobotVector& robot = state.of(manipulator);
  robot = manipulator.withFingers(manipulator.withArm(std::move(robot), q), grasp.closed);
  state.holder = &manipulator;
  state.X_TO = grasp.X_OT.inverse();
  state.X_WO = manipulator.toolPose(q) * state.X_TO;
  return state;
}

TiltLimit tiltAtEnds(const SceneTask& task) {
  TiltLimit ends;
  if (task.upright) ends.axis_O = Eigen::Vector3d(task.upright->axis.data()).normalized();
  ends.most = std::max(tiltOf(task.X_WO_start.linear() * ends.axis_O),
                       tiltOf(task.X_WO_goal.linear() * ends.axis_O));
  return ends;
}

std::optional<TiltLimit> tiltLimitOf(const SceneTask& task) {
  if (!task.upright) return std::nullopt;
  TiltLimit limit = tiltAtEnds(task);
  limit.most += task.upright->within_deg * M_PI / 180;
  if (limit.most >= M_PI) return std::nullopt;
  return limit;
}

AllowedContacts besideObject(AllowedContacts contacts, std::size_t holder, const Manipulator& arm) {
  if (arm.hand->suction) contacts.hands.insert(holder);
  return contacts;
}

std::shared_ptr<const CollisionScene> collisionForTask(const Scene& scene,
                                                       const std::string& object) {
  Scene lifted = scene;
  const ObjectId index = lifted.findObject(object);
  if (index.valid()) lifted.objects[index].resting.clear();
  return std::make_shared<const CollisionScene>(lifted);
}

CollisionContext::CollisionContext(const TransportProblem& problem,
                                   std::vector<const Manipulator*> holders, CollisionWorld& world)
    : problem_(problem),
      holders_(std::move(holders)),
      world_(world),
      object_(problem.scene->findObject(problem.task.object)),
      object_body_(problem.collision->objectBody(object_)),
      tilt_(tiltLimitOf(problem.task)),
      start_rest_(bodiesOf(problem, problem.task.start_rest)),
      goal_rest_(bodiesOf(problem, problem.task.goal_rest)),
      of_hand_(static_cast<std::size_t>(problem.collision->bodies())) {
  for (const Manipulator* holder : holders_) {
    for (const BodyId body : holder->hand_bodies) of_hand_[body] = true;
  }
  for (int body = 0; body < problem.collision->bodies(); ++body) {
    carriers_.push_back(problem.collision->robotOf(BodyId(body)));
  }
  for (std::size_t o = 0; o < problem.scene->objects.size(); ++o) {
    const std::optional<Attachment>& attached = problem.scene->objects[o].attached_to;
    const BodyId body = problem.collision->objectBody(ObjectId(o));
    if (attached && body.valid()) carriers_[body] = attached->robot;
  }
}

CellState CollisionContext::startState() const {
  CellState state;
  for (const auto& robot : problem_.scene->robots) state.q.push_back(robot.q_start);
  state.X_WO = problem_.task.X_WO_start;
  return state;
}

template <typename Visit>
void CollisionContext::forEachPartner(const AllowedContacts& contacts, const Visit& visit) const {
  contacts.hands.forEach([&](std::size_t holder) {
    for (const BodyId body : holders_.at(holder)->hand_bodies) visit(body);
  });
  if (contacts.start_rest) {
    for (const BodyId body : start_rest_) visit(body);
  }
  if (contacts.goal_rest) {
    for (const BodyId body : goal_rest_) visit(body);
  }
}

std::vector<NamePair> CollisionContext::names(const AllowedContacts& contacts) const {
  std::vector<NamePair> pairs;
  forEachPartner(contacts, [&](BodyId body) {
    pairs.emplace_back(problem_.collision->name(body), problem_.task.object);
  });
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

StateChecker CollisionContext::make(const CellState& state, const Manipulator& mover,
                                    const std::vector<DofId>& dofs,
                                    const AllowedContacts& contacts) {
  const bool holding = state.holder == &mover;
  StateChecker checker = pattern(mover, dofs, holding, contacts);
  for (std::size_t robot = 0; robot < state.q.size(); ++robot) {
    checker.setPosture(RobotId(robot), state.q[robot]);
  }
  checker.setObject(object_, state.X_WO);
  if (holding) checker.setHold(state.X_TO);
  return checker;
}

/// Close to each other by nature: bodies of one robot and what it carries, the hands of a chain,
/// and the object and who takes it or gives it.
void CollisionContext::markClose(const Manipulator& mover, bool holding, BodyPairs& close) const {
  const int bodies = problem_.collision->bodies();
  for (int a = 0; a < bodies; ++a) {
    const BodyId one(a);
    if (one == object_body_) {
      for (int b = 0; b < bodies; ++b) {
        if (!holding || of_hand_[static_cast<std::size_t>(b)]) close.insert(one, BodyId(b));
      }
      continue;
    }
    if (carriers_[one] != mover.robot) continue;
    for (int b = 0; b < bodies; ++b) {
      const BodyId other(b);
      if (other == object_body_) continue;
      const bool hands = of_hand_[one] && of_hand_[other];
      if (hands || carriers_[other] == mover.robot) close.insert(one, other);
    }
  }
}

const StateChecker& CollisionContext::pattern(const Manipulator& mover,
                                              const std::vector<DofId>& dofs, bool holding,
                                              const AllowedContacts& contacts) {
  for (const Pattern& it : patterns_) {
    if (it.robot == mover.robot && it.holding == holding && it.contacts == contacts &&
        it.dofs == dofs) {
      return it.checker;
    }
  }
  StateCheckerSetup setup(*problem_.collision, mover.robot, dofs);
  if (holding)
    setup.held = HeldObject{object_, mover.arm_model->tool_link, Pose::Identity(), tilt_};
  forEachPartner(contacts, [&](BodyId body) { setup.allowed.insert(body, object_body_); });
  markClose(mover, holding, setup.close);
  // Motions of the fingers have no tool that moves with them.
  if (dofs == mover.arm_model->dofs) setup.tool_link = mover.arm_model->tool_link;
  patterns_.push_back(
      {mover.robot, dofs, holding, contacts, StateChecker(world_, std::move(setup))});
  return patterns_.back().checker;
}

}  // namespace handover
