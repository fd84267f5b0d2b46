// SPDX-License-Identifier: Apache-2.0
#include "core/planning/handover_pose.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace handover {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

class Random {
 public:
  Vector3d direction() {
    Vector3d v;
    do {
      v = Vector3d(uniform_(generator_), uniform_(generator_), uniform_(generator_));
    } while (v.norm() < 0.1 || v.norm() > 1.0);
    return v.normalized();
  }

  Matrix3d rotation() {
    return Eigen::AngleAxisd(M_PI * uniform_(generator_), direction()).toRotationMatrix();
  }

 private:
  std::mt19937_64 generator_{11};
  std::uniform_real_distribution<double> uniform_{-1.0, 1.0};
};

TEST(HandoverRotation, TurnsTheApproachAxisOntoTheShoulderDirection) {
  Random random;
  for (int i = 0; i < 1000; ++i) {
    const Matrix3d R_goal = random.rotation();
    const Vector3d approach = random.direction(), giver = random.direction(),
                   receiver = 2 * random.direction();
    const Matrix3d R = handoverRotation(R_goal, approach, giver, receiver);
    EXPECT_TRUE((R * approach).isApprox((giver - receiver).normalized(), 1e-9));
    EXPECT_NEAR(R.determinant(), 1.0, 1e-9);
  }
}

TEST(HandoverRotation, IsTheLeastOneThatDoes) {
  Random random;
  for (int i = 0; i < 200; ++i) {
    const Matrix3d R_goal = random.rotation();
    const Vector3d approach = random.direction(), giver = random.direction(),
                   receiver = 2 * random.direction();
    const double least =
        rotationAngle(handoverRotation(R_goal, approach, giver, receiver) * R_goal.transpose());
    for (int k = 1; k < 12; ++k) {  // any other one differs by a turn about z_shoulder
      const Matrix3d R =
          handoverRotation(R_goal, approach, giver, receiver, {.turn = k * M_PI / 6});
      EXPECT_TRUE((R * approach).isApprox((giver - receiver).normalized(), 1e-9));
      EXPECT_GE(rotationAngle(R * R_goal.transpose()), least - 1e-9);
    }
  }
}

TEST(HandoverRotation, TiltsTheApproachAxisByTheAngleGiven) {
  Random random;
  for (int i = 0; i < 200; ++i) {
    const Matrix3d R_goal = random.rotation();
    const Vector3d approach = random.direction(), giver = random.direction(),
                   receiver = 2 * random.direction();
    const Vector3d z_shoulder = (giver - receiver).normalized();
    const Matrix3d R_turned =
        handoverRotation(R_goal, approach, giver, receiver, {.turn = 0.1 * i});
    std::vector<Vector3d> tilted;
    for (int k = 0; k < 6; ++k) {
      const ApproachOffset offset{.turn = 0.1 * i, .tilt = 0.4, .azimuth = k * M_PI / 3};
      const Matrix3d R = handoverRotation(R_goal, approach, giver, receiver, offset);
      EXPECT_NEAR(std::acos((R * approach).dot(z_shoulder)), 0.4, 1e-9);
      EXPECT_NEAR(rotationAngle(R * R_turned.transpose()), 0.4, 1e-9);
      tilted.push_back(R * approach);
    }
    for (int k = 0; k < 6; ++k) {  // evenly all round
      const Vector3d& next = tilted[static_cast<std::size_t>((k + 1) % 6)];
      EXPECT_NEAR((tilted[static_cast<std::size_t>(k)] - next).norm(), std::sin(0.4), 1e-9);
    }
  }
}

TEST(HandoverRotation, TurnsAboutTheHandsXAxisWhenAntiparallel) {
  const Matrix3d R_goal = Eigen::AngleAxisd(0.3, Vector3d::UnitZ()).toRotationMatrix();
  const Matrix3d R =
      handoverRotation(R_goal, Vector3d::UnitZ(), Vector3d(0, 0, 0), Vector3d(0, 0, 1));
  EXPECT_TRUE((R * Vector3d::UnitZ()).isApprox(-Vector3d::UnitZ(), 1e-12));
  EXPECT_TRUE((R * Vector3d::UnitX()).isApprox(R_goal * Vector3d::UnitX(), 1e-12));
}

TEST(HandoverRotation, LeavesAnAlignedHandAlone) {
  const Matrix3d R_goal = Eigen::AngleAxisd(0.7, Vector3d::UnitX()).toRotationMatrix();
  const Vector3d z = R_goal * Vector3d::UnitZ();
  EXPECT_TRUE(
      handoverRotation(R_goal, Vector3d::UnitZ(), z, Vector3d::Zero()).isApprox(R_goal, 1e-12));
}

}  // namespace
}  // namespace handover
