// SPDX-License-Identifier: Apache-2.0
// The worked case of docs/collision_proof.md: the same numbers.
#include "core/collision/gjk.hpp"
#include "core/collision/narrow_phase.hpp"
#include "core/collision/rigid_groups.hpp"
#include "core/collision/state_checker.hpp"
#include "jointed_bodies.hpp"

#include <gtest/gtest.h>

namespace handover::test {
namespace {

constexpr double kRadius = 0.05;

// Two links in the plane z = 0: hinges about z at (0, 0) and, at q = 0, at (0.4, 0); on the second
// link a sphere with its middle 0.3 m from the second hinge.
SceneRobot twoLinks() {
  return chainOf(
      "two_links",
      {{JointType::kRevolute, {0, 0, 0}, {0, 0, 1}, {}},
       {JointType::kRevolute, {0.4, 0, 0}, {0, 0, 1}, {sphereAt(kRadius, {0.3, 0, 0})}}});
}

// A wall above the arm: its face is at y = `face`.
SceneObject wall(double face) {
  return objectOf("wall", boxAt({4, 0.1, 4}, {0, 0, 0}), {0, face + 0.05, 0});
}

class CollisionProof : public testing::Test {
 protected:
  CollisionProof() : groups_(*robot_.model, {DofId(0), DofId(1)}) {
    std::vector<Pose> X_WL;
    linkPoses(*robot_.model, Pose::Identity(), Eigen::Vector2d::Zero(), X_WL);
    groups_.setPosture(*robot_.model, X_WL);
    groups_.setBall(1, {{0.3, 0, 0}, kRadius});
  }

  // Of the sphere against the world, round q_middle.
  PairMotion motionOf(const Eigen::Vector2d& q_middle, const Eigen::Vector2d& along) {
    groups_.place(q_middle);
    groups_.boundTravel({q_middle, along, Eigen::Vector2d::Zero()});
    return groups_.approach(1, -1);
  }

  // What the looks at a wall say, its face at y = `face`.
  Nearness look(const PairMotion& motion, double face) const {
    const NarrowShape sphere(sphereAt(kRadius, {0, 0, 0}));
    const NarrowShape box(boxAt({4, 0.1, 4}, {0, 0, 0}));
    Pose X_WWall = Pose::Identity();
    X_WWall.translation() = Eigen::Vector3d(0, face + 0.05, 0);
    Pose X_WSphere = groups_.pose(1);
    X_WSphere.translation() = groups_.pose(1) * Eigen::Vector3d(0.3, 0, 0);
    // In coordinates of the sphere's own middle, the twist is the same: it is one of the world.
    return nearness(sphere, X_WSphere, box, X_WWall, motion, kPlannedClearance.looked,
                    kPlannedClearance.proven);
  }

  SceneRobot robot_ = twoLinks();
  RigidGroups groups_;
};

TEST_F(CollisionProof, BoundsTheTravelOfTwoLinks) {
  const PairMotion motion = motionOf({0, 0}, {0.1, -0.2});
  EXPECT_NEAR(motion.beyond, 0.0181, 1e-12);
  EXPECT_NEAR(motion.most, 0.0331, 1e-12);  // 0.015 by the twist, and what is beyond
  EXPECT_NEAR(motion.a.w.z(), -0.1, 1e-12);
  EXPECT_NEAR(motion.a.v.y(), 0.08, 1e-12);
  const Eigen::Vector3d middle(0.7, 0, 0);
  const Eigen::Vector3d velocity = motion.a.v + motion.a.w.cross(middle);
  EXPECT_TRUE(velocity.isApprox(Eigen::Vector3d(0, 0.01, 0), 1e-12));
  EXPECT_EQ(motion.b.w.norm() + motion.b.v.norm(), 0);
}

TEST_F(CollisionProof, BoundsWithoutTheTwistAreFarWider) {
  // A curve that only strays: nothing of it is known to go along a line.
  groups_.place(Eigen::Vector2d::Zero());
  groups_.boundTravel(
      {Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero(), Eigen::Vector2d(0.1, 0.2)});
  EXPECT_NEAR(groups_.approach(1, -1).most, 0.152, 1e-12);
  EXPECT_NEAR(groups_.approach(1, -1).beyond, 0.152, 1e-12);
}

TEST_F(CollisionProof, AQuarterIsBeyondTheLineOfHalfAMotion) {
  const PairMotion whole = motionOf({0, 0}, {0.1, -0.2});
  const PairMotion half = motionOf({0.05, -0.1}, {0.05, -0.1});
  EXPECT_NEAR(half.beyond, 0.00448, 5e-6);
  EXPECT_NEAR(half.beyond / whole.beyond, 0.25, 0.01);
}

TEST_F(CollisionProof, APlaneProvesWhatTheDistanceDoesNot) {
  const PairMotion motion = motionOf({0, 0}, {0.1, -0.2});
  // The plane leaves 19.75 mm at x = 1, and 1 + 18.1 mm are asked; the distance of 30 mm is less
  // than 1 + 33.1 mm.
  EXPECT_LT(0.030, motion.most + kPlannedClearance.proven);
  EXPECT_EQ(look(motion, 0.080), Nearness::kApart);
  EXPECT_EQ(look(motion, 0.07935), Nearness::kApart);  // 29.35 mm: as near as it may be
  EXPECT_EQ(look(motion, 0.07934), Nearness::kNear);
  EXPECT_EQ(look(motion, 0.079), Nearness::kNear);       // 29 mm: 18.75 mm are left, not 19.1
  EXPECT_EQ(look(motion, 0.0521), Nearness::kNear);      // 2.1 mm
  EXPECT_EQ(look(motion, 0.0519), Nearness::kTouching);  // 1.9 mm are a contact as they stand
  // Both halves are proven where the whole is not.
  EXPECT_EQ(look(motionOf({0.05, -0.1}, {0.05, -0.1}), 0.079), Nearness::kApart);
  EXPECT_EQ(look(motionOf({-0.05, 0.1}, {0.05, -0.1}), 0.079), Nearness::kApart);
}

TEST_F(CollisionProof, HalvingProvesTheWholeMotionUpToTheClearance) {
  // The sphere's top gets to y = 0.05 + 0.1 sin 0.1 at the end.
  const double top = kRadius + 0.1 * std::sin(0.1);
  const Straight motion(Eigen::Vector2d(-0.1, 0.2), Eigen::Vector2d(0.1, -0.2));
  for (const auto& [face, free] : {std::pair{0.079, true},
                                   {top + 0.0021, true},
                                   {top + 0.0009, false},
                                   {top - 0.001, false}}) {
    Scene scene;
    scene.robots = {robot_};
    scene.objects = {wall(face)};
    CollisionWorld world(std::make_shared<const CollisionScene>(scene));
    StateChecker checker(world, {world.scene(), RobotId(0), {DofId(0), DofId(1)}});
    EXPECT_EQ(checker.isMotionFree(motion), free) << face;
  }
}

}  // namespace
}  // namespace handover::test
