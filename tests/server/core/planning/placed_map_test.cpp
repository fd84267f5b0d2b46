// SPDX-License-Identifier: Apache-2.0
#include "core/planning/handover_pose.hpp"
#include "support/arm_models.hpp"
#include "support/random_configurations.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <random>
#include <stdexcept>

namespace handover::test {
namespace {

using Eigen::Vector3d;

/// An arm that stands somewhere, turned, with a map of its own.
class PlacedArm {
 public:
  explicit PlacedArm(const RobotModel& model, const ReachabilityParams& params = {})
      : kinematics(model, ArmId(0)), approach_T_(model.arms.front().approach_axis) {
    const RobotVector q = RobotVector::Zero(model.dofs());
    const auto file = folder_ / "map";
    const auto built = ReachabilityMap::build(model, q, params, {}, {file}, {}, Deadline());
    if (!built) throw std::runtime_error(built.error().detail);
    map_ = ReachabilityMap::open(file, ReachabilityMap::hash(model, ArmId(0), q, params)).value();
    placed.map = map_.get();
    placed.X_WA = Eigen::Translation3d(1, -2, 0.5) *
                  Eigen::AngleAxisd(2.0, Vector3d(0.1, -0.3, 1).normalized());
  }

  bool near(const Pose& X_AT) const {
    const Pose X_WT = placed.X_WA * X_AT;
    return placed.near(X_WT.translation(), X_WT.linear() * approach_T_);
  }

  ArmKinematics kinematics;
  RandomConfigurations configurations{kinematics, 23};
  PlacedMap placed;

 private:
  TemporaryFolder folder_;
  std::shared_ptr<const ReachabilityMap> map_;
  Vector3d approach_T_;
};

TEST(PlacedMap, HasSeenAlmostEveryPoseThatTheArmReaches) {
  for (const RobotModel& model : {ur5eArm(), pandaArm(), iiwa14Arm()}) {
    PlacedArm arm(model);
    int missed = 0;
    for (int i = 0; i < 5000; ++i) {
      if (!arm.near(arm.kinematics.toolPose(arm.configurations.next()))) ++missed;
    }
    EXPECT_LE(missed, 25) << model.name;
  }
}

TEST(PlacedMap, TellsMostPosesThatTheArmDoesNotReach) {
  for (const RobotModel& model : {ur5eArm(), pandaArm()}) {
    PlacedArm arm(model);
    std::mt19937_64 random(23);
    std::normal_distribution<double> normal;
    int out_of_reach = 0, told = 0;
    while (out_of_reach < 500) {
      Pose X_AT = Pose::Identity();
      X_AT.linear() =
          Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
              .normalized()
              .toRotationMatrix();
      X_AT.translation() = Vector3d(normal(random), normal(random), normal(random));
      if (X_AT.translation().norm() > arm.kinematics.reach()) continue;
      std::vector<ArmVector> solutions;
      IkQuery query;
      query.swivel_samples = 16;
      arm.kinematics.solve(X_AT, query, solutions);
      if (!solutions.empty()) continue;
      ++out_of_reach;
      if (!arm.near(X_AT)) ++told;
    }
    EXPECT_GE(told, 400) << model.name;
  }
}

// The approach axis of an arm that moves in a plane may lie on the border of two bins.
TEST(PlacedMap, TakesADirectionOnABorderForEitherBin) {
  RobotModel model = planarArm();
  model.arms.front().approach_axis = Vector3d::UnitX();
  PlacedArm arm(model, {.samples = 100'000});
  for (int i = 0; i < 200; ++i) {
    const Pose X_AT = arm.kinematics.toolPose(arm.configurations.next());
    for (const double aside : {0.0, 1e-9, -1e-9}) {
      EXPECT_TRUE(arm.near(X_AT * Eigen::AngleAxisd(aside, Vector3d::UnitY())));
    }
    EXPECT_FALSE(arm.near(X_AT * Eigen::AngleAxisd(0.5, Vector3d::UnitY())));
  }
}

}  // namespace
}  // namespace handover::test
