// SPDX-License-Identifier: Apache-2.0
#include "verify/motion.hpp"

#include <algorithm>
#include <cmath>

namespace handover::verify {
namespace {

// A joint that a stage names but leaves where it is does not move anything.
constexpr double kStill = 1e-9;

const Hold* holdOf(const PlanEvent& stage, const std::string& object, const std::string& robot) {
  for (const Hold& hold : stage.holding) {
    if (hold.object == object && hold.robot == robot) return &hold;
  }
  return nullptr;
}

/// Segment of t that holds s, by the sample before it.
std::size_t segmentAt(const std::vector<double>& t, double s) {
  const auto after = std::upper_bound(t.begin(), t.end(), s);
  const auto index = static_cast<std::size_t>(std::distance(t.begin(), after));
  return std::clamp<std::size_t>(index, 1, t.size() - 1) - 1;
}

}  // namespace

const char* stageName(int stage) {
  static constexpr const char* kNames[kStages] = {
      "giver_reach",      "giver_approach",  "giver_grasp",       "giver_lift",
      "giver_transfer",   "receiver_reach",  "receiver_approach", "receiver_grasp",
      "giver_release",    "giver_retreat",   "receiver_transfer", "receiver_place",
      "receiver_release", "receiver_retreat"};
  return kNames[stage];
}

HermiteCubic cubicOf(const PlanEvent& stage, std::size_t segment, std::size_t joint) {
  return {stage.t[segment + 1] - stage.t[segment], stage.q[segment][joint],
          stage.qd[segment][joint], stage.q[segment + 1][joint], stage.qd[segment + 1][joint]};
}

Motion::Motion(const Scene& scene) : scene_(scene), stages_of_robot_(scene.robots.size()) {
  const Plan& plan = scene.plan;
  if (const Hold* hold = holdOf(stage(kGiverLift), plan.object, plan.giver)) giver_hold_ = *hold;
  if (const Hold* hold = holdOf(stage(kReceiverTransfer), plan.object, plan.receiver)) {
    receiver_hold_ = *hold;
  }
  for (std::size_t s = 0; s < plan.stages.size(); ++s) {
    const PlanEvent& entry = plan.stages[s];
    const int robot = plan.findRobot(entry.robot);
    const Robot& model = scene.robots[static_cast<std::size_t>(robot)];
    stages_of_robot_[static_cast<std::size_t>(robot)].push_back(static_cast<int>(s));
    joint_of_column_.emplace_back();
    std::vector<bool> moved(model.joints.size(), false);
    for (std::size_t c = 0; c < entry.joints.size(); ++c) {
      const auto joint = static_cast<std::size_t>(model.findJoint(entry.joints[c]));
      joint_of_column_.back().push_back(joint);
      for (std::size_t k = 0; k < entry.t.size(); ++k) {
        if (std::abs(entry.q[k][c] - entry.q[0][c]) > kStill || std::abs(entry.qd[k][c]) > kStill) {
          moved[joint] = true;
        }
      }
    }
    for (std::size_t j = 0; j < model.joints.size(); ++j) {
      int master = static_cast<int>(j);
      while (model.joints[static_cast<std::size_t>(master)].mimic >= 0) {
        master = model.joints[static_cast<std::size_t>(master)].mimic;
      }
      if (moved[static_cast<std::size_t>(master)]) moved[j] = true;
    }
    moved_.push_back(std::move(moved));
  }
  for (std::vector<int>& stages : stages_of_robot_) {
    std::stable_sort(stages.begin(), stages.end(),
                     [&](int a, int b) { return stage(a).start < stage(b).start; });
  }
}

bool Motion::moves(int stage, int joint) const {
  return moved_[static_cast<std::size_t>(stage)][static_cast<std::size_t>(joint)];
}

std::vector<double> Motion::jointsAt(int robot, double T) const {
  std::vector<double> q = scene_.q_start[static_cast<std::size_t>(robot)];
  for (const int s : stages_of_robot_[static_cast<std::size_t>(robot)]) {
    const PlanEvent& entry = stage(s);
    if (entry.start > T) break;
    const double local = std::min(T - entry.start, entry.t.back());
    const std::size_t segment = segmentAt(entry.t, local);
    const auto& columns = joint_of_column_[static_cast<std::size_t>(s)];
    for (std::size_t c = 0; c < columns.size(); ++c) {
      q[columns[c]] = local >= entry.t.back()
                          ? entry.q.back()[c]
                          : cubicOf(entry, segment, c).position(local - entry.t[segment]);
    }
  }
  scene_.robots[static_cast<std::size_t>(robot)].followMimics(q);
  return q;
}

std::vector<Pose> Motion::linksAt(int robot, double T) const {
  std::vector<Pose> X_WL;
  scene_.kinematics[static_cast<std::size_t>(robot)].linkPoses(jointsAt(robot, T), X_WL);
  return X_WL;
}

Pose Motion::linkAt(int robot, int link, double T) const {
  return linksAt(robot, T)[static_cast<std::size_t>(link)];
}

std::vector<double> Motion::topSpeeds(int robot, double from, double to) const {
  const Robot& model = scene_.robots[static_cast<std::size_t>(robot)];
  std::vector<double> speed(model.joints.size(), 0.0);
  for (const int s : stages_of_robot_[static_cast<std::size_t>(robot)]) {
    const PlanEvent& entry = stage(s);
    if (entry.start >= to || entry.end() <= from) continue;
    const std::size_t first = segmentAt(entry.t, from - entry.start);
    const std::size_t last = segmentAt(entry.t, to - entry.start - 1e-12);
    const auto& columns = joint_of_column_[static_cast<std::size_t>(s)];
    for (std::size_t c = 0; c < columns.size(); ++c) {
      double& top = speed[columns[c]];
      for (std::size_t k = first; k <= last; ++k) {
        top = std::max(top, cubicOf(entry, k, c).topSpeed());
      }
    }
  }
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    double multiplier = 1;
    std::size_t master = j;
    while (model.joints[master].mimic >= 0) {
      multiplier *= std::abs(model.joints[master].multiplier);
      master = static_cast<std::size_t>(model.joints[master].mimic);
    }
    if (master != j) speed[j] = multiplier * speed[master];
  }
  return speed;
}

