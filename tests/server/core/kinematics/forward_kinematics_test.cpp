// SPDX-License-Identifier: Apache-2.0
#include "arms.hpp"

#include <Eigen/SVD>
#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>

namespace handover::test {
namespace {

class EveryArm : public testing::TestWithParam<NamedArm> {
 protected:
  RobotModel model_ = GetParam().make();
  ArmKinematics arm_{model_, ArmId(0)};
};

INSTANTIATE_TEST_SUITE_P(ArmKinematics, EveryArm, testing::ValuesIn(kArms), armName);

KDL::Frame toKdl(const Pose& X) {
  const auto& R = X.linear();
  return {KDL::Rotation(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1),
                        R(2, 2)),
          KDL::Vector(X.translation().x(), X.translation().y(), X.translation().z())};
}

KDL::Chain kdlChain(const RobotModel& model) {
  KDL::Chain chain;
  for (const Joint& joint : model.joints) {
    const KDL::Frame X = toKdl(joint.X_PJ);
    const KDL::Vector axis = X.M * KDL::Vector(joint.axis.x(), joint.axis.y(), joint.axis.z());
    if (joint.type == JointType::kFixed) {
      chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), X));
    } else {
      const auto type =
          joint.type == JointType::kRevolute ? KDL::Joint::RotAxis : KDL::Joint::TransAxis;
      chain.addSegment(KDL::Segment(KDL::Joint(X.p, axis, type), X));
    }
  }
  return chain;
}

TEST_P(EveryArm, ToolPoseAgreesWithKdl) {
  const KDL::Chain chain = kdlChain(model_);
  KDL::ChainFkSolverPos_recursive solver(chain);
  RandomConfigurations configurations(arm_, 1);
  for (int k = 0; k < 1000; ++k) {
    const ArmVector q = configurations.next();
    KDL::JntArray joints(chain.getNrOfJoints());
    for (int i = 0; i < q.size(); ++i) joints(i) = q[i];
    KDL::Frame expected;
    ASSERT_EQ(solver.JntToCart(joints, expected), 0);
    const Pose X_AT = arm_.toolPose(q);
    for (int row = 0; row < 3; ++row) {
      EXPECT_NEAR(X_AT.translation()[row], expected.p[row], 1e-12);
      for (int column = 0; column < 3; ++column) {
        EXPECT_NEAR(X_AT.linear()(row, column), expected.M(row, column), 1e-12);
      }
    }
  }
}

TEST_P(EveryArm, JacobianIsTheDerivativeOfTheToolPose) {
  constexpr double kStep = 1e-6;
  RandomConfigurations configurations(arm_, 2);
  for (int k = 0; k < 200; ++k) {
    const ArmVector q = configurations.next();
    ArmJacobian J;
    EXPECT_EQ(arm_.toolPose(q, J).matrix(), arm_.toolPose(q).matrix());
    ASSERT_EQ(J.cols(), arm_.dofs());
    for (int i = 0; i < q.size(); ++i) {
      ArmVector q_plus = q, q_minus = q;
      q_plus[i] += kStep;
      q_minus[i] -= kStep;
      const Pose plus = arm_.toolPose(q_plus), minus = arm_.toolPose(q_minus);
      const Eigen::Vector3d linear = (plus.translation() - minus.translation()) / (2 * kStep);
      const Eigen::Matrix3d spin =
          (plus.linear() - minus.linear()) / (2 * kStep) * arm_.toolPose(q).linear().transpose();
      EXPECT_NEAR((J.col(i).head<3>() - linear).norm(), 0, 1e-8);
      EXPECT_NEAR((J.col(i).tail<3>() - Eigen::Vector3d(spin(2, 1), spin(0, 2), spin(1, 0))).norm(),
                  0, 1e-8);
    }
  }
}

TEST_P(EveryArm, ManipulabilityIsTheProductOfTheSingularValues) {
  RandomConfigurations configurations(arm_, 3);
  for (int k = 0; k < 1000; ++k) {
    const ArmVector q = configurations.next();
    const Eigen::MatrixXd J = arm_.jacobian(q);
    const double expected = Eigen::JacobiSVD<Eigen::MatrixXd>(J).singularValues().prod();
    EXPECT_NEAR(arm_.manipulability(q), expected, 1e-9);
  }
}

TEST_P(EveryArm, ReachBoundsEveryToolPose) {
  RandomConfigurations configurations(arm_, 4);
  for (int k = 0; k < 1000; ++k) {
    EXPECT_LE(arm_.toolPose(configurations.next()).translation().norm(), arm_.reach() + 1e-12);
  }
}

TEST_P(EveryArm, FindsOutWhetherTheClosedFormApplies) {
  EXPECT_EQ(arm_.closedForm(), GetParam().closed_form);
}

