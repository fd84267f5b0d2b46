// SPDX-License-Identifier: Apache-2.0
// Does an arm touch itself or the rigid rest of its robot? What the reachability map leaves out.
#pragma once

#include "core/model/robot_model.hpp"

#include <memory>

namespace handover {

/// The arm's links and its hand at the opening posture, against each other and against the links
/// that no arm moves (torso, head, legs, in a given posture). Other arms and their hands are left
/// out: they can get out of the way. Standing pairs are not tested. One instance per thread.
class ArmSelfCollision {
 public:
  /// @param q  posture of the whole robot, size = model.dofs().
  /// @throws std::invalid_argument for an arm that does not exist or a posture of the wrong size.
  ArmSelfCollision(const RobotModel& model, ArmId arm, const RobotVector& q);
  ~ArmSelfCollision();

  /// True when something touches at these positions of the arm's joints [rad].
  /// @pre q.size() is the arm's number of joints.
  bool touches(const ArmVector& q);

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace handover
