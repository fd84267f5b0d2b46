// SPDX-License-Identifier: Apache-2.0
// Checks a grasp with FCL's triangle trees: nothing of the code that made it is asked.
#pragma once

#include "core/grasp/grasp_set.hpp"

#include <memory>
#include <string>
#include <vector>

namespace handover {

class GraspChecker {
 public:
  GraspChecker(const SceneObject& object, const RobotModel& model, ArmId arm);
  ~GraspChecker();

  /// What is wrong with a grasp by the contract (design: hand free when open and on its straight
  /// way in, nothing inside the object when closed, two finger links within 2 mm whose normals
  /// differ by more than 120 deg, palm and wrist off the object, hand off itself); empty when
  /// nothing is.
  std::string faultOf(const Grasp& grasp) const;

  /// Distance of the hand at a grasp to another hand at its own grasp of the same object; 0: they
  /// touch.
  static double distance(const GraspChecker& a, const Grasp& grasp_a, const Eigen::VectorXd& q_a,
                         const GraspChecker& b, const Grasp& grasp_b, const Eigen::VectorXd& q_b);

  /// Hand and object as triangles in a Wavefront file, to look at.
  void writeObj(const Grasp& grasp, const Eigen::VectorXd& q, const std::string& file) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace handover
