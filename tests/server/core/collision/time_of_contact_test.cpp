// SPDX-License-Identifier: Apache-2.0
// Pairs whose gap is known at every moment of a motion: up to where it is `looked` the checker has
// to prove the motion free, past the point where it is `proven` it has to refuse it
// (docs/collision_proof.md).
#include "core/collision/narrow_phase.hpp"
#include "core/collision/robot_pair_checker.hpp"
#include "core/collision/state_checker.hpp"
#include "jointed_bodies.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

namespace handover::test {
namespace {

constexpr double kNear = 1e-5;  // [m]: this side of a gap, or that

/// A world that the checker of its first robot's joints looks at.
struct Checked {
  explicit Checked(const Scene& scene)
      : world(std::make_shared<const CollisionScene>(scene)), checker(world, setup(scene)) {}

  StateCheckerSetup setup(const Scene& scene) const {
    std::vector<DofId> dofs;
    for (const DofId dof : IdRange<DofId>(scene.robots[0].model->dofs())) dofs.push_back(dof);
    return {world.scene(), RobotId(0), dofs};
  }

  CollisionWorld world;
  StateChecker checker;
};

Scene sceneOf(const SceneRobot& robot, const SceneObject& object) {
  Scene scene;
  scene.robots = {robot};
  scene.objects = {object};
  return scene;
}

/// The first moment at which a gap that only shrinks is `gap`, by halving.
double whenGapIs(const std::function<double(double)>& gapAt, double gap) {
  double before = 0, after = 1;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (before + after);
    (gapAt(middle) > gap ? before : after) = middle;
  }
  return before;
}

/// @param gapAt  [m] from the motion's parameter; shrinks from far to an overlap.
void expectTimeOfContact(Checked& it, const JointMotion& motion,
                         const std::function<double(double)>& gapAt) {
  ASSERT_GT(gapAt(0), 0.01);
  ASSERT_LT(gapAt(1), -0.001);
  const BodyId tip(it.world.scene().bodies() - 2), object(it.world.scene().bodies() - 1);
  for (const Clearance& clearance : {kPlannedClearance, kTimedClearance}) {
    const double free = whenGapIs(gapAt, clearance.looked + kNear);
    const double hit = whenGapIs(gapAt, clearance.proven - kNear);
    EXPECT_TRUE(it.checker.isMotionFree(motion, 0, free, clearance)) << free;
    EXPECT_FALSE(it.checker.isMotionFree(motion, 0, hit, clearance)) << hit;
    for (const double past : {hit, whenGapIs(gapAt, 0), whenGapIs(gapAt, -0.001), 1.0}) {
      const auto contact = it.checker.hitAlong(motion, 0, past, clearance);
      ASSERT_TRUE(contact) << past;
      EXPECT_EQ(std::min(contact->a, contact->b), tip);
      EXPECT_EQ(std::max(contact->a, contact->b), object);
      EXPECT_GE(contact->depth, -clearance.looked - kNear);
    }
    // A motion that begins past the contact, too.
    EXPECT_FALSE(it.checker.isMotionFree(motion, whenGapIs(gapAt, 0), 1, clearance));
  }
}

TEST(TimeOfContact, OfASphereOnATurningArmAgainstAWall) {
  // The sphere's middle is 0.7 m from the hinge; the wall's face is at y = 0.4.
  Checked it(sceneOf(
      chainOf("arm", {{JointType::kRevolute, {0, 0, 0}, {0, 0, 1}, {sphereAt(0.05, {0.7, 0, 0})}}}),
      objectOf("wall", boxAt({4, 0.1, 4}, {0, 0, 0}), {0, 0.45, 0})));
  const Straight motion(0.0, 1.2);
  const auto gapAt = [](double s) { return 0.4 - 0.7 * std::sin(1.2 * s) - 0.05; };
  // They touch at 30 degrees.
  EXPECT_NEAR(whenGapIs(gapAt, 0), std::asin(0.5) / 1.2, 1e-12);
  expectTimeOfContact(it, motion, gapAt);
}

TEST(TimeOfContact, OfATurningBarsCornerAgainstAWall) {
  Checked it(sceneOf(
      chainOf(
          "bar",
          {{JointType::kRevolute, {0, 0, 0}, {0, 0, 1}, {boxAt({0.6, 0.1, 0.04}, {0.3, 0, 0})}}}),
      objectOf("wall", boxAt({4, 0.1, 4}, {0, 0, 0}), {0, 0.45, 0})));
  const Straight motion(0.0, 1.2);
  const auto gapAt = [](double s) {
    return 0.4 - 0.6 * std::sin(1.2 * s) - 0.05 * std::cos(1.2 * s);
  };
  EXPECT_NEAR(whenGapIs(gapAt, 0),
              (std::asin(0.4 / std::hypot(0.6, 0.05)) - std::atan2(0.05, 0.6)) / 1.2, 1e-12);
  expectTimeOfContact(it, motion, gapAt);
}

TEST(TimeOfContact, OfABoxThatSlidesToABox) {
  Checked it(sceneOf(
      chainOf("slide",
              {{JointType::kPrismatic, {0, 0, 0}, {1, 0, 0}, {boxAt({0.1, 0.1, 0.1}, {0, 0, 0})}}}),
      objectOf("box", boxAt({0.2, 0.3, 0.2}, {0, 0, 0}), {0.6, 0.02, 0.01})));
  const Straight motion(0.0, 0.9);
  expectTimeOfContact(it, motion, [](double s) { return 0.45 - 0.9 * s; });
}

TEST(TimeOfContact, OfABoxThatSlidesToABoxesEdge) {
  // Turned by 45 degrees about z: an edge of the cube of 0.2 m looks at the slide.
  Checked it(sceneOf(
      chainOf("slide",
              {{JointType::kPrismatic, {0, 0, 0}, {1, 0, 0}, {boxAt({0.1, 0.1, 0.1}, {0, 0, 0})}}}),
      objectOf("box", boxAt({0.2, 0.2, 0.2}, {0, 0, 0}), {0.6, 0.01, 0},
               0.25 * 3.14159265358979323846)));
  const Straight motion(0.0, 0.9);
  const auto gapAt = [](double s) { return 0.6 - 0.1 * std::sqrt(2.0) - 0.05 - 0.9 * s; };
  expectTimeOfContact(it, motion, gapAt);
}

TEST(TimeOfContact, OfASphereThatIsTurnedAndPushedOut) {
  // A hinge, and behind it a slide along the arm.
  Checked it(sceneOf(
      chainOf("crane",
              {{JointType::kRevolute, {0, 0, 0}, {0, 0, 1}, {}},
               {JointType::kPrismatic, {0.3, 0, 0}, {1, 0, 0}, {sphereAt(0.05, {0, 0, 0})}}}),
      objectOf("wall", boxAt({4, 0.1, 4}, {0, 0, 0}), {0, 0.45, 0})));
  const Straight motion(Eigen::Vector2d(0, 0), Eigen::Vector2d(1.2, 0.4));
  expectTimeOfContact(it, motion,
                      [](double s) { return 0.4 - (0.3 + 0.4 * s) * std::sin(1.2 * s) - 0.05; });
}

TEST(TimeOfContact, OfAMotionWithACorner) {
  // First outwards without turning, then turning: the corner is at s = 0.5.
  Checked it(sceneOf(
      chainOf("crane",
              {{JointType::kRevolute, {0, 0, 0}, {0, 0, 1}, {}},
               {JointType::kPrismatic, {0.3, 0, 0}, {1, 0, 0}, {sphereAt(0.05, {0, 0, 0})}}}),
      objectOf("wall", boxAt({4, 0.1, 4}, {0, 0, 0}), {0, 0.45, 0})));
  const PolylineMotion motion(std::vector<Eigen::Vector2d>{{0.1, 0}, {0.1, 0.4}, {1.3, 0.4}});
  expectTimeOfContact(it, motion, [](double s) {
    const double turn = s < 0.5 ? 0.1 : 0.1 + 2.4 * (s - 0.5);
    return 0.35 - (0.3 + 0.8 * std::min(s, 0.5)) * std::sin(turn);
  });
}

// Two robots that move at once, to the ends of their motions at the same time.
class TwoAtOnce {
 public:
  TwoAtOnce(const SceneRobot& first, const SceneRobot& second)
      : scene_(std::make_shared<const CollisionScene>(sceneOfTwo(first, second))),
        world_(scene_),
        first_(world_, {*scene_, RobotId(0), {DofId(0)}}),
        second_(world_, {*scene_, RobotId(1), {DofId(0)}}),
        both_(first_, second_) {}

