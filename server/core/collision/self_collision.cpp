// SPDX-License-Identifier: Apache-2.0
#include "core/collision/self_collision.hpp"

#include "core/collision/collision_scene.hpp"

#include <random>
#include <stdexcept>

namespace handover {
namespace {

// The same numbers with every standard library, unlike std::uniform_real_distribution.
double uniform(std::mt19937_64& random, double lower, double upper) {
  return lower + (upper - lower) * (static_cast<double>(random() >> 11) * 0x1.0p-53);
}

RobotVector randomPosture(const RobotModel& model, std::mt19937_64& random) {
  RobotVector q(model.dofs());
  for (const DofId dof : IdRange<DofId>(model.dofs())) {
    const Joint& joint = model.joints[model.dof_joints[dof]];
    q[dof.value()] = uniform(random, joint.lower, joint.upper);
  }
  return q;
}

}  // namespace

std::vector<LinkPairTouch> sampleSelfCollision(const RobotModel& model, int samples,
                                               std::uint64_t seed) {
  if (samples <= 0) throw std::invalid_argument("sampleSelfCollision: samples must be positive");
  RobotModel bare = model;
  bare.disabled_pairs.clear();
  SceneRobot robot;
  robot.name = model.name;
  robot.model = std::make_shared<const RobotModel>(std::move(bare));
  robot.q_start = RobotVector::Zero(model.dofs());
  Scene scene;
  scene.robots.push_back(std::move(robot));
  CollisionWorld world(std::make_shared<const CollisionScene>(scene));

  std::vector<LinkPairTouch> pairs;
  std::vector<PairList> lists;
  const IdRange<LinkId> links(model.links.size());
  for (const LinkId a : links) {
    for (const LinkId b : links) {
      if (!(a < b)) continue;
      const BodyId body_a = world.scene().linkBody(RobotId(0), a),
                   body_b = world.scene().linkBody(RobotId(0), b);
      if (!body_a.valid() || !body_b.valid()) continue;
      if (world.scene().standingPairs().contains(body_a, body_b)) continue;
      pairs.push_back({a, b, TouchPattern::kNever, 0});
      lists.push_back(PairList({{body_a, body_b}}));
    }
  }
  std::mt19937_64 random(seed);
  std::vector<Pose> X_WL;
  for (int i = 0; i < samples; ++i) {
    linkPoses(model, Pose::Identity(), randomPosture(model, random), X_WL);
    world.setRobot(RobotId(0), X_WL);
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      if (!world.isFree(lists[p])) ++pairs[p].touching;
    }
  }
  for (LinkPairTouch& pair : pairs) {
    if (pair.touching == 0) continue;
    pair.pattern = pair.touching == samples ? TouchPattern::kAlways : TouchPattern::kSometimes;
  }
  return pairs;
}

}  // namespace handover