TEST(ArmKinematics, PutsTheLwa4WhereItsAuthorsPosturesDo) {
  // Published joint angles of ana-GT's crichton_global.cpp; the wrist is 0.225 m behind the grasp
  // point.
  const RobotModel model = lwa4Arm();
  const ArmKinematics arm(model, ArmId(0));
  const auto wrist = [&](const ArmVector& q) {
    const Pose X_AT = arm.toolPose(q);
    return Eigen::Vector3d(X_AT * Eigen::Vector3d(0, 0, -0.225));
  };
  const auto palm = [&](const ArmVector& q) {
    return Eigen::Vector3d(arm.toolPose(q).linear().col(2));
  };
  const ArmVector resting = degrees({0, -30, 0, -45, 0, 0, 30});
  EXPECT_NEAR((wrist(resting) - Eigen::Vector3d(0.476, 0.668, 0)).norm(), 0, 1e-3);
  EXPECT_NEAR((palm(resting) - Eigen::Vector3d(0.97, 0.26, 0)).norm(), 0, 1e-2);
  const ArmVector arc_up = degrees({90, -30, 0, -60, 0, -40, 0});
  EXPECT_NEAR((wrist(arc_up) - Eigen::Vector3d(0, 0.584, 0.487)).norm(), 0, 1e-3);
  EXPECT_NEAR((palm(arc_up) - Eigen::Vector3d(0, 0.64, 0.77)).norm(), 0, 1e-2);
}

TEST(ArmKinematics, FindsTheShoulderWhereTheFirstThreeAxesMeet) {
  EXPECT_NEAR((ArmKinematics(lwa4Arm(), ArmId(0)).shoulder() - Eigen::Vector3d(0, 0.3, 0)).norm(),
              0, 1e-12);
  EXPECT_NEAR(
      (ArmKinematics(lwa4RoughArm(), ArmId(0)).shoulder() - Eigen::Vector3d(0, 0.3, 0)).norm(), 0,
      1e-3);
  EXPECT_NEAR(
      (ArmKinematics(huboArm(1), ArmId(0)).shoulder() - Eigen::Vector3d(0.001, 0.2295, 0.2061))
          .norm(),
      0, 1e-12);
  EXPECT_NEAR(
      (ArmKinematics(huboArm(-1), ArmId(0)).shoulder() - Eigen::Vector3d(0.001, -0.2295, 0.2061))
          .norm(),
      0, 1e-12);
}

TEST(ArmKinematics, TakesAsShoulderWhereTheFirstTwoAxesMeetIfThreeDoNot) {
  EXPECT_NEAR(
      (ArmKinematics(sixAxisArm(), ArmId(0)).shoulder() - Eigen::Vector3d(0, 0, 0.0892)).norm(), 0,
      1e-12);
  EXPECT_NEAR(
      (ArmKinematics(ur5eArm(), ArmId(0)).shoulder() - Eigen::Vector3d(0, 0, 0.1625)).norm(), 0,
      1e-12);
}

TEST(ArmKinematics, TakesTheFirstJointAsShoulderWhereNoAxesMeet) {
  EXPECT_NEAR(ArmKinematics(planarArm(), ArmId(0)).shoulder().norm(), 0, 1e-12);
}

TEST(ArmKinematics, LetsTheModelOverrideTheShoulder) {
  RobotModel model = lwa4Arm();
  model.arms[0].p_AShoulder = Eigen::Vector3d(1, 2, 3);
  EXPECT_EQ(ArmKinematics(model, ArmId(0)).shoulder(), Eigen::Vector3d(1, 2, 3));
}

TEST(ArmKinematics, TakesLimitsFromTheJoints) {
  const ArmKinematics arm(huboArm(-1), ArmId(0));
  EXPECT_DOUBLE_EQ(arm.lower()[1], -3.14);
  EXPECT_DOUBLE_EQ(arm.upper()[1], 0.262);
  EXPECT_DOUBLE_EQ(arm.velocity()[3], 1);
  EXPECT_DOUBLE_EQ(arm.acceleration()[6], 0.8);
  ArmVector q = ArmVector::Zero(7);
  EXPECT_TRUE(arm.withinLimits(q));
  q[1] = 0.262 + 1e-6;
  EXPECT_FALSE(arm.withinLimits(q));
  EXPECT_TRUE(arm.withinLimits(q, 1e-5));
  q[1] = std::nan("");
  EXPECT_FALSE(arm.withinLimits(q));
  EXPECT_FALSE(arm.withinLimits(ArmVector::Zero(6)));
}

TEST(ArmKinematics, RefusesChainsThatItCannotHandle) {
  const Eigen::Vector3d z(0, 0, 1), none(0, 0, 0);
  ArmBuilder nine("nine");
  for (int i = 0; i < 9; ++i) nine.revolute({0.1, 0, 0}, none, z, -1, 1);
  EXPECT_THROW(ArmKinematics(nine.build(), ArmId(0)), std::invalid_argument);

  const RobotModel good = lwa4Arm();
  EXPECT_THROW(ArmKinematics(good, ArmId(1)), std::invalid_argument);
  EXPECT_THROW(ArmKinematics(good, ArmId()), std::invalid_argument);

  RobotModel model = good;
  model.joints[3].mimic = true;
  EXPECT_THROW(ArmKinematics(model, ArmId(0)), std::invalid_argument);
  model = good;
  model.arms[0].joints.pop_back();
  EXPECT_THROW(ArmKinematics(model, ArmId(0)), std::invalid_argument);
  model = good;
  std::swap(model.arms[0].base_link, model.arms[0].tool_link);
  EXPECT_THROW(ArmKinematics(model, ArmId(0)), std::invalid_argument);
  model = good;
  model.joints[2].upper = INFINITY;
  EXPECT_THROW(ArmKinematics(model, ArmId(0)), std::invalid_argument);
  EXPECT_THROW(ArmKinematics(good, ArmId(0)).toolPose(ArmVector::Zero(6)), std::invalid_argument);
}

}  // namespace
}  // namespace handover::test
