// SPDX-License-Identifier: Apache-2.0
// Grasps of bodies whose convex parts stand off their surface: held on the surface, by an
// independent check of the surface.
#include "core/grasp/finger_closing.hpp"
#include "core/grasp/grasp_set.hpp"
#include "core/grasp/surface_samples.hpp"
#include "grasp_checker.hpp"
#include "support/meshes.hpp"
#include "test_hands.hpp"

#include <gmock/gmock.h>

namespace handover {
namespace {

using Eigen::Vector3d;

constexpr double kStandsOff = 0.005;  // [m] what convexParts() may do

/// A box of half edges `half`; its one part stands off by 5 mm all round.
SceneObject looseBox(const Vector3d& half) {
  SceneObject object =
      objectOf("loose", {Shape{Pose::Identity(), BoxShape{2 * (half.array() + kStandsOff)}}});
  object.divided = std::make_shared<const DividedBodies>(
      DividedBodies{{test::boxMesh(-half, half), 0, 1, 0, 1}});
  return object;
}

Result<GraspSet> make(const SceneObject& object, const RobotModel& model, int wanted) {
  GraspParams params;
  params.wanted = wanted;
  return generateGrasps(object, model, ArmId(0), params, nullptr, Deadline());
}

class TrueSurface : public ::testing::TestWithParam<RobotModel (*)()> {};

TEST_P(TrueSurface, IsWhatFingersCloseOn) {
  const Vector3d half(0.02, 0.03, 0.06);
  const RobotModel model = GetParam()();
  const auto set = make(looseBox(half), model, 30);
  ASSERT_TRUE(set) << set.error().detail;
  EXPECT_EQ(set->grasps.size(), 30u);
  const GraspChecker surface(boxObject(2 * half), model, ArmId(0));
  for (const Grasp& grasp : set->grasps) {
    EXPECT_EQ(surface.faultOf(grasp), "");
    for (const GraspContact& contact : grasp.contacts) {
      EXPECT_LT((contact.p_O.cwiseAbs() - half).maxCoeff(), 1e-6);
      EXPECT_GT((contact.p_O.cwiseAbs() - half).maxCoeff(), -1e-6);
    }
  }
}

TEST_P(TrueSurface, OpenHandsKeepOffTheParts) {
  const Vector3d half(0.02, 0.03, 0.06);
  const RobotModel model = GetParam()();
  const auto set = make(looseBox(half), model, 10);
  ASSERT_TRUE(set);
  const SceneObject parts = boxObject(2 * (half.array() + kStandsOff));
  FingerClosing hand(parts, extractEndEffector(model, ArmId(0)), GraspRules{});
  for (const Grasp& grasp : set->grasps) {
    // As near as it stands, it need not be nearer: nothing is within the clearance.
    const auto back = hand.advance(grasp.X_OT, grasp.open, 0.1, 0);
    ASSERT_TRUE(back);
    EXPECT_LT(*back, 1e-3);
  }
}

INSTANTIATE_TEST_SUITE_P(Of, TrueSurface, ::testing::Values(parallelGripper, curlingHand));

TEST(GripRule, WantsOpposingFacesWithinTwoMillimetres) {
  const HandModel hand = extractEndEffector(parallelGripper(), ArmId(0));
  const auto holds = [&](double gap, const Vector3d& half, bool divided) {
    SceneObject object = boxObject(2 * half);
    if (divided) {
      object.divided = std::make_shared<const DividedBodies>(
          DividedBodies{{test::boxMesh(-half, half), 0, 1, 0, 1}});
    }
    const ObjectSurface surface(object);
    const GripRule rule(surface, hand);
    // The finger links where they were built, moved along x to stand `gap` off the box.
    std::vector<Pose> X_OL;
    linkPoses(*hand.model, Pose::Identity(), restingPosture(*hand.model), X_OL);
    for (const LinkId finger : hand.hand.finger_links) {
      Pose& X = X_OL[finger];
      const auto points = outline(hand.model->links[finger]);
      double low = 9, high = -9;
      Vector3d middle = Vector3d::Zero();
      for (const Vector3d& p : points) {
        low = std::min(low, (X.linear() * p).x());
        high = std::max(high, (X.linear() * p).x());
        middle += X.linear() * p / static_cast<double>(points.size());
      }
      const bool first = finger == hand.hand.finger_links.front();
      X.translation() = -middle;
      X.translation().x() = first ? -half.x() - gap - high : half.x() + gap - low;
    }
    return rule.holds(X_OL);
  };
  for (const bool divided : {false, true}) {
    EXPECT_TRUE(holds(0.0004, {0.02, 0.03, 0.03}, divided));
    EXPECT_TRUE(holds(0.0014, {0.02, 0.03, 0.03}, divided));
    EXPECT_FALSE(holds(0.0016, {0.02, 0.03, 0.03}, divided));
  }
}

TEST(SampleSurface, OfADividedBodyLiesOnItsTriangles) {
  const Vector3d half(0.02, 0.03, 0.06);
  const auto samples = sampleSurface(ObjectSurface(looseBox(half)), {});
  EXPECT_GT(samples.size(), 500u);
  for (const SurfaceSample& s : samples) {
    EXPECT_NEAR((s.p_O.cwiseAbs() - half).maxCoeff(), 0, 1e-9);
    EXPECT_GT(s.n_O.dot(s.p_O), 0);
  }
}

TEST(SampleSurface, LeavesOutTheInsideOfACup) {
  SceneObject cup = objectOf("cup", {Shape{Pose::Identity(), BoxShape{{0.1, 0.1, 0.1}}}});
  cup.divided = std::make_shared<const DividedBodies>(DividedBodies{{test::cupMesh(), 0, 1, 0, 1}});
  const auto samples = sampleSurface(ObjectSurface(cup), {});
  EXPECT_GT(samples.size(), 500u);
  for (const SurfaceSample& s : samples) {
    const bool wall = s.p_O.head<2>().norm() < 0.0319 && s.p_O.z() > 0.0041 && s.p_O.z() < 0.09;
    EXPECT_FALSE(wall) << s.p_O.transpose();
  }
}

TEST(SuctionGrasps, StandOnTheSurfaceWherePartsMeetIt) {
  // The parts stand off upwards only: the sides and the bottom are met.
  const Vector3d half(0.03, 0.035, 0.025);
  Shape part{Pose::Identity(), BoxShape{2 * half + Vector3d(0, 0, kStandsOff)}};
  part.X_BS.translation().z() = kStandsOff / 2;
  SceneObject object = objectOf("loose", {part});
  object.divided = std::make_shared<const DividedBodies>(
      DividedBodies{{test::boxMesh(-half, half), 0, 1, 0, 1}});
  const auto set = make(object, suctionGripper(0.015), 100);
  ASSERT_TRUE(set) << set.error().detail;
  ASSERT_FALSE(set->grasps.empty());
  for (const Grasp& grasp : set->grasps) {
    const Vector3d p = grasp.X_OT.translation();
    EXPECT_LT((p.cwiseAbs() - half).maxCoeff(), 0.002);
    EXPECT_LT(p.z(), half.z());  // not on the top, which no cup can come to
  }
}

}  // namespace
}  // namespace handover
