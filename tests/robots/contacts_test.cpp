// SPDX-License-Identifier: Apache-2.0
// What of a robot touches itself: nothing in a named state, and what the SRDF says always does.
#include "core/collision/collision_scene.hpp"
#include "core/collision/self_collision.hpp"
#include "robot_files.hpp"

#include <gtest/gtest.h>

#include <numeric>

namespace handover {
namespace {

class RobotContacts : public ::testing::TestWithParam<const char*> {
 protected:
  std::string reasonOf(int link_a, int link_b) const {
    const auto pair = model_.disabled_pairs.find(std::minmax(link_a, link_b));
    return pair == model_.disabled_pairs.end() ? "" : pair->second;
  }

  RobotModel model_ = testing::loadBody(GetParam());
};

TEST_P(RobotContacts, PairsThatAlwaysTouchAreThoseThatTheSrdfNames) {
  for (const LinkPairTouch& pair : sampleSelfCollision(model_, 400, 1)) {
    EXPECT_EQ(pair.pattern == TouchPattern::kAlways, reasonOf(pair.link_a, pair.link_b) == "Always")
        << model_.links[static_cast<std::size_t>(pair.link_a)].name << " and "
        << model_.links[static_cast<std::size_t>(pair.link_b)].name << " touch in " << pair.touching
        << " of 400 postures";
  }
}

/// An arm bends as far as its joints go without its own links in the way.
TEST_P(RobotContacts, NeighboursButOneInAnArmStayApart) {
  const bool crichton = std::string(GetParam()) == "crichton";
  const std::vector<std::pair<std::string, std::string>> apart =
      crichton
          ? std::vector<std::pair<std::string, std::string>>{{"left_L1_link", "left_L3_link"},
                                                             {"left_L2_link", "left_L4_link"},
                                                             {"left_L3_link", "left_L5_link"},
                                                             {"left_L4_link", "left_L6_link"},
                                                             {"left_L5_link", "left_L7_link"},
                                                             {"left_L5_link", "left_palm_link"}}
          : std::vector<std::pair<std::string, std::string>>{
                {"Body_LSR", "Body_LEP"}, {"Body_LEP", "Body_LWP"}, {"Body_LWY", "Body_LWR"}};
  std::size_t found = 0;
  for (const LinkPairTouch& pair : sampleSelfCollision(model_, 2000, 2)) {
    const auto name = [&](int link) { return model_.links[static_cast<std::size_t>(link)].name; };
    for (const auto& [a, b] : apart) {
      if (name(pair.link_a) != a || name(pair.link_b) != b) continue;
      EXPECT_EQ(pair.pattern, TouchPattern::kNever) << a << " " << b << " " << pair.touching;
      ++found;
    }
  }
  EXPECT_EQ(found, apart.size());
}

TEST_P(RobotContacts, NamedStatesAreFree) {
  for (const auto& [state, q] : model_.named_states) {
    Scene scene;
    scene.robots.push_back(
        {"robot", std::make_shared<const RobotModel>(model_), Pose::Identity(), q, {}});
    CollisionWorld world(std::make_shared<const CollisionScene>(scene));
    std::vector<BodyId> bodies(static_cast<std::size_t>(world.scene().bodies()));
    std::iota(bodies.begin(), bodies.end(), 0);
    const PairList pairs = world.makePairs(bodies, BodyPairs(world.scene().bodies()));
    ASSERT_GT(pairs.pairs().size(), 100u);
    for (const BodyContact& contact : world.contacts(pairs)) {
      ADD_FAILURE() << state << ": " << world.scene().name(contact.a) << " and "
                    << world.scene().name(contact.b) << ", " << contact.depth << " m";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Robots, RobotContacts, ::testing::Values("crichton", "hubo"));

}  // namespace
}  // namespace handover
