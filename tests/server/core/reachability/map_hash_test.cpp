// SPDX-License-Identifier: Apache-2.0
#include "core/reachability/reachability_map.hpp"
#include "support/arm_models.hpp"

#include <gtest/gtest.h>

namespace handover::test {
namespace {

/// A torso with a waist joint, the arm under test, another arm, and a finger on the first one's
/// tool.
RobotModel twoArmed() {
  const auto joint = [](const char* name, int parent, int child, int dof) {
    Joint j;
    j.name = name;
    j.type = JointType::kRevolute;
    j.parent_link = LinkId(parent);
    j.child_link = LinkId(child);
    j.X_PJ.translation() = Eigen::Vector3d(0.1 * child, 0.2, 0.3);
    j.lower = -1;
    j.upper = 1;
    j.dof = DofId(dof);
    return j;
  };
  RobotModel model;
  for (int i = 0; i < 6; ++i) {
    Link link;
    link.name = "link" + std::to_string(i);
    link.parent_joint = JointId(i - 1);
    link.collision.push_back({Pose::Identity(), SphereShape{0.05}});
    model.links.push_back(link);
  }
  model.joints = {joint("waist", 0, 1, 0), joint("left", 1, 2, 1), joint("left2", 2, 3, 2),
                  joint("right", 1, 4, 3), joint("finger", 3, 5, 4)};
  for (const JointId j : IdRange<JointId>(5)) model.dof_joints.push_back(j);
  Arm left, right;
  left.base_link = LinkId(1);
  left.tool_link = LinkId(3);
  left.dofs = {DofId(1), DofId(2)};
  left.joints = {JointId(1), JointId(2)};
  right.base_link = LinkId(1);
  right.tool_link = LinkId(4);
  right.dofs = {DofId(3)};
  right.joints = {JointId(3)};
  left.hand = HandId(0);
  model.arms = {left, right};
  Hand hand;
  hand.dofs = {DofId(4)};
  hand.open = Eigen::VectorXd::Constant(1, -0.5);
  model.hands = {hand};
  return model;
}

std::uint64_t hashOf(const RobotModel& model, const RobotVector& q = RobotVector::Zero(5),
                     const ReachabilityParams& params = {}) {
  return ReachabilityMap::hash(model, ArmId(0), q, params);
}

template <typename Change>
std::uint64_t hashAfter(const Change& change) {
  RobotModel model = twoArmed();
  change(model);
  return hashOf(model);
}

TEST(ReachabilityHash, IsTheSameForTheSameArm) {
  EXPECT_EQ(hashOf(twoArmed()), hashOf(twoArmed()));
}

TEST(ReachabilityHash, ChangesWithAllThatDecidesTheMap) {
  const std::uint64_t base = hashOf(twoArmed());
  const std::vector<std::uint64_t> changed = {
      hashAfter([](RobotModel& m) { m.joints[1].X_PJ.translation().x() += 1e-6; }),
      hashAfter([](RobotModel& m) { m.joints[1].axis = Eigen::Vector3d::UnitX(); }),
      hashAfter([](RobotModel& m) { m.joints[2].upper = 1.1; }),
      hashAfter([](RobotModel& m) { m.joints[2].lower = -1.1; }),
      hashAfter([](RobotModel& m) { m.joints[1].type = JointType::kPrismatic; }),
      hashAfter([](RobotModel& m) { m.arms[0].tool_link = LinkId(5); }),
      hashAfter([](RobotModel& m) { m.arms[0].approach_axis = Eigen::Vector3d::UnitX(); }),
      hashAfter([](RobotModel& m) { m.links[0].collision.clear(); }),
      hashAfter([](RobotModel& m) { m.links[2].collision[0].geometry = SphereShape{0.06}; }),
      hashAfter([](RobotModel& m) { m.links[2].collision[0].X_BS.translation().z() = 0.01; }),
      hashAfter([](RobotModel& m) {
        m.links[1].collision[0].geometry =
            ConvexShape{.vertices = {{0, 0, 0}, {1, 0, 0}}, .triangles = {}};
      }),
      hashAfter([](RobotModel& m) {
        m.links[1].collision[0].geometry =
            ConvexShape{.vertices = {{0, 0, 0}, {1, 0, 0.1}}, .triangles = {}};
      }),
      hashAfter([](RobotModel& m) {
        m.links[1].collision[0].geometry = CylinderShape{0.05, 0.1};
      }),
      hashAfter([](RobotModel& m) {
        m.links[1].collision[0].geometry = BoxShape{{0.1, 0.1, 0.1}};
      }),
      hashAfter([](RobotModel& m) {
        m.disabled_pairs[{LinkId(0), LinkId(3)}] = "Never";
      }),
      hashOf(twoArmed(), (RobotVector(5) << 0.1, 0, 0, 0, 0).finished()),  // waist
      hashAfter([](RobotModel& m) { m.hands[0].open[0] = -0.6; }),
      hashOf(twoArmed(), RobotVector::Zero(5), {.voxel = 0.04}),
      hashOf(twoArmed(), RobotVector::Zero(5), {.samples = 999'999}),
      hashOf(twoArmed(), RobotVector::Zero(5), {.seed = 2}),
      hashOf(twoArmed(), RobotVector::Zero(5), {.tie_samples = 100}),
      hashOf(twoArmed(), RobotVector::Zero(5), {.tie_errors = 2}),
      hashAfter([](RobotModel& m) { m.joints[3].upper = 2; }),  // arms are sampled together
      hashAfter([](RobotModel& m) { m.links[4].collision.clear(); }),
      hashAfter([](RobotModel& m) {
        m.disabled_pairs[{LinkId(0), LinkId(4)}] = "Never";
      }),
      ReachabilityMap::hash(twoArmed(), ArmId(1), RobotVector::Zero(5), {}),
  };
  for (std::size_t i = 0; i < changed.size(); ++i) {
    EXPECT_NE(changed[i], base) << i;
    for (std::size_t j = 0; j < i; ++j) EXPECT_NE(changed[i], changed[j]) << i << " and " << j;
  }
}

TEST(ReachabilityHash, DoesNotDependOnTheArmsPosturesOrNames) {
  const std::uint64_t base = hashOf(twoArmed());
  EXPECT_EQ(hashAfter([](RobotModel& m) { m.arms[1].name = "other"; }), base);
  EXPECT_EQ(hashAfter([](RobotModel& m) { m.name = "other"; }), base);
  EXPECT_EQ(hashAfter([](RobotModel& m) { m.joints[1].velocity = 7; }), base);
  EXPECT_EQ(hashOf(twoArmed(), (RobotVector(5) << 0, 0.3, -0.2, 0.5, 0.7).finished()), base);
}

TEST(ReachabilityHash, ForgivesTheLastBitsOfASine) {
  EXPECT_EQ(hashAfter([](RobotModel& m) { m.joints[1].X_PJ.linear()(0, 1) = 1e-16; }),
            hashOf(twoArmed()));
}

TEST(ReachabilityHash, HasNotChangedSinceTheSecondVersion) {
  // Other machines and later builds must find the maps of this one: a change here needs a new file
  // version.
  EXPECT_EQ(hashOf(twoArmed()), 1297110541202880418u);
}

TEST(ReachabilityHash, RefusesAPostureOfAnotherRobot) {
  EXPECT_THROW(hashOf(twoArmed(), RobotVector::Zero(3)), std::invalid_argument);
}

}  // namespace
}  // namespace handover::test
