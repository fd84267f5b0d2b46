// SPDX-License-Identifier: Apache-2.0
#include "verify/rules.hpp"

#include <algorithm>
#include <limits>

namespace handover::verify {
namespace {

constexpr double kNoneReach = 2e-3;  // [m] within which an object is the rest of "none"
constexpr double kForever = std::numeric_limits<double>::infinity();

std::string linkName(const Scene& scene, int robot, int link) {
  return scene.plan.robots[static_cast<std::size_t>(robot)].name + "/" +
         scene.robot(robot).links[static_cast<std::size_t>(link)].name;
}

/// Links of one rigid group, or of groups that one movable joint joins, and the SRDF's pairs.
void addNeighbours(const Scene& scene, int robot, std::set<NamePair>& pairs) {
  const Robot& model = scene.robot(robot);
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

std::set<NamePair> standingPairs(const Scene& scene) {
  std::set<NamePair> pairs;
  const auto add = [&](const std::string& a, const std::string& b) {
    pairs.insert({a, b});
    pairs.insert({b, a});
  };
  const Plan& plan = scene.plan;
  for (std::size_t r = 0; r < plan.robots.size(); ++r) {
    addNeighbours(scene, static_cast<int>(r), pairs);
    for (const auto& [link, object] : plan.robots[r].resting) {
      add(plan.robots[r].name + "/" + link, object);
    }
  }
  for (const PlanObject& object : plan.objects) {
    if (object.name == plan.object) continue;  // start and goal speak for O
    if (object.attached_to) {
      const std::string robot = object.attached_to->robot + "/";
      add(object.name, robot + object.attached_to->link);
      for (const std::string& link : object.attached_to->touch_links) {
        add(object.name, robot + link);
      }
    }
    for (const std::string& rest : object.resting) add(object.name, rest);
  }
  return pairs;
}

std::set<int> restsOf(const Motion& motion, const Rest& rest, const Pose& X_WO, double T) {
  const Scene& scene = motion.scene();
  std::set<int> found;
  if (rest) {
    for (const std::string& name : *rest) found.insert(scene.plan.findObject(name));
    return found;
  }
  const Body& object = scene.body(scene.object_body).body;
  for (const SceneBody& other : scene.bodies) {
    if (other.object < 0 || other.object == scene.object) continue;
    const Clearance gap =
        clearance(object, X_WO, other.body, motion.otherObjectAt(other.object, T), 2 * kNoneReach);
    if (gap.touching || gap.distance <= kNoneReach) found.insert(other.object);
  }
  return found;
}

}  // namespace

Window handWindow(const Motion& motion, int holder) {
  const Task& task = motion.task();
  const HolderStages& stages = task.of[static_cast<std::size_t>(holder)];
  return {stages.grasp < 0 ? -kForever : motion.start(stages.grasp),
          stages.retreat < 0
              ? kForever
              : motion.start(stages.retreat) + task.hand_leaves[static_cast<std::size_t>(holder)]};
}

Window startRestWindow(const Motion& motion) {
  const int lift = motion.task().of.front().lift;
  return {-kForever, lift < 0 ? -kForever : motion.end(lift)};
}

Window goalRestWindow(const Motion& motion) {
  const int place = motion.task().of.back().place;
  return {place < 0 ? kForever : motion.start(place), kForever};
}

Allowances allowancesAt(const Motion& motion, double T) {
  const auto within = [&](const Window& window) { return window.from <= T && T <= window.to; };
  Allowances allowances;
  for (int k = 0; k <= motion.task().last(); ++k) {
    allowances.hand.push_back(within(handWindow(motion, k)));
  }
  allowances.start_rest = within(startRestWindow(motion));
  allowances.goal_rest = within(goalRestWindow(motion));
  return allowances;
}

ContactRules::ContactRules(const Scene& scene, const std::set<int>& start_rests,
                           const std::set<int>& goal_rests)
    : scene_(scene),
      bodies_(scene.bodies.size()),
      standing_(bodies_ * bodies_, false),
      standing_names_(standingPairs(scene)),
      hands_of_(bodies_),
      start_rests_(start_rests),
      goal_rests_(goal_rests) {
  for (std::size_t a = 0; a < bodies_; ++a) {
    for (std::size_t b = 0; b < bodies_; ++b) {
      standing_[a * bodies_ + b] = standing(scene.bodies[a].name, scene.bodies[b].name);
    }
  }
  for (int k = 0; k < scene.holderCount(); ++k) {
    const Holder& holder = scene.holder(k);
    for (const int body : holder.hand_bodies) {
      hands_of_[static_cast<std::size_t>(body)].push_back(k);
    }
    std::set<std::string> names;
    for (const int link : holder.hand_links) names.insert(linkName(scene, holder.robot, link));
    hand_names_.push_back(std::move(names));
  }
}

std::optional<double> ContactRules::depthAllowed(const Allowances& allowances, int body_a,
                                                 int body_b) const {
  if (body_a != scene_.object_body && body_b != scene_.object_body) return std::nullopt;
  const int other = body_a == scene_.object_body ? body_b : body_a;
  const SceneBody& entry = scene_.body(other);
  if (entry.object >= 0) {
    if (allowances.start_rest && start_rests_.count(entry.object)) return kRestDepth;
    if (allowances.goal_rest && goal_rests_.count(entry.object)) return kRestDepth;
    return std::nullopt;
  }
  for (const int k : hands_of_[static_cast<std::size_t>(other)]) {
    if (allowances.hand[static_cast<std::size_t>(k)]) return kHandDepth;
  }
  return std::nullopt;
}

bool ContactRules::mayTouch(const Allowances& allowances, const std::string& a,
                            const std::string& b) const {
  const std::string& object = scene_.plan.object;
  if ((a == object) == (b == object)) return false;
  const std::string& other = a == object ? b : a;
  const int index = scene_.plan.findObject(other);
  if (index >= 0) {
    return (allowances.start_rest && start_rests_.count(index)) ||
           (allowances.goal_rest && goal_rests_.count(index));
  }
  for (std::size_t k = 0; k < hand_names_.size(); ++k) {
    if (allowances.hand[k] && hand_names_[k].count(other)) return true;
  }
  return false;
}

std::set<int> startRests(const Motion& motion) {
  const PlanStart& start = motion.scene().plan.start;
  if (start.held_by) return {};
  return restsOf(motion, start.rest, start.X_WO, 0);
}

std::set<int> goalRests(const Motion& motion) {
  const PlanGoal& goal = motion.scene().plan.goal;
  if (!goal.release) return {};
  return restsOf(motion, goal.rest, goal.X_WO, motion.end());
}

}  // namespace handover::verify
