// SPDX-License-Identifier: Apache-2.0
// Straight lines and their timing on a real arm's kinematics, from pose to timed curve.
#include "core/motion/straight.hpp"
#include "core/motion/timing.hpp"
#include "support/arm_models.hpp"

#include <handover/common/random.hpp>

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdio>

namespace handover {
namespace {

TEST(StraightLine, StaysStraightOnTheLwa4WhenTimed) {
  const RobotModel model = test::lwa4Arm();
  const ArmKinematics arm(model, ArmId(0));
  TimingLimits limits{arm.lower(), arm.upper(), arm.velocity(), arm.acceleration(), {}};
  limits.acceleration.setConstant(0.4);
  limits.jerk = 10 * limits.acceleration;
  SeededRandom random(3);
  using Clock = std::chrono::steady_clock;
  Clock::duration line_time{}, timing_time{};
  int lines = 0, finished = 0;
  double longest = 0;
  while (lines < 200) {
    ArmVector q_from(arm.dofs());
    for (int j = 0; j < arm.dofs(); ++j) q_from[j] = random.uniform(arm.lower()[j], arm.upper()[j]);
    if (arm.manipulability(q_from) < 0.03) continue;
    const Pose X_from = arm.toolPose(q_from);
    Pose X_to = X_from;
    X_to.translation() += 0.1 * X_from.linear().col(2);
    ++lines;
    const auto t0 = Clock::now();
    const auto path = straightLine(arm, q_from, X_from, X_to);
    const auto t1 = Clock::now();
    if (!path) {
      EXPECT_EQ(path.error().code, ErrorCode::kUnreachable);
      continue;
    }
    ++finished;
    EXPECT_EQ(path->waypoints.size(), 21u);
    const std::vector<Eigen::VectorXd> waypoints(path->waypoints.begin(), path->waypoints.end());
    const auto t2 = Clock::now();
    const auto timed = parameterize(waypoints, limits, {});
    const auto t3 = Clock::now();
    line_time += t1 - t0;
    timing_time += t3 - t2;
    ASSERT_TRUE(timed) << timed.error().detail;
    EXPECT_LE(limitUse(*timed, limits).jerk, 1.0);
    EXPECT_LE(limitUse(*timed, limits).acceleration, 1.0);
    EXPECT_LE(limitUse(*timed, limits).velocity, 1.0);
    EXPECT_LE(positionExcess(*timed, limits), 1e-9);
    longest = std::max(longest, timed->duration());
    for (int k = 0; k <= 100; ++k) {
      const Pose X = arm.toolPose(evaluate(*timed, timed->duration() * k / 100));
      const Eigen::Vector3d p = X_from.inverse() * X.translation();
      EXPECT_LT(p.head<2>().norm(), 5e-4);
      EXPECT_GT(p.z(), -1e-6);
      EXPECT_LT(p.z(), 0.1 + 1e-6);
      EXPECT_LT(rotationAngle(X_from.linear().transpose() * X.linear()), 5e-3);
    }
  }
  EXPECT_GT(finished, lines / 2);
  using Ms = std::chrono::duration<double, std::milli>;
  std::printf("%d of %d lines of 10 cm: %.3f ms a line, %.3f ms its timing, longest %.1f s\n",
              finished, lines, Ms(line_time).count() / finished, Ms(timing_time).count() / finished,
              longest);
}

}  // namespace
}  // namespace handover
