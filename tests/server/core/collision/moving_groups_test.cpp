// SPDX-License-Identifier: Apache-2.0
#include "core/collision/moving_groups.hpp"

#include "small_robots.hpp"

#include <gtest/gtest.h>

#include <random>

namespace handover::test {
namespace {

class MovingGroupsTest : public testing::Test {
 protected:
  double in(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  /// The arm's two hinges and, after them, the fingers' slide with its mimic.
  const std::vector<int> dofs_{0, 1, 2};
  std::shared_ptr<const RobotModel> model_ = twoArmRobot();
  MovingGroups groups_{*model_, dofs_};
  std::mt19937_64 random_{7};

  void SetUp() override {
    std::vector<Pose> X_WL;
    linkPoses(*model_, Pose::Identity(), RobotVector::Zero(model_->dofs()), X_WL);
    groups_.setPosture(*model_, X_WL);
  }
};

TEST_F(MovingGroupsTest, StandWhereTheLinksStand) {
  for (int round = 0; round < 50; ++round) {
    RobotVector q = RobotVector::Zero(model_->dofs());
    for (const int dof : dofs_) q[dof] = in(-2, 2);
    std::vector<Pose> X_WL;
    linkPoses(*model_, Pose::Identity(), q, X_WL);
    groups_.place(q.head(3));
    for (int group = 0; group < groups_.size(); ++group) {
      EXPECT_TRUE(groups_.pose(group).isApprox(
          X_WL[static_cast<std::size_t>(groups_.linkOf(group))], 1e-12));
    }
  }
  EXPECT_EQ(groups_.groupOf(model_->findLink("left_palm")),
            groups_.groupOf(model_->findLink("left_lower")));
  EXPECT_EQ(groups_.groupOf(model_->findLink("right_lower")), -1);
}

TEST_F(MovingGroupsTest, NothingTravelsFartherThanTheBound) {
  const int outer = groups_.groupOf(model_->findLink("left_finger_b"));
  const int inner = groups_.groupOf(model_->findLink("left_upper"));
  const Ball ball{{0.1, -0.05, 0.02}, 0.04}, other{{0.2, 0, 0}, 0.03};
  groups_.setBall(outer, ball);
  std::vector<double> seen_outer(static_cast<std::size_t>(groups_.levels())),
      seen_inner = seen_outer;
  double tightest = 0;
  for (int round = 0; round < 300; ++round) {
    Eigen::VectorXd q(3), stray(3);
    for (int j = 0; j < 3; ++j) {
      q[j] = in(-2, 2);
      stray[j] = in(0, 0.3);
    }
    groups_.place(q);
    groups_.boundTravel(stray);
    const double travel = groups_.travel(outer);
    groups_.travels(outer, ball, seen_outer.data());
    groups_.travels(inner, other, seen_inner.data());
    const double approach = groups_.approach(outer, seen_outer.data(), inner, seen_inner.data());
    const Eigen::Vector3d direction = Eigen::Vector3d(in(-1, 1), in(-1, 1), in(-1, 1)).normalized();
    const Eigen::Vector3d p_G = ball.middle + ball.radius * direction;
    const Eigen::Vector3d p_G_other = other.middle - other.radius * direction;
    const Eigen::Vector3d before = groups_.pose(outer) * p_G;
    const double apart = (before - groups_.pose(inner) * p_G_other).norm();
    for (int k = 0; k < 20; ++k) {
      Eigen::VectorXd strayed = q;
      for (int j = 0; j < 3; ++j) strayed[j] += (k < 4 ? 1 - 2 * (k % 2) : in(-1, 1)) * stray[j];
      groups_.place(strayed);
      const Eigen::Vector3d after = groups_.pose(outer) * p_G;
      EXPECT_LE((after - before).norm(), travel);
      EXPECT_LE(apart - (after - groups_.pose(inner) * p_G_other).norm(), approach);
      tightest = std::max(tightest, (after - before).norm() / travel);
    }
  }
  EXPECT_GT(tightest, 0.8);  // a bound, not a guess far above
}

}  // namespace
}  // namespace handover::test
