// SPDX-License-Identifier: Apache-2.0
#include "core/planning/grip_motion.hpp"

namespace handover {

std::optional<BodyContact> gripContact(CollisionContext& context, const Manipulator& arm,
                                       CellState state, const ArmVector& q,
                                       const Eigen::VectorXd& from, const Eigen::VectorXd& to,
                                       const AllowedContacts& contacts) {
  if (arm.hand->dofs.empty()) return std::nullopt;
  RobotVector& robot = state.of(arm);
  robot = arm.withArm(std::move(robot), q);
  StateChecker checker = context.make(state, arm, arm.hand->dofs, contacts);
  return checker.hitAlong(SegmentMotion(from, to));
}

}  // namespace handover
