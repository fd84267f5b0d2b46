// SPDX-License-Identifier: Apache-2.0
// The grasp sets of [paper] Table I: as many, each one checked.
#include "core/grasp/grasp_set.hpp"
#include "core/grasp/thinning.hpp"
#include "grasp_checker.hpp"
#include "robot_hands.hpp"

#include <gtest/gtest.h>

namespace handover {
namespace {

struct Entry {
  const char* object;
  RobotHand hand;
  int count;
};

void PrintTo(const Entry& e, std::ostream* out) {
  *out << e.object << " " << e.hand.robot << " " << e.hand.arm;
}

class TableOne : public testing::TestWithParam<Entry> {};

TEST_P(TableOne, IsReachedWithGraspsThatHold) {
  const auto& [object_name, hand, count] = GetParam();
  const RobotModel model = loadRobotNamed(hand.robot);
  const SceneObject object = loadObjectNamed(object_name);
  const ArmId arm = model.findArm(hand.arm);
  GraspParams params;
  params.wanted = count;
  const auto set = generateGrasps(object, model, arm, params, nullptr, Deadline());
  ASSERT_TRUE(set) << set.error().detail;
  EXPECT_NEAR(static_cast<double>(set->grasps.size()), count, 0.1 * count);
  const GraspChecker checker(object, model, arm);
  for (std::size_t i = 0; i < set->grasps.size(); ++i) {
    EXPECT_EQ(checker.faultOf(set->grasps[i]), "") << i;
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_FALSE(tooClose(set->grasps[i], set->grasps[j], params.min_spacing, params.min_angle));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Of, TableOne,
    testing::Values(Entry{"cup", {"crichton", "left"}, 316},
                    Entry{"cup", {"crichton", "right"}, 316}, Entry{"cup", {"hubo", "left"}, 368},
                    Entry{"cup", {"hubo", "right"}, 368},
                    Entry{"hammer", {"crichton", "left"}, 445},
                    Entry{"hammer", {"hubo", "left"}, 590}, Entry{"hammer", {"hubo", "right"}, 644},
                    Entry{"jar", {"crichton", "left"}, 448}, Entry{"jar", {"hubo", "left"}, 448},
                    Entry{"jar", {"hubo", "right"}, 448}),
    [](const auto& each) {
      return std::string(each.param.object) + "_" + each.param.hand.robot + "_" +
             each.param.hand.arm;
    });

}  // namespace
}  // namespace handover
