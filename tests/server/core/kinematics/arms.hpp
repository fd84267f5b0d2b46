// SPDX-License-Identifier: Apache-2.0
// What the tests of this folder share: the arms by name.
#pragma once

#include "core/kinematics/arm_kinematics.hpp"
#include "support/arm_models.hpp"
#include "support/random_configurations.hpp"

#include <gtest/gtest.h>

namespace handover::test {

struct NamedArm {
  const char* name;
  RobotModel (*make)();
  bool closed_form;
};

inline std::ostream& operator<<(std::ostream& out, const NamedArm& arm) { return out << arm.name; }

inline RobotModel lwa4ExactArm() { return lwa4Arm(); }

/// As its author's files write it: 1.57 for pi/2, 3.1416 for pi.
inline RobotModel lwa4RoughArm() { return lwa4Arm(1.57, 3.1416, 3.14157); }

/// The paper's limits: joints of two turns.
inline RobotModel lwa4TwoTurnArm() { return lwa4Arm(1.57, 3.1416, 6.28319); }

inline RobotModel huboLeftArm() { return huboArm(1); }

inline RobotModel huboRightArm() { return huboArm(-1); }

inline const std::vector<NamedArm> kArms = {
    {"Lwa4", lwa4ExactArm, true},
    {"Lwa4Rough", lwa4RoughArm, true},
    {"Lwa4TwoTurn", lwa4TwoTurnArm, true},
    {"Lwa4Upright", lwa4UprightArm, true},
    {"HuboLeft", huboLeftArm, true},
    {"HuboRight", huboRightArm, true},
    {"Skew", skewSrsArm, true},
    {"Iiwa14", iiwa14Arm, true},
    {"Six", sixAxisArm, false},
    {"Ur5e", ur5eArm, false},
    {"Panda", pandaArm, false},
    {"Sliding", slidingArm, false},
    {"Planar", planarArm, false},
};

inline std::string armName(const testing::TestParamInfo<NamedArm>& info) { return info.param.name; }

/// Largest difference between two poses' entries: metres and, for small angles, radians.
inline double poseDistance(const Pose& X, const Pose& Y) {
  return (X.matrix() - Y.matrix()).cwiseAbs().maxCoeff();
}

inline ArmVector degrees(std::initializer_list<double> values) {
  ArmVector q(static_cast<Eigen::Index>(values.size()));
  Eigen::Index i = 0;
  for (const double value : values) q[i++] = value * M_PI / 180;
  return q;
}

}  // namespace handover::test
