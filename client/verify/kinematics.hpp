// SPDX-License-Identifier: Apache-2.0
// Forward kinematics and Jacobians of a robot, by KDL.
#pragma once

#include "verify/pose.hpp"
#include "verify/robot.hpp"

#include <memory>
#include <vector>

namespace handover::verify {

class Kinematics {
 public:
  Kinematics(const Robot& robot, const Pose& X_WB);
  ~Kinematics();
  Kinematics(Kinematics&&) noexcept;

  /// X_WL of every link. @pre q has an entry for every joint of the robot (mimic ones filled in).
  void linkPoses(const std::vector<double>& q, std::vector<Pose>& X_WL) const;

  /// Yoshikawa's manipulability sqrt(det(J Jᵀ)) of the arm's joints at the tool link; of fewer
  /// than six joints sqrt(det(Jᵀ J)).
  double manipulability(const Arm& arm, const std::vector<double>& q) const;

 private:
  struct Data;
  std::unique_ptr<const Data> data_;
};

}  // namespace handover::verify
