// SPDX-License-Identifier: Apache-2.0
#include "core/motion/straight.hpp"

#include "problems.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace handover {
namespace {

using test::joints;

// Planar arm, links of 0.5 and 0.4 m and a wrist, about A's z: the third joint turns the tool.
Pose planarTool(const ArmVector& q) {
  Pose X_AT = Pose::Identity();
  X_AT.translation() = Eigen::Vector3d(0.5 * std::cos(q[0]) + 0.4 * std::cos(q[0] + q[1]),
                                       0.5 * std::sin(q[0]) + 0.4 * std::sin(q[0] + q[1]), 0);
  X_AT.linear() = Eigen::AngleAxisd(q.sum(), Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return X_AT;
}

double turned(double angle, double near) {
  return angle + 2 * M_PI * std::round((near - angle) / (2 * M_PI));
}

bool planarFollow(const Pose& X_AT, const ArmVector& q_near, double max_step, ArmVector& q) {
  const double x = X_AT.translation().x(), y = X_AT.translation().y();
  const double c = (x * x + y * y - 0.25 - 0.16) / 0.4;
  if (std::abs(c) > 1) return false;
  const double elbow = std::copysign(std::acos(c), q_near[1]);
  const double shoulder = std::atan2(y, x) - std::atan2(0.4 * std::sin(elbow), 0.5 + 0.4 * c);
  const double yaw = std::atan2(X_AT.linear()(1, 0), X_AT.linear()(0, 0));
  q = joints({turned(shoulder, q_near[0]), elbow, 0});
  q[2] = turned(yaw - q[0] - q[1], q_near[2]);
  return (q - q_near).cwiseAbs().maxCoeff() <= max_step;
}

TEST(StraightLine, KeepsTheToolOnTheLine) {
  const ArmVector q_from = joints({0.3, 1.2, -0.4});
  const Pose X_from = planarTool(q_from);
  Pose X_to = X_from;
  X_to.translation() += Eigen::Vector3d(-0.06, 0.08, 0);
  X_to.rotate(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()));
  const auto path = straightLine(planarFollow, q_from, X_from, X_to);
  ASSERT_TRUE(path) << path.error().detail;
  ASSERT_EQ(path->waypoints.size(), 21u);  // 0.1 m / 5 mm; the turn alone would need 15
  EXPECT_EQ(path->waypoints.front(), q_from);
  EXPECT_TRUE(planarTool(path->waypoints.back()).isApprox(X_to, 1e-12));
  for (std::size_t i = 0; i < path->waypoints.size(); ++i) {
    const Pose X = planarTool(path->waypoints[i]);
    const double s = static_cast<double>(i) / 20;
    EXPECT_LT(
        (X.translation() - X_from.translation() - s * (X_to.translation() - X_from.translation()))
            .norm(),
        1e-12);
    EXPECT_NEAR(rotationAngle(X_from.linear().transpose() * X.linear()), 0.5 * s, 1e-6);
    if (i == 0) continue;
    // Half-way between waypoints the joints' line is still close to the tool's.
    const Pose X_mid = planarTool(0.5 * (path->waypoints[i] + path->waypoints[i - 1]));
    EXPECT_LT((X_mid.translation() - X_from.translation() -
               (s - 0.025) * (X_to.translation() - X_from.translation()))
                  .norm(),
              1e-4);
  }
}

TEST(StraightLine, StepsByTheAngleWhereTheToolOnlyTurns) {
  const ArmVector q_from = joints({0.3, 1.2, 0});
  Pose X_to = planarTool(q_from);
  X_to.rotate(Eigen::AngleAxisd(M_PI / 6, Eigen::Vector3d::UnitZ()));
  const auto path = straightLine(planarFollow, q_from, planarTool(q_from), X_to);
  ASSERT_TRUE(path);
  EXPECT_NEAR(static_cast<double>(path->waypoints.size()), 16, 1);
  const auto still = straightLine(planarFollow, q_from, planarTool(q_from), planarTool(q_from));
  ASSERT_TRUE(still);
  EXPECT_EQ(still->waypoints.size(), 2u);
}

TEST(StraightLine, TellsHowFarItCame) {
  const ArmVector q_from = joints({0, 1.0, 0});
  const Pose X_from = planarTool(q_from);
  Pose X_far = X_from;
  X_far.translation().x() = X_from.translation().x() + 0.4;  // beyond the stretched arm
  const auto far = straightLine(planarFollow, q_from, X_from, X_far);
  ASSERT_FALSE(far);
  EXPECT_EQ(far.error().code, ErrorCode::kUnreachable);
  EXPECT_NE(far.error().detail.find(" % of the straight line passed"), std::string::npos);
}

TEST(StraightLine, RejectsBadInput) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const ArmVector q = joints({0.3, 1.2, 0});
  const Pose X = planarTool(q);
  Pose X_nan = X;
  X_nan.translation().x() = nan;
  const auto code = [](const auto& result) {
    return result ? ErrorCode::kInternal : result.error().code;
  };
  const auto invalid = ErrorCode::kInvalidInput;
  EXPECT_EQ(code(straightLine(planarFollow, joints({nan, 0, 0}), X, X)), invalid);
  EXPECT_EQ(code(straightLine(planarFollow, ArmVector(), X, X)), invalid);
  EXPECT_EQ(code(straightLine(planarFollow, q, X_nan, X)), invalid);
  EXPECT_EQ(code(straightLine(planarFollow, q, X, X_nan)), invalid);
  EXPECT_EQ(code(straightLine(TrackPoseIk(), q, X, X)), invalid);
  StraightSettings settings;
  settings.step = 0;
  EXPECT_EQ(code(straightLine(planarFollow, q, X, X, settings)), invalid);
}

}  // namespace
}  // namespace handover