Carrier Motion::carrierAt(double T) const {
  if (T < stage(kGiverLift).start) return Carrier::kNobodyAtStart;
  if (T < stage(kGiverRelease).start) return Carrier::kGiver;
  if (T <= stage(kReceiverPlace).end()) return Carrier::kReceiver;
  return Carrier::kNobodyAtGoal;
}

Pose Motion::objectByGiver(double T) const {
  const int robot = scene_.giver.robot;
  const int link = scene_.robots[static_cast<std::size_t>(robot)].findLink(giver_hold_.link);
  return linkAt(robot, link, T) * giver_hold_.X_LO;
}

Pose Motion::objectByReceiver(double T) const {
  const int robot = scene_.receiver.robot;
  const int link = scene_.robots[static_cast<std::size_t>(robot)].findLink(receiver_hold_.link);
  return linkAt(robot, link, T) * receiver_hold_.X_LO;
}

Pose Motion::objectAt(double T) const {
  switch (carrierAt(T)) {
    case Carrier::kNobodyAtStart:
      return scene_.plan.X_WO_start;
    case Carrier::kGiver:
      return objectByGiver(T);
    case Carrier::kReceiver:
      return objectByReceiver(T);
    case Carrier::kNobodyAtGoal:
      break;
  }
  return objectByReceiver(stage(kReceiverPlace).end());
}

Pose Motion::otherObjectAt(int object, double T) const {
  const PlanObject& entry = scene_.plan.objects[static_cast<std::size_t>(object)];
  if (!entry.attached_to) return entry.X_WO;
  const int robot = scene_.plan.findRobot(entry.attached_to->robot);
  const int link = scene_.robots[static_cast<std::size_t>(robot)].findLink(entry.attached_to->link);
  return linkAt(robot, link, T) * entry.attached_to->X_LO;
}

}  // namespace handover::verify
