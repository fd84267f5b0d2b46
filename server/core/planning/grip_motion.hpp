// SPDX-License-Identifier: Apache-2.0
// Solver of grip and release stages: a gripper's own joints, straight from one posture to another.
#pragma once

#include "core/planning/collision_context.hpp"

#include <optional>

namespace handover {

/// What the fingers touch, if anything, while they go straight from one posture to another, the arm
/// at a configuration, all else as in the state. A gripper without joints touches nothing.
std::optional<BodyContact> gripContact(CollisionContext& context, const Manipulator& arm,
                                       CellState state, const ArmVector& q,
                                       const Eigen::VectorXd& from, const Eigen::VectorXd& to,
                                       const AllowedContacts& contacts);

}  // namespace handover
