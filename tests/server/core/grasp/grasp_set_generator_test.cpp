// SPDX-License-Identifier: Apache-2.0
#include "core/grasp/grasp_set.hpp"
#include "core/grasp/thinning.hpp"
#include "grasp_checker.hpp"
#include "test_hands.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

namespace handover {
namespace {

GraspParams few(int wanted) {
  GraspParams params;
  params.wanted = wanted;
  return params;
}

Result<GraspSet> make(const SceneObject& object, const RobotModel& model,
                      const GraspParams& params) {
  return generateGrasps(object, model, ArmId(0), params, nullptr, Deadline());
}

struct Case {
  const char* name;
  RobotModel (*hand)();
  SceneObject object;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class Grasps : public testing::TestWithParam<Case> {};

TEST_P(Grasps, HoldByAnIndependentCheck) {
  const RobotModel model = GetParam().hand();
  const auto set = make(GetParam().object, model, few(40));
  ASSERT_TRUE(set) << set.error().detail;
  EXPECT_EQ(set->grasps.size(), 40u);
  const GraspChecker checker(GetParam().object, model, ArmId(0));
  for (const Grasp& grasp : set->grasps) EXPECT_EQ(checker.faultOf(grasp), "");
}

TEST_P(Grasps, KeepTheSpacingRuleAndTheOrder) {
  const GraspParams params = few(40);
  const auto set = make(GetParam().object, GetParam().hand(), params);
  ASSERT_TRUE(set);
  const auto& grasps = set->grasps;
  for (std::size_t i = 0; i < grasps.size(); ++i) {
    EXPECT_GT(grasps[i].quality, 0);
    EXPECT_LE(grasps[i].quality, grasps[i > 0 ? i - 1 : 0].quality);
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_FALSE(tooClose(grasps[i], grasps[j], params.min_spacing, params.min_angle));
    }
  }
}

TEST_P(Grasps, AreTheSameBytesTwiceAndSurviveTheirFile) {
  const std::filesystem::path folder(testing::TempDir());
  std::string bytes[2];
  for (int k = 0; k < 2; ++k) {
    const auto set = make(GetParam().object, GetParam().hand(), few(20));
    ASSERT_TRUE(set);
    const auto file =
        folder / (std::string("handover_twice_") + GetParam().name + std::to_string(k));
    ASSERT_TRUE(writeGraspSet(*set, 1, file));
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    bytes[k] = text.str();
    const auto read = readGraspSet(file, 1);
    ASSERT_TRUE(read) << read.error().detail;
    for (std::size_t i = 0; i < set->grasps.size(); ++i) {
      EXPECT_EQ(read->grasps[i].X_OT.matrix(), set->grasps[i].X_OT.matrix());
      EXPECT_EQ(read->grasps[i].open, set->grasps[i].open);
    }
  }
  EXPECT_EQ(bytes[0], bytes[1]);
}

TEST_P(Grasps, ComeAlongTheSurfaceNormalWithThePalmJustAbove) {
  const auto set = make(GetParam().object, GetParam().hand(), few(20));
  ASSERT_TRUE(set);
  for (const Grasp& grasp : set->grasps) {
    // The tool lies 5 cm before the palm: the palm is at z = -0.05 of T.
    const Eigen::Vector3d palm = grasp.X_OT * Eigen::Vector3d(0, 0, -0.05);
    const Eigen::Vector3d approach = grasp.X_OT.linear().col(2);
    EXPECT_LT(approach.dot(palm), 0);  // from outside in: O's origin is its middle
  }
}

INSTANTIATE_TEST_SUITE_P(
    Of, Grasps,
    testing::Values(Case{"gripper_box", parallelGripper, boxObject({0.06, 0.08, 0.15})},
                    Case{"gripper_sphere", parallelGripper, sphereObject(0.04)},
                    Case{"gripper_cylinder", parallelGripper, cylinderObject(0.035, 0.15)},
                    Case{"curler_box", curlingHand, boxObject({0.06, 0.08, 0.15})},
                    Case{"curler_cylinder", curlingHand, cylinderObject(0.04, 0.15)}),
    [](const auto& each) { return std::string(each.param.name); });

TEST(GenerateGrasps, FindNoneWhereTheObjectIsTooWide) {
  const auto set = make(boxObject({0.3, 0.3, 0.3}), parallelGripper(), few(10));
  ASSERT_TRUE(set);
  EXPECT_TRUE(set->grasps.empty());
  EXPECT_EQ(set->none_because,
            "fingers that open to 110 mm, with 4 mm of room on each side, hold it nowhere; its box "
            "is 300 x 300 x 300 mm");
}

TEST(GenerateGrasps, RefuseWhatCannotBeMeant) {
  const RobotModel model = parallelGripper();
  const auto code = [](const Result<GraspSet>& set) {
    return set ? ErrorCode::kInternal : set.error().code;
  };
  EXPECT_EQ(code(make(objectOf("nothing", {}), model, few(10))), ErrorCode::kInvalidInput);
  EXPECT_EQ(code(make(boxObject({0.05, 0.05, 0.05}), model, few(0))), ErrorCode::kInvalidInput);
  const auto no_arm =
      generateGrasps(sphereObject(0.04), model, ArmId(1), few(10), nullptr, Deadline());
  EXPECT_EQ(code(no_arm), ErrorCode::kInvalidInput);
  RobotModel handless = model;
  handless.arms[0].hand = {};
  EXPECT_EQ(code(make(sphereObject(0.04), handless, few(10))), ErrorCode::kInvalidInput);
}

TEST(GenerateGrasps, StopWhenCancelledOrLate) {
  const Deadline cancelled;
  cancelled.cancel();
  const auto stopped =
      generateGrasps(sphereObject(0.04), parallelGripper(), ArmId(0), few(10), nullptr, cancelled);
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::kCancelled);
  const Deadline passed(Deadline::Clock::now());
  const auto late =
      generateGrasps(sphereObject(0.04), parallelGripper(), ArmId(0), few(10), nullptr, passed);
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, ErrorCode::kDeadline);
}

TEST(GenerateGrasps, TellTheirProgressInRisingShares) {
  double last = 0;
  const auto set = generateGrasps(
      sphereObject(0.04), parallelGripper(), ArmId(0), few(30),
      [&](double share) {
        EXPECT_GE(share, last);
        EXPECT_LE(share, 1.0);
        last = share;
      },
      Deadline());
  ASSERT_TRUE(set);
  EXPECT_DOUBLE_EQ(last, 1.0);
}

TEST(Thin, KeepsTheBestAndSpreadsTheRest) {
  std::vector<Grasp> grasps(100);
  for (int i = 0; i < 100; ++i) {
    grasps[static_cast<std::size_t>(i)].X_OT.translation().x() = 0.01 * i;
    grasps[static_cast<std::size_t>(i)].quality = i == 37 ? 0.5 : 0.2;
  }
  const auto kept = thin(grasps, 5);
  ASSERT_EQ(kept.size(), 5u);
  EXPECT_TRUE(
      std::any_of(kept.begin(), kept.end(), [](const Grasp& g) { return g.quality == 0.5; }));
  EXPECT_EQ(kept.front().X_OT.translation().x(), 0.0);
  EXPECT_EQ(kept.back().X_OT.translation().x(), 0.99);
  for (std::size_t i = 1; i < kept.size(); ++i) {
    EXPECT_GT(kept[i].X_OT.translation().x() - kept[i - 1].X_OT.translation().x(), 0.1);
  }
}

}  // namespace
}  // namespace handover
