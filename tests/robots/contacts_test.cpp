// SPDX-License-Identifier: Apache-2.0
// What of a robot touches itself: nothing in a named state, and what the SRDF says always does.
#include "core/collision/collision_scene.hpp"
#include "core/collision/self_collision.hpp"
#include "core/collision/state_checker.hpp"
#include "robot_files.hpp"

#include <gtest/gtest.h>

#include <array>
#include <map>
#include <numeric>
#include <random>

namespace handover {
namespace {

class RobotContacts : public ::testing::TestWithParam<const char*> {
 protected:
  std::string reasonOf(LinkId link_a, LinkId link_b) const {
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
  const std::map<std::string, std::vector<std::pair<std::string, std::string>>> robots{
      {"crichton",
       {{"left_L1_link", "left_L3_link"},
        {"left_L2_link", "left_L4_link"},
        {"left_L3_link", "left_L5_link"},
        {"left_L4_link", "left_L6_link"},
        {"left_L5_link", "left_L7_link"},
        {"left_L5_link", "left_palm_link"}}},
      {"hubo", {{"Body_LSR", "Body_LEP"}, {"Body_LEP", "Body_LWP"}, {"Body_LWY", "Body_LWR"}}},
      {"person", {{"left_UpperArm", "left_Wrist"}, {"left_Forearm", "left_Palm"}}}};
  const auto& apart = robots.at(GetParam());
  std::size_t found = 0;
  for (const LinkPairTouch& pair : sampleSelfCollision(model_, 2000, 2)) {
    const auto name = [&](LinkId link) { return model_.links[link].name; };
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
    std::vector<BodyId> bodies;
    for (const BodyId body : IdRange<BodyId>(world.scene().bodies())) bodies.push_back(body);
    const PairList pairs = world.makePairs(bodies, BodyPairs(world.scene().bodies()));
    ASSERT_GT(pairs.pairs().size(), 100u);
    for (const BodyContact& contact : world.contacts(pairs)) {
      ADD_FAILURE() << state << ": " << world.scene().name(contact.a) << " and "
                    << world.scene().name(contact.b) << ", " << contact.depth << " m";
    }
  }
}

/// Motions of an arm among posts, some of them touching: the proof along the whole motion against a
/// look at a thousand states of it.
TEST_P(RobotContacts, NoContactOnAMotionEscapesTheProof) {
  std::mt19937_64 random(3);
  const auto in = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  int free = 0, touching = 0;
  const std::map<std::string, std::array<const char*, 2>> wrists{
      {"crichton", {"left_L7_link", "right_L7_link"}},
      {"hubo", {"Body_LWR", "Body_RWR"}},
      {"person", {"left_Palm", "right_Palm"}}};
  for (const char* wrist : wrists.at(GetParam())) {
    std::vector<DofId> dofs;
    for (LinkId link = model_.findLink(wrist); link != LinkId(0);) {
      const Joint& joint = model_.joints[model_.links[link].parent_joint];
      if (joint.dof.valid() && dofs.size() < 7) dofs.insert(dofs.begin(), joint.dof);
      link = joint.parent_link;
    }
    ASSERT_EQ(dofs.size(), 7u);
    Scene scene;
    scene.robots.push_back({"robot",
                            std::make_shared<const RobotModel>(model_),
                            Pose::Identity(),
                            model_.named_states.begin()->second,
                            {}});
    for (int post = 0; post < 12; ++post) {
      SceneObject object;
      object.name = "post" + std::to_string(post);
      object.shapes = {{Pose::Identity(), BoxShape{{0.04, 0.06, 0.5}}}};
      object.X_WO = Pose::Identity();
      object.X_WO.translation() = Eigen::Vector3d(in(-0.9, 0.9), in(-0.9, 0.9), in(-0.5, 1.5));
      object.X_WO.rotate(
          Eigen::AngleAxisd(in(0, 3), Eigen::Vector3d(1, in(-1, 1), 1).normalized()));
      scene.objects.push_back(object);
    }
    CollisionWorld world(std::make_shared<const CollisionScene>(scene));
    StateChecker checker(world, {world.scene(), RobotId(0), dofs});
    const auto draw = [&] {
      Eigen::VectorXd q(7);
      for (std::size_t i = 0; i < 7; ++i) {
        const Joint& joint = model_.joints[model_.dof_joints[dofs[i]]];
        q[static_cast<Eigen::Index>(i)] = in(joint.lower, joint.upper);
      }
      return q;
    };
    for (int round = 0; round < 60; ++round) {
      std::vector<Eigen::VectorXd> waypoints{draw()};
      for (int k = 0; k < 200 && !checker.valid(waypoints.front()); ++k) waypoints = {draw()};
      // Near ones too: there proofs are few and fine.
      const double reach = round % 2 == 0 ? 1.0 : 0.1;
      for (int k = 0; k < 2; ++k) {
        waypoints.push_back(waypoints.back() + reach * (draw() - waypoints.back()));
      }
      const PolylineMotion motion(waypoints);
      const bool proven = checker.isMotionFree(motion);
      EXPECT_EQ(!checker.hitAlong(motion).has_value(), proven);
      ++(proven ? free : touching);
      constexpr int kLooks = 1000;
      double deepest = -1;
      for (int k = 0; k <= kLooks && proven; ++k) {
        const double at = 2.0 * k / kLooks;
        const int segment = std::min(1, static_cast<int>(at));
        const auto& from = waypoints[static_cast<std::size_t>(segment)];
        const auto& to = waypoints[static_cast<std::size_t>(segment) + 1];
        for (const BodyContact& it : checker.contacts(from + (at - segment) * (to - from))) {
          deepest = std::max(deepest, it.depth);
        }
      }
      EXPECT_LE(deepest, -kPlannedClearance.proven + 1e-6) << wrist << " " << round;
    }
  }
  EXPECT_GT(free, 20);
  EXPECT_GT(touching, 10);
}

INSTANTIATE_TEST_SUITE_P(Robots, RobotContacts, ::testing::Values("crichton", "hubo", "person"));

}  // namespace
}  // namespace handover
