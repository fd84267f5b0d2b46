// SPDX-License-Identifier: Apache-2.0
#include "stretches.hpp"

#include <algorithm>
#include <random>
#include <utility>
#include <vector>

namespace handover::test {
namespace {

/// `from` and `to` in [0, 1], rising.
std::pair<double, double> part(std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  const double a = unit(random), b = unit(random);
  return {std::min(a, b), std::max(a, b)};
}

TEST(JointMotion, ASegmentIsItsLine) {
  const Eigen::VectorXd a = Eigen::Vector3d(0, 1, -2), b = Eigen::Vector3d(1, 1, 3);
  const SegmentMotion motion(a, b);
  std::mt19937_64 random(3);
  for (int round = 0; round < 50; ++round) {
    const auto [from, to] = part(random);
    expectNearTheLine(motion, from, to,
                      [&](double s) -> Eigen::VectorXd { return a + s * (b - a); });
    MotionInterval stretch;
    motion.stretch(from, to, stretch);
    EXPECT_EQ(stretch.rest.maxCoeff(), 0);
  }
}

TEST(JointMotion, APolylineStaysNearTheLineOfItsPart) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> joint(-1, 1);
  for (int round = 0; round < 200; ++round) {
    std::vector<Eigen::VectorXd> waypoints(1 + static_cast<std::size_t>(round) % 6);
    for (auto& q : waypoints) q = Eigen::Vector2d(joint(random), joint(random));
    const auto at = [&](double s) -> Eigen::VectorXd {
      if (waypoints.size() == 1) return waypoints.front();
      const double place = s * static_cast<double>(waypoints.size() - 1);
      const std::size_t before = std::min(static_cast<std::size_t>(place), waypoints.size() - 2);
      return waypoints[before] +
             (place - static_cast<double>(before)) * (waypoints[before + 1] - waypoints[before]);
    };
    const PolylineMotion motion(waypoints);
    const auto [from, to] = part(random);
    expectNearTheLine(motion, from, to, at);
    // Both at once: the one's joints, then the other's.
    const Eigen::VectorXd a = Eigen::Vector2d(0, 1), b = Eigen::Vector2d(2, -1);
    const SegmentMotion segment(a, b);
    expectNearTheLine(BothMotions(motion, segment), from, to, [&](double s) -> Eigen::VectorXd {
      Eigen::VectorXd both(4);
      both << at(s), a + s * (b - a);
      return both;
    });
  }
}

}  // namespace
}  // namespace handover::test
