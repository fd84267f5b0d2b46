// SPDX-License-Identifier: Apache-2.0
#include "core/collision/tilt_limit.hpp"

#include "core/collision/state_checker.hpp"
#include "jointed_bodies.hpp"

#include <gtest/gtest.h>

#include <random>

namespace handover::test {
namespace {

constexpr double kDegree = M_PI / 180;

/// A chain of joints, and its groups.
struct Chain {
  explicit Chain(const std::vector<JointedBody>& joints) : robot(chainOf("chain", joints)) {
    for (std::size_t j = 0; j < joints.size(); ++j) dofs.emplace_back(j);
    groups.emplace(*robot.model, dofs);
    std::vector<Pose> X_WL;
    linkPoses(*robot.model, robot.X_WB, robot.q_start, X_WL);
    groups->setPosture(*robot.model, X_WL);
  }

  int last() const { return groups->size() - 1; }

  bool keeps(const TiltLimit& limit, const JointMotion& motion,
             const Eigen::Matrix3d& R_GO = Eigen::Matrix3d::Identity()) {
    return keepsTilt(*groups, last(), R_GO, limit, motion, 0, 1);
  }

  SceneRobot robot;
  std::vector<DofId> dofs;
  std::optional<RigidGroups> groups;
};

class TiltProof : public testing::Test {
 protected:
  double in(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  Eigen::Vector3d direction() {
    Eigen::Vector3d v;
    do {
      v = {in(-1, 1), in(-1, 1), in(-1, 1)};
    } while (v.norm() < 0.1 || v.norm() > 1);
    return v.normalized();
  }

  /// Hinges about any axes, now and then a slide.
  Chain anyChain() {
    std::vector<JointedBody> joints(5);
    for (JointedBody& joint : joints) {
      joint.type = in(0, 1) < 0.15 ? JointType::kPrismatic : JointType::kRevolute;
      joint.p_PJ = direction();
      joint.axis = direction();
    }
    return Chain(joints);
  }

  Eigen::VectorXd anyState(double size) {
    Eigen::VectorXd q(5);
    for (double& value : q) value = in(-size, size);
    return q;
  }

  std::mt19937_64 random_{5};
};

TEST_F(TiltProof, OfAHingeAcrossIsItsAngle) {
  Chain hinge({{JointType::kRevolute, {0, 0, 0}, {1, 0, 0}, {}}});
  const TiltLimit limit{Eigen::Vector3d::UnitZ(), 0.3};
  EXPECT_TRUE(hinge.keeps(limit, Straight(-0.3, 0.2)));
  EXPECT_TRUE(hinge.keeps(limit, Straight(-0.2, 0.3)));
  EXPECT_FALSE(hinge.keeps(limit, Straight(-0.2, 0.3001)));
  EXPECT_FALSE(hinge.keeps(limit, Straight(-0.3001, 0.2)));
}

TEST_F(TiltProof, AHingeAboutTheVerticalOrTheAxisItselfTiltsNothing) {
  Chain vertical({{JointType::kRevolute, {0, 0, 0}, {0, 0, 1}, {}}});
  EXPECT_TRUE(vertical.keeps({Eigen::Vector3d::UnitZ(), 0}, Straight(-3, 3)));
  // Leaning all the time, on the limit.
  const Eigen::Vector3d leaning(std::sin(0.4), 0, std::cos(0.4));
  EXPECT_TRUE(vertical.keeps({leaning, 0.4}, Straight(-3, 3)));
  EXPECT_FALSE(vertical.keeps({leaning, 0.3999}, Straight(-3, 3)));
  Chain own({{JointType::kRevolute, {0, 0, 0}, leaning, {}}});
  EXPECT_TRUE(own.keeps({leaning, 0.4}, Straight(-3, 3)));
}

TEST_F(TiltProof, SeesWhatLeansOnTheWayBetweenUprightEnds) {
  // Two hinges about one axis, one after the other: upright at both ends.
  Chain two({{JointType::kRevolute, {0, 0, 0}, {0, 1, 0}, {}},
             {JointType::kRevolute, {1, 0, 0}, {0, 1, 0}, {}}});
  const auto over = [](double peak) {
    return PolylineMotion(std::vector<Eigen::VectorXd>{
        Eigen::Vector2d(0, 0), Eigen::Vector2d(peak, 0), Eigen::Vector2d(peak, -peak)});
  };
  EXPECT_TRUE(two.keeps({Eigen::Vector3d::UnitZ(), 0.5}, over(0.499)));
  EXPECT_FALSE(two.keeps({Eigen::Vector3d::UnitZ(), 0.5}, over(0.501)));
}

TEST_F(TiltProof, TurnsNoFartherThanTheBound) {
  double tightest = 0;
  for (int round = 0; round < 500; ++round) {
    Chain chain = anyChain();
    const MotionInterval stretch{anyState(2), anyState(round % 3 == 2 ? 0 : 0.3),
                                 anyState(round % 3 == 0 ? 0 : 0.1).cwiseAbs()};
    const Eigen::Vector3d direction_W = direction(), axis_G = direction();
    const auto angle = [&](const Eigen::VectorXd& q) {
      chain.groups->place(q);
      const Eigen::Vector3d axis_W = chain.groups->pose(chain.last()).linear() * axis_G;
      return std::atan2(axis_W.cross(direction_W).norm(), axis_W.dot(direction_W));
    };
    const double middle = angle(stretch.q_middle);
    const double bound = chain.groups->turn(chain.last(), direction_W, stretch);
    for (int k = 0; k < 30; ++k) {
      Eigen::VectorXd q = stretch.q_middle + (k < 2 ? 2 * k - 1 : in(-1, 1)) * stretch.along;
      for (Eigen::Index j = 0; j < q.size(); ++j) q[j] += in(-1, 1) * stretch.rest[j];
      const double turned = std::abs(angle(q) - middle);
      EXPECT_LE(turned, bound + 1e-12);
      if (bound > 0.05) tightest = std::max(tightest, turned / bound);
    }
  }
  EXPECT_GT(tightest, 0.8);
}

TEST_F(TiltProof, SaysWhatDenseSamplesSay) {
  int kept = 0, broken = 0, nearly = 0;
  for (int round = 0; round < 400; ++round) {
    Chain chain = anyChain();
    const Straight motion(anyState(0.6), anyState(0.6));
    const Eigen::Matrix3d R_GO = Eigen::AngleAxisd(in(0, 3), direction()).toRotationMatrix();
    const Eigen::Vector3d axis_O = direction();
    double most = 0;
    MotionInterval at;
    for (int k = 0; k <= 4000; ++k) {
      motion.stretch(k / 4000.0, k / 4000.0, at);
      chain.groups->place(at.q_middle);
      most = std::max(most, tiltOf(chain.groups->pose(chain.last()).linear() * (R_GO * axis_O)));
    }
    // Beyond the tilt, short of it, and just about it: samples miss 1e-5 at most.
    const double by = round % 3 == 0 ? in(0, 0.5) : round % 3 == 1 ? -in(0, 0.5) : in(-1, 1) * 1e-4;
    const TiltLimit limit{axis_O, most + by};
    const bool keeps = chain.keeps(limit, motion, R_GO);
    if (keeps) {
      EXPECT_GE(by, -kTiltSlack);
    } else {
      EXPECT_LE(by, 1e-5);
    }
    (keeps ? kept : broken)++;
    nearly += std::abs(by) < 1e-4 ? 1 : 0;
  }
  EXPECT_GT(kept, 100);
  EXPECT_GT(broken, 100);
  EXPECT_GT(nearly, 100);
}

TEST_F(TiltProof, IsKeptByWhatIsTurnedBack) {
  int turned = 0;
  for (int round = 0; round < 300; ++round) {
    const Eigen::Matrix3d R_WO = Eigen::AngleAxisd(in(0, 3), direction()).toRotationMatrix();
    const TiltLimit limit{direction(), in(0.01, 2)};
    const double tilt = tiltOf(R_WO * limit.axis_O);
    const Eigen::AngleAxisd turn = limit.turnWithin(R_WO);
    Pose X_WO = Pose::Identity();
    X_WO.linear() = turn * R_WO;
    EXPECT_TRUE(limit.keeps(X_WO));
    // No turn does with less than what the tilt is too much.
    EXPECT_NEAR(turn.angle(), tilt > limit.most ? tilt - limit.within() : 0, 1e-12);
    turned += turn.angle() > 0 ? 1 : 0;
  }
  EXPECT_GT(turned, 50);
  const TiltLimit upright{Eigen::Vector3d::UnitZ(), 0.1};
  const Eigen::Matrix3d R_over =
      Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitY()).toRotationMatrix();
  EXPECT_NEAR(tiltOf(upright.turnWithin(R_over) * (R_over * upright.axis_O)), upright.within(),
              1e-9);
}

/// A hinge about the world's x with a ball on it, which holds a box 1 m away.
class TiltedHold : public testing::Test {
 protected:
  TiltedHold() {
    scene_.robots = {
        chainOf("arm", {{JointType::kRevolute, {0, 0, 0}, {1, 0, 0}, {sphereAt(0.1, {0, 0, 0})}}})};
    scene_.objects = {objectOf("box", boxAt({0.1, 0.1, 0.1}, {0, 0, 0}), {0, 0, 1}),
                      objectOf("wall", boxAt({1, 0.1, 1}, {0, 0, 0}), {0, -0.85, 0})};
    collision_ = std::make_shared<const CollisionScene>(scene_);
    world_.emplace(collision_);
  }

