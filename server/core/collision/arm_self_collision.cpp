// SPDX-License-Identifier: Apache-2.0
#include "core/collision/arm_self_collision.hpp"

#include "core/collision/state_checker.hpp"

#include <algorithm>
#include <stdexcept>

namespace handover {
namespace {

Scene sceneOf(const RobotModel& model, const RobotVector& q) {
  SceneRobot robot;
  robot.name = model.name;
  robot.model = std::make_shared<const RobotModel>(model);
  robot.q_start = q;
  Scene scene;
  scene.robots.push_back(std::move(robot));
  return scene;
}

RobotVector withOpenHand(const RobotModel& model, ArmId arm, RobotVector q) {
  const HandId hand_index = model.arms.at(arm).hand;
  if (!hand_index.valid()) return q;
  const Hand& hand = model.hands.at(hand_index);
  for (std::size_t i = 0; i < hand.dofs.size(); ++i) {
    q[hand.dofs[i].value()] = hand.open[static_cast<Eigen::Index>(i)];
  }
  return q;
}

StateCheckerSetup setupFor(const CollisionScene& scene, const RobotModel& model, ArmId arm) {
  const Arm& mine = model.arms[arm];
  StateCheckerSetup setup(scene, RobotId(0), mine.dofs);
  const std::vector<LinkId> own = model.linksMovedBy(mine.dofs);
  for (const Arm& other : model.arms) {
    std::vector<LinkId> others;
    for (const LinkId link : model.linksMovedBy(other.dofs)) {
      if (!std::binary_search(own.begin(), own.end(), link)) others.push_back(link);
    }
    setup.allowed.insert(scene.linkBodies(RobotId(0), own), scene.linkBodies(RobotId(0), others));
  }
  return setup;
}

}  // namespace

struct ArmSelfCollision::Data {
  Data(const RobotModel& model, ArmId arm, const RobotVector& q)
      : world(std::make_shared<const CollisionScene>(sceneOf(model, withOpenHand(model, arm, q)))),
        checker(world, setupFor(world.scene(), model, arm)) {}

  CollisionWorld world;
  StateChecker checker;
};

ArmSelfCollision::ArmSelfCollision(const RobotModel& model, ArmId arm, const RobotVector& q) {
  if (!arm.valid() || std::size_t{arm} >= model.arms.size() || q.size() != model.dofs()) {
    throw std::invalid_argument("ArmSelfCollision: no such arm, or a posture of the wrong size");
  }
  data_ = std::make_unique<Data>(model, arm, q);
}

ArmSelfCollision::~ArmSelfCollision() = default;

bool ArmSelfCollision::touches(const ArmVector& q) { return !data_->checker.valid(q); }

}  // namespace handover
