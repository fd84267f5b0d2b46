// SPDX-License-Identifier: Apache-2.0
#include <handover/common/pose.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace handover {
namespace {

TEST(PoseValue, RoundTripsRandomPosesWithPositiveLeadingComponent) {
  std::mt19937_64 generator(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int i = 0; i < 1000; ++i) {
    Pose X = Pose::Identity();
    X.linear() = Eigen::Quaterniond(uniform(generator), uniform(generator), uniform(generator),
                                    uniform(generator))
                     .normalized()
                     .toRotationMatrix();
    X.translation() << uniform(generator), uniform(generator), uniform(generator);
    const PoseValue value = toValue(X);
    EXPECT_GE(value.quat_wxyz[0], 0.0);
    EXPECT_TRUE(toPose(value).isApprox(X, 1e-12));
  }
}

TEST(PoseValue, HasNoNegativeZero) {
  Pose X = Pose::Identity();
  X.translation() << -0.0, 0.0, -0.0;
  const PoseValue value = toValue(X);
  for (const double c : value.xyz) EXPECT_FALSE(std::signbit(c));
  for (const double c : value.quat_wxyz) EXPECT_FALSE(std::signbit(c));
}

TEST(Rotation, RpyIsFixedAxisAsInUrdf) {
  // Roll first, about the fixed x, then pitch about the fixed y, then yaw about the fixed z.
  const Eigen::Matrix3d R = rotationFromRpy(M_PI / 2, 0, M_PI / 2);
  EXPECT_TRUE((R * Eigen::Vector3d::UnitY()).isApprox(Eigen::Vector3d::UnitZ(), 1e-12));
  EXPECT_TRUE((R * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY(), 1e-12));
}

TEST(Rotation, AngleIsExactNearZeroAndPi) {
  for (const double angle : {0.0, 1e-9, 0.5, M_PI - 1e-9, M_PI}) {
    const Eigen::Matrix3d R(Eigen::AngleAxisd(angle, Eigen::Vector3d(1, 2, 3).normalized()));
    EXPECT_NEAR(rotationAngle(R), angle, 1e-12);
  }
}

}  // namespace
}  // namespace handover
