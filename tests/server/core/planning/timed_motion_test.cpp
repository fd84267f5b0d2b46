// SPDX-License-Identifier: Apache-2.0
#include "core/planning/timed_motion.hpp"

#include "stretches.hpp"

#include <algorithm>
#include <random>

namespace handover::test {
namespace {

TEST(TimedMotion, StaysNearTheLineOfItsPart) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> joint(-1, 1), unit(0, 1);
  TimingLimits limits;
  limits.lower = Eigen::Vector3d::Constant(-2);
  limits.upper = Eigen::Vector3d::Constant(2);
  limits.velocity = Eigen::Vector3d(1, 2, 0.5);
  limits.acceleration = Eigen::Vector3d(2, 1, 3);
  for (int round = 0; round < 60; ++round) {
    std::vector<Eigen::VectorXd> waypoints(2 + static_cast<std::size_t>(round) % 3);
    for (auto& q : waypoints) q = Eigen::Vector3d(joint(random), joint(random), joint(random));
    const auto path = parameterize(waypoints, limits, {});
    ASSERT_TRUE(path);
    // Some from before its start or to after its end, where it stands still.
    const double begin = joint(random), end = path->duration() + joint(random);
    if (begin >= end) continue;
    const TimedMotion motion(*path, begin, end);
    const auto at = [&](double s) { return evaluate(*path, begin + s * (end - begin)); };
    const double a = unit(random), b = unit(random);
    expectNearTheLine(motion, std::min(a, b), std::max(a, b), at);
    // Smooth as it is, what the line leaves goes down with the square of the part.
    MotionInterval whole, tenth;
    motion.stretch(0.4, 0.5, whole);
    motion.stretch(0.44, 0.45, tenth);
    EXPECT_LE(tenth.rest.maxCoeff(), 0.1 * whole.rest.maxCoeff() + 1e-9);
  }
}

}  // namespace
}  // namespace handover::test