  bool free(double a_from, double a_to, double b_from, double b_to) {
    const Straight a(a_from, a_to), b(b_from, b_to);
    return both_.isMotionFree(BothMotions(a, b));
  }

 private:
  static Scene sceneOfTwo(const SceneRobot& first, const SceneRobot& second) {
    Scene scene;
    scene.robots = {first, second};
    return scene;
  }

  std::shared_ptr<const CollisionScene> scene_;
  CollisionWorld world_;
  StateChecker first_, second_;
  RobotPairChecker both_;
};

SceneRobot cubeOnASlide(const std::string& name, const Eigen::Vector3d& axis,
                        const Eigen::Vector3d& p_WB) {
  return chainOf(
      name, {{JointType::kPrismatic, {0, 0, 0}, axis, {boxAt({0.1, 0.1, 0.1}, {0, 0, 0})}}}, p_WB);
}

SceneRobot sphereOnAnArm(const std::string& name, double side) {
  return chainOf(
      name,
      {{JointType::kRevolute, {0, 0, 0}, {0, 0, -side}, {sphereAt(0.05, {side * -0.6, 0, 0})}}},
      {side * 0.5, 0, 0});
}

TEST(TimeOfContact, OfTwoSlidesThatMeet) {
  // 0.9 m of gap, closed by 0.6 and by 0.3.
  TwoAtOnce it(cubeOnASlide("a", {1, 0, 0}, {0, 0, 0}), cubeOnASlide("b", {-1, 0, 0}, {1, 0, 0}));
  const auto freeUntil = [&](double gap) {
    const double s = (0.9 - gap) / 0.9;
    return it.free(0, 0.6 * s, 0, 0.3 * s);
  };
  EXPECT_TRUE(freeUntil(kPlannedClearance.looked + kNear));
  EXPECT_FALSE(freeUntil(kPlannedClearance.proven - kNear));
  EXPECT_FALSE(freeUntil(0));
  EXPECT_FALSE(freeUntil(-0.5));
  // Each alone would not get there.
  EXPECT_TRUE(it.free(0, 0.6, 0, 0));
  EXPECT_TRUE(it.free(0, 0, 0, 0.3));
}

TEST(TimeOfContact, OfTwoArmsThatSwingTogether) {
  // Mirrored arms of 0.6 m, hinges at x = -0.5 and 0.5: spheres 1 - 1.2 cos q apart, less radii.
  TwoAtOnce it(sphereOnAnArm("a", -1), sphereOnAnArm("b", 1));
  const auto freeUntil = [&](double gap) {
    const double q = std::acos((0.9 - gap) / 1.2);
    return it.free(1.5, q, 1.5, q);
  };
  EXPECT_TRUE(freeUntil(0.3));
  EXPECT_TRUE(freeUntil(kPlannedClearance.looked + kNear));
  EXPECT_FALSE(freeUntil(kPlannedClearance.proven - kNear));
  EXPECT_FALSE(freeUntil(0));
  EXPECT_FALSE(it.free(1.5, 0.2, 1.5, 0.2));
}

TEST(TimeOfContact, OfTwoThatCrossIsAMatterOfWhoIsLater) {
  // Cubes of 0.1 m cross at right angles, one `later` metres behind: where they are nearest, they
  // are (later - 0.2) / sqrt(2) apart.
  TwoAtOnce it(cubeOnASlide("a", {1, 0, 0}, {-1, 0, 0}), cubeOnASlide("b", {0, 1, 0}, {0, -1, 0}));
  const auto freeWithGap = [&](double gap) {
    const double later = 0.2 + gap * std::sqrt(2.0);
    return it.free(0, 2, -later, 2 - later);
  };
  EXPECT_FALSE(it.free(0, 2, 0, 2));
  EXPECT_FALSE(freeWithGap(-0.01));
  EXPECT_FALSE(freeWithGap(kPlannedClearance.proven - kNear));
  EXPECT_TRUE(freeWithGap(kPlannedClearance.looked + kNear));
}

class Shave : public testing::TestWithParam<Clearance> {
 protected:
  const Clearance clearance_ = GetParam();
  static constexpr double kTenth = 1e-4;  // [m]
};

TEST_P(Shave, AlongAWallIsALookAllTheWay) {
  // A sphere of 0.05 slides along a wall.
  const auto free = [&](double gap) {
    Checked it(sceneOf(
        chainOf("slide",
                {{JointType::kPrismatic, {0, 0, 0}, {1, 0, 0}, {sphereAt(0.05, {0, 0, 0})}}}),
        objectOf("wall", boxAt({4, 0.1, 4}, {0, 0, 0}), {0, 0.1 + gap, 0})));
    return it.checker.isMotionFree(Straight(-0.5, 0.5), 0, 1, clearance_);
  };
  EXPECT_TRUE(free(clearance_.looked + kTenth));
  EXPECT_FALSE(free(clearance_.looked - kTenth));
}

TEST_P(Shave, WhereNobodyLooksGetsAsNearAsIsProven) {
  // The end of a motion is not looked at: the proof of the stretch before it says how near it is.
  // Of timed ways 0.6 mm pass and 0.4 mm do not.
  const auto slides = [&](double gap) {
    Checked it(sceneOf(
        chainOf(
            "slide",
            {{JointType::kPrismatic, {0, 0, 0}, {1, 0, 0}, {boxAt({0.1, 0.1, 0.1}, {0, 0, 0})}}}),
        objectOf("box", boxAt({0.1, 0.1, 0.1}, {0, 0, 0}), {0.3, 0, 0})));
    return it.checker.isMotionFree(Straight(0.0, 0.2 - gap), 0, 1, clearance_);
  };
  EXPECT_TRUE(slides(clearance_.proven + kTenth));
  EXPECT_FALSE(slides(clearance_.proven - kTenth));
  const auto swings = [&](double gap) {
    Checked it(sceneOf(
        chainOf("arm",
                {{JointType::kRevolute, {0, 0, 0}, {0, 0, 1}, {sphereAt(0.05, {0.7, 0, 0})}}}),
        objectOf("wall", boxAt({4, 0.1, 4}, {0, 0, 0}), {0, 0.45, 0})));
    const double q = std::asin((0.35 - gap) / 0.7);
    return it.checker.isMotionFree(Straight(0.0, q), 0, 1, clearance_);
  };
  EXPECT_TRUE(swings(clearance_.proven + kTenth));
  EXPECT_FALSE(swings(clearance_.proven - kTenth));
}

TEST_P(Shave, PastAPostIsDecidedByItsNearestMoment) {
  // An arm with a sphere swings past a post in front of it, nearest at an angle drawn anew. Nearer
  // than `proven` never passes, farther than `looked` always does.
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> angle(-0.6, 0.6), start(-1.5, -0.7), end(0.7, 1.5);
  const auto free = [&](double gap, double nearest, double from, double to) {
    const double reach = 0.7 + 0.05 + 0.03 + gap;
    Checked it(sceneOf(
        chainOf("arm",
                {{JointType::kRevolute, {0, 0, 0}, {0, 0, 1}, {sphereAt(0.05, {0.7, 0, 0})}}}),
        objectOf("post", sphereAt(0.03, {0, 0, 0}),
                 {reach * std::cos(nearest), reach * std::sin(nearest), 0})));
    return it.checker.isMotionFree(Straight(from, to), 0, 1, clearance_);
  };
  for (int round = 0; round < 100; ++round) {
    const double nearest = angle(random), from = start(random), to = end(random);
    EXPECT_FALSE(free(clearance_.proven - kNear, nearest, from, to)) << nearest;
    EXPECT_TRUE(free(clearance_.looked + kNear, nearest, from, to)) << nearest;
  }
  // In between it depends on the looks: the middle of a motion is one.
  EXPECT_FALSE(free(clearance_.looked - kTenth, 0, -1, 1));
}

INSTANTIATE_TEST_SUITE_P(OfPlannedAndTimedWays, Shave,
                         testing::Values(kPlannedClearance, kTimedClearance),
                         [](const auto& it) { return it.index == 0 ? "Planned" : "Timed"; });

TEST(Clearance, OfTimedWaysIsHalfOfThatOfPlannedOnes) {
  // The figures that the shaves above are told by, and docs/collision_proof.md names.
  EXPECT_EQ(kPlannedClearance.looked, 0.002);
  EXPECT_EQ(kPlannedClearance.proven, 0.001);
  EXPECT_EQ(kTimedClearance.looked, 0.001);
  EXPECT_EQ(kTimedClearance.proven, 0.0005);
  EXPECT_EQ(kCollisionMargin, 0.001);
}

}  // namespace
}  // namespace handover::test
