// SPDX-License-Identifier: Apache-2.0
#include "core/collision/self_collision.hpp"

#include "small_robots.hpp"

#include <gtest/gtest.h>

namespace handover::test {
namespace {

TEST(SelfCollision, TellsNeverSometimesAndAlways) {
  const auto model = twoArmRobot();
  // A ring that every posture keeps inside the base.
  Shape inside;
  inside.X_BS.translation() = Eigen::Vector3d(-0.15 - 0.35, 0, 0);
  inside.geometry = BoxShape{{0.01, 0.01, 0.01}};
  const LinkId base = model->findLink("base"), head = model->findLink("head");
  const LinkId lower = model->findLink("left_lower"), right = model->findLink("right_lower");
  const LinkId finger_a = model->findLink("left_finger_a"),
               finger_b = model->findLink("left_finger_b");
  Shape block;
  block.geometry = BoxShape{{0.2, 0.04, 0.04}};
  model->links[static_cast<std::size_t>(finger_b)].collision.push_back(block);
  model->links[static_cast<std::size_t>(finger_a)].collision.push_back(block);

  const std::vector<LinkPairTouch> pairs = sampleSelfCollision(*model, 500, 1);
  const auto pattern = [&](LinkId a, LinkId b) {
    for (const LinkPairTouch& it : pairs) {
      if (it.link_a == std::min(a, b) && it.link_b == std::max(a, b)) return it.pattern;
    }
    ADD_FAILURE() << "pair " << a.value() << " " << b.value() << " is missing";
    return TouchPattern::kNever;
  };
  EXPECT_EQ(pattern(head, lower), TouchPattern::kNever);
  EXPECT_EQ(pattern(lower, right), TouchPattern::kSometimes);
  EXPECT_EQ(pattern(base, finger_a), TouchPattern::kSometimes);
  EXPECT_EQ(pattern(finger_a, finger_b), TouchPattern::kSometimes);
  for (const LinkPairTouch& it : pairs) EXPECT_FALSE(model->adjacent(it.link_a, it.link_b));
}

TEST(SelfCollision, SameSeedSameAnswer) {
  const auto model = twoArmRobot();
  const auto one = sampleSelfCollision(*model, 200, 5), two = sampleSelfCollision(*model, 200, 5);
  ASSERT_EQ(one.size(), two.size());
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_EQ(one[i].touching, two[i].touching);
  EXPECT_THROW(sampleSelfCollision(*model, 0, 1), std::invalid_argument);
}

}  // namespace
}  // namespace handover::test
