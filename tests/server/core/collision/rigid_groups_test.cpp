// SPDX-License-Identifier: Apache-2.0
#include "core/collision/rigid_groups.hpp"

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
  const std::vector<DofId> dofs_{DofId(0), DofId(1), DofId(2)};
  std::shared_ptr<const RobotModel> model_ = twoArmRobot();
  RigidGroups groups_{*model_, dofs_};
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
    for (const DofId dof : dofs_) q[dof.value()] = in(-2, 2);
    std::vector<Pose> X_WL;
    linkPoses(*model_, Pose::Identity(), q, X_WL);
    groups_.place(q.head(3));
    for (int group = 0; group < groups_.size(); ++group) {
      EXPECT_TRUE(groups_.pose(group).isApprox(X_WL[groups_.linkOf(group)], 1e-12));
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
  groups_.setBall(inner, other);
  double tightest = 0, tightest_beyond = 0;
  for (int round = 0; round < 300; ++round) {
    // Straight motions, bent ones, and some that go anywhere.
    MotionInterval stretch{Eigen::VectorXd(3), Eigen::VectorXd(3), Eigen::VectorXd(3)};
    for (int j = 0; j < 3; ++j) {
      stretch.q_middle[j] = in(-2, 2);
      stretch.along[j] = round % 3 == 2 ? 0 : in(-0.3, 0.3);
      stretch.rest[j] = round % 3 == 0 ? 0 : in(0, 0.1);
    }
    groups_.place(stretch.q_middle);
    groups_.boundTravel(stretch);
    const double travel = groups_.travel(outer);
    const PairMotion in_world = groups_.approach(outer, -1), pair = groups_.approach(outer, inner);
    EXPECT_EQ(pair.b.w.norm() + pair.b.v.norm(), 0);  // the outer one hangs on it
    const Eigen::Vector3d direction = Eigen::Vector3d(in(-1, 1), in(-1, 1), in(-1, 1)).normalized();
    const Eigen::Vector3d p_G = ball.middle + ball.radius * direction;
    const Pose X_WInner = groups_.pose(inner);
    const Eigen::Vector3d before = groups_.pose(outer) * p_G;
    for (int k = 0; k < 20; ++k) {
      const double x = k < 4 ? 1 - 2 * (k % 2) : in(-1, 1);
      Eigen::VectorXd strayed = stretch.q_middle + x * stretch.along;
      for (int j = 0; j < 3; ++j) strayed[j] += in(-1, 1) * stretch.rest[j];
      groups_.place(strayed);
      const Eigen::Vector3d after = groups_.pose(outer) * p_G;
      EXPECT_LE((after - before).norm(), travel);
      EXPECT_LE((after - before).norm(), in_world.most);
      const auto byTwist = [&](const Twist& twist) -> Eigen::Vector3d {
        return x * (twist.v + twist.w.cross(before));
      };
      const double beyond = (after - before - byTwist(in_world.a)).norm();
      EXPECT_LE(beyond, in_world.beyond + 1e-12);
      // As the inner one sees it.
      const Eigen::Vector3d seen = X_WInner * (groups_.pose(inner).inverse() * after);
      EXPECT_LE((seen - before).norm(), pair.most + 1e-12);
      EXPECT_LE((seen - before - byTwist(pair.a)).norm(), pair.beyond + 1e-12);
      tightest = std::max(tightest, (after - before).norm() / travel);
      tightest_beyond = std::max(tightest_beyond, beyond / in_world.beyond);
    }
  }
  EXPECT_GT(tightest, 0.8);  // bounds, not guesses far above
  EXPECT_GT(tightest_beyond, 0.4);
}

// Both fingers hang on the lower arm, which moves, too.
TEST_F(MovingGroupsTest, SiblingsMoveAgainstEachOtherAsTheirParentSeesIt) {
  const int a = groups_.groupOf(model_->findLink("left_finger_a"));
  const int b = groups_.groupOf(model_->findLink("left_finger_b"));
  const int parent = groups_.groupOf(model_->findLink("left_lower"));
  const Ball ball{{0.1, -0.05, 0.02}, 0.04};
  groups_.setBall(a, ball);
  groups_.setBall(b, ball);
  for (int round = 0; round < 200; ++round) {
    MotionInterval stretch{Eigen::VectorXd(3), Eigen::VectorXd(3), Eigen::VectorXd(3)};
    for (int j = 0; j < 3; ++j) {
      stretch.q_middle[j] = in(-2, 2);
      stretch.along[j] = in(-0.3, 0.3);
      stretch.rest[j] = in(0, 0.05);
    }
    groups_.place(stretch.q_middle);
    groups_.boundTravel(stretch);
    const PairMotion motion = groups_.approach(a, b);
    EXPECT_GT((motion.a.v - motion.b.v).norm(), 0);  // they slide apart
    const Pose X_WParent = groups_.pose(parent);
    const Eigen::Vector3d p_a = groups_.pose(a) * ball.middle, p_b = groups_.pose(b) * ball.middle;
    for (int k = 0; k < 20; ++k) {
      const double x = in(-1, 1);
      Eigen::VectorXd strayed = stretch.q_middle + x * stretch.along;
      for (int j = 0; j < 3; ++j) strayed[j] += in(-1, 1) * stretch.rest[j];
      groups_.place(strayed);
      const auto went = [&](int group, const Eigen::Vector3d& before) -> Eigen::Vector3d {
        return X_WParent * (groups_.pose(parent).inverse() * (groups_.pose(group) * ball.middle)) -
               before;
      };
      const auto byTwist = [&](const Twist& twist, const Eigen::Vector3d& p) -> Eigen::Vector3d {
        return x * (twist.v + twist.w.cross(p));
      };
      const Eigen::Vector3d apart = went(a, p_a) - went(b, p_b);
      EXPECT_LE(apart.norm(), motion.most + 1e-12);
      EXPECT_LE((apart - byTwist(motion.a, p_a) + byTwist(motion.b, p_b)).norm(),
                motion.beyond + 1e-12);
    }
  }
}

}  // namespace
}  // namespace handover::test
