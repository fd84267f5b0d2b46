// SPDX-License-Identifier: Apache-2.0
// Grasps of the cup with the three hands of the butler scene. With HANDOVER_GRASP_OBJ set to a
// folder, hands and cup are written there as Wavefront files to look at.
#include "core/grasp/grasp_set.hpp"
#include "core/grasp/thinning.hpp"
#include "grasp_checker.hpp"
#include "robot_hands.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

namespace handover {
namespace {

constexpr double kHalfCup = 0.0755;  // its origin is at mid-height, its rim at +z

class CupGrasps : public testing::TestWithParam<RobotHand> {
 protected:
  CupGrasps() : model_(loadRobotNamed(GetParam().robot)), arm_(model_.findArm(GetParam().arm)) {}

  GraspSet make(int wanted) const {
    GraspParams params;
    params.wanted = wanted;
    auto set = generateGrasps(cup_, model_, arm_, params, nullptr, Deadline());
    EXPECT_TRUE(set);
    return set ? *set : GraspSet{};
  }

  SceneObject cup_ = loadObjectNamed("cup");
  RobotModel model_;
  ArmId arm_;
};

TEST_P(CupGrasps, HoldByAnIndependentCheck) {
  const GraspSet set = make(80);
  EXPECT_EQ(set.grasps.size(), 80u);
  const GraspChecker checker(cup_, model_, arm_);
  const char* folder = std::getenv("HANDOVER_GRASP_OBJ");
  for (std::size_t i = 0; i < set.grasps.size(); ++i) {
    const Grasp& grasp = set.grasps[i];
    EXPECT_EQ(checker.faultOf(grasp), "") << i;
    if (folder == nullptr) continue;
    const std::string name =
        std::string(folder) + "/" + set.robot + "_" + GetParam().arm + "_" + std::to_string(i);
    checker.writeObj(grasp, grasp.closed, name + "_closed.obj");
    checker.writeObj(grasp, grasp.open, name + "_open.obj");
  }
}

TEST_P(CupGrasps, ComeFromAllSidesAndAtAllHeights) {
  int quarters[4] = {};
  int low = 0, middle = 0, high = 0, from_base = 0;
  for (const Grasp& grasp : make(120).grasps) {
    const Eigen::Vector3d approach = grasp.X_OT.linear() * model_.arms[arm_].approach_axis;
    if (approach.z() > 0.7) ++from_base;
    if (std::abs(approach.z()) < 0.5)
      ++quarters[(approach.x() > 0 ? 1 : 0) + (approach.y() > 0 ? 2 : 0)];
    double height = 0;
    for (const GraspContact& c : grasp.contacts)
      height += c.p_O.z() / static_cast<double>(grasp.contacts.size());
    ++(height < -kHalfCup / 3 ? low : height < kHalfCup / 3 ? middle : high);
  }
  for (const int quarter : quarters) EXPECT_GT(quarter, 12);
  EXPECT_GT(low, 15);
  EXPECT_GT(middle, 15);
  EXPECT_GT(high, 15);
  EXPECT_GE(from_base, 3);
}

TEST_P(CupGrasps, AreTheSameTwice) {
  const GraspSet first = make(10);
  const GraspSet again = make(10);
  ASSERT_EQ(first.grasps.size(), again.grasps.size());
  for (std::size_t i = 0; i < first.grasps.size(); ++i) {
    EXPECT_EQ(first.grasps[i].X_OT.matrix(), again.grasps[i].X_OT.matrix());
    EXPECT_EQ(first.grasps[i].open, again.grasps[i].open);
    EXPECT_EQ(first.grasps[i].closed, again.grasps[i].closed);
    EXPECT_EQ(first.grasps[i].quality, again.grasps[i].quality);
  }
}

INSTANTIATE_TEST_SUITE_P(Of, CupGrasps,
                         testing::Values(RobotHand{"crichton", "left"}, RobotHand{"hubo", "left"},
                                         RobotHand{"hubo", "right"}),
                         [](const auto& each) {
                           return std::string(each.param.robot) + "_" + each.param.arm;
                         });

TEST(CupHandover, LeavesRoomForBothHands) {
  const SceneObject cup = loadObjectNamed("cup");
  const RobotModel giver = loadRobotNamed("crichton");
  const RobotModel receiver = loadRobotNamed("hubo");
  GraspParams params;
  params.wanted = 40;
  const ArmId arm_g = giver.findArm("left");
  const ArmId arm_r = receiver.findArm("left");
  const auto set_g = generateGrasps(cup, giver, arm_g, params, nullptr, Deadline());
  const auto set_r = generateGrasps(cup, receiver, arm_r, params, nullptr, Deadline());
  ASSERT_TRUE(set_g);
  ASSERT_TRUE(set_r);
  const GraspChecker checker_g(cup, giver, arm_g);
  const GraspChecker checker_r(cup, receiver, arm_r);
  int pairs = 0, together = 0;
  for (std::size_t i = 0; i < set_g->grasps.size(); i += 2) {
    for (std::size_t j = 0; j < set_r->grasps.size(); j += 2) {
      const Grasp& g = set_g->grasps[i];
      const Grasp& r = set_r->grasps[j];
      ++pairs;
      if (GraspChecker::distance(checker_g, g, g.closed, checker_r, r, r.closed) > 0.002)
        ++together;
    }
  }
  EXPECT_GT(together, pairs / 25);  // seen: one in twenty
}

}  // namespace
}  // namespace handover
