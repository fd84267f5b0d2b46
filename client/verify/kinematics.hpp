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

  /// X_WL of one link, without the others. @pre as above.
  Pose linkPose(int link, const std::vector<double>& q) const;

  /// Yoshikawa's manipulability sqrt(det(J Jᵀ)) of the link's origin over these independent joints;
  /// joints that follow one of them move with it, joints that do not move the link count nothing.
  /// Zero with fewer than six joints.
  double manipulability(int link, const std::vector<int>& joints,
                        const std::vector<double>& q) const;

 private:
  struct Data;
  std::unique_ptr<const Data> data_;
};

}  // namespace handover::verify
