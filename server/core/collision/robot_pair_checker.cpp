// SPDX-License-Identifier: Apache-2.0
#include "core/collision/robot_pair_checker.hpp"

#include <algorithm>
#include <stdexcept>

namespace handover {
namespace {

bool shareJoints(const StateCheckerSetup& first, const StateCheckerSetup& second) {
  if (first.robot != second.robot) return false;
  return std::any_of(first.dofs.begin(), first.dofs.end(), [&](DofId dof) {
    return std::find(second.dofs.begin(), second.dofs.end(), dof) != second.dofs.end();
  });
}

}  // namespace

RobotPairChecker::RobotPairChecker(StateChecker& first, StateChecker& second)
    : world_(&first.world()), moving_(first.movingBodies()), groups_(first.groups()) {
  if (&second.world() != world_ || shareJoints(first.setup(), second.setup())) {
    throw std::invalid_argument("two movers share no joint and are of one world");
  }
  const int offset = groups_.size();
  const std::vector<MovingBody>& others = second.movingBodies();
  groups_.append(second.groups());

  const CollisionScene& scene = world_->scene();
  std::vector<std::pair<BodyId, BodyId>> pairs;
  for (const MovingBody& a : moving_) {
    for (const MovingBody& b : others) {
      if (scene.standingPairs().contains(a.body, b.body)) continue;
      if (first.setup().allowed.contains(a.body, b.body)) continue;
      if (second.setup().allowed.contains(a.body, b.body)) continue;
      pairs.emplace_back(a.body, b.body);
    }
  }
  pairs_ = PairList(std::move(pairs));
  for (MovingBody body : others) {
    body.group += offset;
    moving_.push_back(body);
  }
  moving_index_.assign(static_cast<std::size_t>(scene.bodies()), -1);
  for (std::size_t i = 0; i < moving_.size(); ++i) {
    moving_index_[moving_[i].body] = static_cast<int>(i);
  }
}

bool RobotPairChecker::isMotionFree(const JointMotion& motion) {
  return proof_.free(*world_, pairs_, groups_, moving_, moving_index_, motion, 0, 1,
                     kPlannedClearance, nullptr);
}

}  // namespace handover
