// SPDX-License-Identifier: Apache-2.0
#include "core/planning/timed_motion.hpp"

#include "core/motion/timing.hpp"
#include "stretches.hpp"

#include <algorithm>
#include <random>

namespace handover::test {
namespace {

class TimedMotionTest : public testing::Test {
 protected:
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  Eigen::VectorXd vector(double most) {
    return Eigen::Vector3d(uniform(-most, most), uniform(-most, most), uniform(-most, most));
  }

  /// Of part of a part of the path's time, or of what is before and after.
  void expectEnclosed(const TimedPath& path) {
    const double begin = uniform(-1, 1) * path.duration();
    const double end = begin + uniform(0, 2) * path.duration();
    const TimedMotion motion(path, begin, end);
    const auto at = [&](double s) { return evaluate(path, begin + s * (end - begin)); };
    const double a = uniform(0, 1), b = uniform(0, 1);
    expectNearTheLine(motion, std::min(a, b), std::max(a, b), at);
    expectNearTheLine(motion, 0, 1, at);
  }

  std::mt19937_64 random_{5};
};

TEST_F(TimedMotionTest, EnclosesTimedPaths) {
  const Eigen::Vector3d most = Eigen::Vector3d::Constant(2), acceleration(2, 1, 3);
  const TimingLimits limits{-most, most, Eigen::Vector3d(1, 2, 0.5), acceleration,
                            10 * acceleration};
  for (int round = 0; round < 60; ++round) {
    std::vector<Eigen::VectorXd> waypoints(2 + static_cast<std::size_t>(round) % 3);
    for (auto& q : waypoints) q = vector(1);
    const auto path = parameterize(waypoints, limits, {});
    ASSERT_TRUE(path);
    expectEnclosed(*path);
    const TimedMotion motion(*path);
    // Smooth as it is, what the line leaves goes down with the square of the part.
    MotionInterval whole, tenth;
    motion.stretch(0.4, 0.5, whole);
    motion.stretch(0.44, 0.45, tenth);
    EXPECT_LE(tenth.rest.maxCoeff(), 0.1 * whole.rest.maxCoeff() + 1e-9);
  }
}

TEST_F(TimedMotionTest, EnclosesAnyQuintics) {
  for (int round = 0; round < 300; ++round) {
    TimedPath path;
    double t = 0;
    const int samples = 2 + round % 5;
    for (int i = 0; i < samples; ++i) {
      path.t.push_back(t);
      t += uniform(0.01, 0.5);
      path.q.push_back(vector(1));
      path.qd.push_back(vector(3));
      path.qdd.push_back(vector(50));
    }
    expectEnclosed(path);
  }
}

TEST_F(TimedMotionTest, EnclosesTightly) {
  // 10 x^3 - 15 x^4 + 6 x^5: farthest from its chord at 10 x^3 - 15 x^4 + 6 x^5 - x.
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(1), one = Eigen::VectorXd::Ones(1);
  const TimedPath path{{0, 1}, {zero, one}, {zero, zero}, {zero, zero}};
  MotionInterval stretch;
  TimedMotion(path).stretch(0, 1, stretch);
  EXPECT_DOUBLE_EQ(stretch.q_middle[0], 0.5);
  EXPECT_DOUBLE_EQ(stretch.along[0], 0.5);
  EXPECT_DOUBLE_EQ(stretch.rest[0], 0.4);  // control points 0 0 0 1 1 1 against 0 0.2 0.4 0.6 0.8 1
  TimedMotion(path).stretch(0.5, 0.5, stretch);
  EXPECT_NEAR(stretch.along[0], 0, 1e-15);
  EXPECT_NEAR(stretch.rest[0], 0, 1e-15);
  TimedMotion(path, -3, -1).stretch(0, 1, stretch);
  EXPECT_EQ(stretch.q_middle, zero);
  EXPECT_EQ(stretch.along, zero);
  EXPECT_EQ(stretch.rest, zero);
}

}  // namespace
}  // namespace handover::test