  StateChecker checker(std::optional<TiltLimit> tilt) {
    StateCheckerSetup setup(*collision_, RobotId(0), {DofId(0)});
    setup.held = HeldObject{ObjectId(0), LinkId(1), Pose(Eigen::Translation3d(0, 0, 1)), tilt};
    return StateChecker(*world_, setup);
  }

  static Eigen::VectorXd at(double q) { return Eigen::VectorXd::Constant(1, q); }

  Scene scene_;
  std::shared_ptr<const CollisionScene> collision_;
  std::optional<CollisionWorld> world_;
};

TEST_F(TiltedHold, IsNotValidBeyondItsLimitThoughNothingTouches) {
  StateChecker any = checker(std::nullopt);
  StateChecker upright = checker(TiltLimit{Eigen::Vector3d::UnitZ(), 10 * kDegree});
  EXPECT_TRUE(any.valid(at(11 * kDegree)));
  EXPECT_TRUE(upright.valid(at(9.9 * kDegree)));
  EXPECT_FALSE(upright.valid(at(10.1 * kDegree)));
  EXPECT_FALSE(upright.valid(at(-10.1 * kDegree)));
  EXPECT_FALSE(upright.hit(at(10.1 * kDegree)));
  EXPECT_EQ(upright.tilted(), 2u);
  EXPECT_EQ(upright.touched(), 0u);
}

TEST_F(TiltedHold, MayNotBeMovedBeyondItsLimitOrIntoSomething) {
  StateChecker any = checker(std::nullopt);
  StateChecker upright = checker(TiltLimit{Eigen::Vector3d::UnitZ(), 30 * kDegree});
  EXPECT_TRUE(any.isMotionFree(Straight(-0.6, 0.6)));
  EXPECT_FALSE(upright.isMotionFree(Straight(-0.6, 0.6)));
  EXPECT_FALSE(upright.keepsTilt(Straight(-0.6, 0.6)));
  EXPECT_TRUE(upright.isMotionFree(Straight(-0.5, 0.5)));
  EXPECT_EQ(upright.tilted(), 1u);
  StateChecker wide = checker(TiltLimit{Eigen::Vector3d::UnitZ(), 120 * kDegree});
  EXPECT_TRUE(wide.keepsTilt(Straight(0, 2)));
  EXPECT_FALSE(wide.isMotionFree(Straight(0, 2)));  // the wall
  EXPECT_EQ(wide.tilted(), 0u);
  EXPECT_EQ(wide.touched(), 1u);
}

TEST_F(TiltedHold, IsAsItIsHeld) {
  // Held upside down, the object's -z is what has to point up.
  StateChecker upright = checker(TiltLimit{-Eigen::Vector3d::UnitZ(), 10 * kDegree});
  EXPECT_FALSE(upright.valid(at(0)));
  upright.setHold(Eigen::Translation3d(0, 0, 1) *
                  Pose(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitY())));
  EXPECT_TRUE(upright.valid(at(0)));
  EXPECT_FALSE(upright.keepsTilt(Straight(0, 0.2)));
}

}  // namespace
}  // namespace handover::test
