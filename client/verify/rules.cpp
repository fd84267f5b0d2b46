// SPDX-License-Identifier: Apache-2.0
#include "verify/rules.hpp"

#include <algorithm>

namespace handover::verify {
namespace {

constexpr double kRestGap = 2e-3;  // [m]
constexpr double kNear = 1e-2;     // [m]

std::string linkName(const Scene& scene, int robot, int link) {
  return scene.plan.robots[static_cast<std::size_t>(robot)].name + "/" +
         scene.robots[static_cast<std::size_t>(robot)].links[static_cast<std::size_t>(link)].name;
}

std::set<std::string> handOf(const Scene& scene, const Party& party) {
  std::set<std::string> names;
  for (const int link : party.arm.hand_links) names.insert(linkName(scene, party.robot, link));
  return names;
}

/// Links of one rigid group, or of groups that one movable joint joins.
void addNeighbours(const Scene& scene, int robot, std::set<NamePair>& pairs) {
  const Robot& model = scene.robots[static_cast<std::size_t>(robot)];
  const std::vector<int> group = model.rigidGroups();
  std::set<std::pair<int, int>> joined;
  for (const Joint& joint : model.joints) {
    const int a = group[static_cast<std::size_t>(joint.parent)];
    const int b = group[static_cast<std::size_t>(joint.child)];
    joined.insert({a, b});
    joined.insert({b, a});
  }
  const int links = static_cast<int>(model.links.size());
  for (int a = 0; a < links; ++a) {
    for (int b = 0; b < links; ++b) {
      if (a == b) continue;
      const int ga = group[static_cast<std::size_t>(a)];
      const int gb = group[static_cast<std::size_t>(b)];
      if (ga == gb || joined.count({ga, gb}) || model.touching.count({a, b})) {
        pairs.insert({linkName(scene, robot, a), linkName(scene, robot, b)});
      }
    }
  }
}

}  // namespace

bool giverHolds(int stage) { return stage >= kGiverLift && stage <= kGiverRelease; }

bool receiverHolds(int stage) { return stage >= kGiverRelease && stage <= kReceiverPlace; }

bool isGiverStage(int stage) {
  return stage <= kGiverTransfer || stage == kGiverRelease || stage == kGiverRetreat;
}

bool isHandStage(int stage) {
  return stage == kGiverGrasp || stage == kReceiverGrasp || stage == kGiverRelease ||
         stage == kReceiverRelease;
}

ContactRules::ContactRules(const Scene& scene, std::set<std::string> goal_rest)
    : scene_(scene),
      giver_hand_(handOf(scene, scene.giver)),
      receiver_hand_(handOf(scene, scene.receiver)),
      goal_rest_(std::move(goal_rest)) {
  const Plan& plan = scene.plan;
  const auto add = [this](const std::string& a, const std::string& b) {
    standing_.insert({a, b});
    standing_.insert({b, a});
  };
  for (std::size_t r = 0; r < plan.robots.size(); ++r) {
    addNeighbours(scene, static_cast<int>(r), standing_);
    for (const auto& [link, object] : plan.robots[r].resting) {
      add(plan.robots[r].name + "/" + link, object);
    }
  }
  for (const PlanObject& object : plan.objects) {
    if (object.attached_to) {
      const std::string robot = object.attached_to->robot + "/";
      add(object.name, robot + object.attached_to->link);
      for (const std::string& link : object.attached_to->touch_links) {
        add(object.name, robot + link);
      }
    }
    for (const std::string& rest : object.resting) {
      if (object.name == plan.object) {
        start_rest_.insert(rest);
      } else if (rest == plan.object) {
        start_rest_.insert(object.name);
      } else {
        add(object.name, rest);
      }
    }
  }
}

bool ContactRules::standing(const std::string& a, const std::string& b) const {
  return standing_.count({a, b}) > 0;
}

bool ContactRules::standing(int body_a, int body_b) const {
  return standing(scene_.bodies[static_cast<std::size_t>(body_a)].name,
                  scene_.bodies[static_cast<std::size_t>(body_b)].name);
}

bool ContactRules::mayTouch(int stage, bool in_first_5mm, int body_a, int body_b) const {
  return mayTouch(stage, in_first_5mm, scene_.bodies[static_cast<std::size_t>(body_a)].name,
                  scene_.bodies[static_cast<std::size_t>(body_b)].name);
}

bool ContactRules::mayTouch(int stage, bool in_first_5mm, const std::string& a,
                            const std::string& b) const {
  const std::string& object = scene_.plan.object;
  if ((a == object) == (b == object)) return false;
  const std::string& other = a == object ? b : a;
  const bool giver_hand = giver_hand_.count(other) > 0;
  const bool receiver_hand = receiver_hand_.count(other) > 0;
  const bool start_rest = start_rest_.count(other) > 0;
  switch (stage) {
    case kGiverGrasp:
    case kGiverLift:
      return giver_hand || start_rest;
    case kGiverTransfer:
    case kReceiverReach:
    case kReceiverApproach:
      return giver_hand;
    case kReceiverGrasp:
    case kGiverRelease:
      return giver_hand || receiver_hand;
    case kGiverRetreat:
      return receiver_hand || (giver_hand && in_first_5mm);
    case kReceiverTransfer:
      return receiver_hand;
    case kReceiverPlace:
      return receiver_hand || goal_rest_.count(other) > 0;
    case kReceiverRelease:
      return receiver_hand;
    case kReceiverRetreat:
      return receiver_hand && in_first_5mm;
    default:
      return false;
  }
}

std::set<std::string> goalRests(const Motion& motion) {
  const Scene& scene = motion.scene();
  const Body& object = scene.bodies[static_cast<std::size_t>(scene.object_body)].body;
  const double placed = motion.stage(kReceiverPlace).end();
  Pose lower = scene.plan.X_WO_goal;
  Pose upper = scene.plan.X_WO_goal;
  lower.translation().z() -= kRestGap;
  upper.translation().z() += kRestGap;
  std::set<std::string> rests;
  for (const SceneBody& other : scene.bodies) {
    if (other.object < 0 || other.object == scene.object) continue;
    const Pose X_WS = motion.otherObjectAt(other.object, placed);
    if (clearance(object, lower, other.body, X_WS, kNear).touching &&
        !clearance(object, upper, other.body, X_WS, kNear).touching) {
      rests.insert(other.name);
    }
  }
  return rests;
}

}  // namespace handover::verify
