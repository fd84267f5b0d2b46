// SPDX-License-Identifier: Apache-2.0
#include "verify/motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace handover::verify {
namespace {

// A joint that a stage names but leaves where it is does not move anything.
constexpr double kStill = 1e-9;
constexpr double kPiece = 0.02;       // [s]
constexpr double kMostPieces = 4000;  // of a stage

/// Segment of t that holds s, by the sample before it.
std::size_t segmentAt(const std::vector<double>& t, double s) {
  const auto after = std::upper_bound(t.begin(), t.end(), s);
  const auto index = static_cast<std::size_t>(std::distance(t.begin(), after));
  return std::clamp<std::size_t>(index, 1, t.size() - 1) - 1;
}

std::vector<bool> movedJoints(const Robot& robot, const PlanStage& stage,
                              const std::vector<int>& joints) {
  std::vector<bool> moved(robot.joints.size(), false);
  for (std::size_t c = 0; c < joints.size(); ++c) {
    for (std::size_t k = 0; k < stage.t.size(); ++k) {
      if (std::abs(stage.q[k][c] - stage.q[0][c]) > kStill || std::abs(stage.qd[k][c]) > kStill ||
          std::abs(stage.qdd[k][c]) > kStill) {
        moved[static_cast<std::size_t>(joints[c])] = true;
        break;
      }
    }
  }
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    if (moved[robot.lawOf(j).master]) moved[j] = true;
  }
  return moved;
}

}  // namespace

HermiteQuintic curveOf(const PlanStage& stage, std::size_t segment, std::size_t column) {
  const auto sample = [&](std::size_t k) {
    return JointSample{stage.q[k][column], stage.qd[k][column], stage.qdd[k][column]};
  };
  return {stage.t[segment + 1] - stage.t[segment], sample(segment), sample(segment + 1)};
}

Curves::Curves(const Scene& scene) : scene_(scene) {
  for (int s = 0; s < scene.stageCount(); ++s) {
    const PlanStage& stage = scene.stage(s);
    const std::vector<int>& joints = scene.stage_joints[static_cast<std::size_t>(s)];
    const Robot& robot = scene.robot(scene.stage_robot[static_cast<std::size_t>(s)]);
    moved_.push_back(movedJoints(robot, stage, joints));
    std::vector<double> cuts = {0};
    std::vector<float> speeds;
    const double piece = std::max(kPiece, stage.duration() / kMostPieces);
    for (std::size_t k = 0; k + 1 < stage.t.size(); ++k) {
      const double h = stage.t[k + 1] - stage.t[k];
      const int pieces = std::max(1, static_cast<int>(std::ceil(h / piece)));
      const std::size_t first = speeds.size();
      speeds.resize(first + static_cast<std::size_t>(pieces) * joints.size());
      for (std::size_t c = 0; c < joints.size(); ++c) {
        const Bernstein<4> velocity = curveOf(stage, k, c).change().derivative();
        for (int p = 0; p < pieces; ++p) {
          const double top = pieces == 1
                                 ? velocity.magnitude()
                                 : velocity.part(h * p / pieces, h * (p + 1) / pieces).magnitude();
          speeds[first + static_cast<std::size_t>(p) * joints.size() + c] =
              static_cast<float>(top * (1 + 1e-6));
        }
      }
      for (int p = 1; p <= pieces; ++p) {
        cuts.push_back(p == pieces ? stage.t[k + 1] : stage.t[k] + h * p / pieces);
      }
    }
    cuts_.push_back(std::move(cuts));
    speeds_.push_back(std::move(speeds));
  }
}

void Curves::raiseSpeeds(int stage, double from, double to, std::vector<double>& speeds) const {
  const std::vector<int>& joints = scene_.stage_joints[static_cast<std::size_t>(stage)];
  const std::vector<double>& times = cuts(stage);
  for (std::size_t p = segmentAt(times, from); p + 1 < times.size() && times[p] < to; ++p) {
    const float* row = speeds_[static_cast<std::size_t>(stage)].data() + p * joints.size();
    for (std::size_t c = 0; c < joints.size(); ++c) {
      double& speed = speeds[static_cast<std::size_t>(joints[c])];
      speed = std::max(speed, static_cast<double>(row[c]));
    }
  }
}

void Curves::setJoints(int stage, double s, std::vector<double>& q) const {
  const PlanStage& entry = scene_.stage(stage);
  const std::vector<int>& joints = scene_.stage_joints[static_cast<std::size_t>(stage)];
  const bool done = s >= entry.t.back();
  const std::size_t segment = segmentAt(entry.t, s);
  for (std::size_t c = 0; c < joints.size(); ++c) {
    q[static_cast<std::size_t>(joints[c])] =
        done ? entry.q.back()[c]
             : curveOf(entry, segment, c).position(std::max(0.0, s - entry.t[segment]));
  }
}

Motion::Motion(const Curves& curves, const Task& task, std::vector<double> starts)
    : curves_(curves),
      task_(task),
      starts_(std::move(starts)),
      stages_of_robot_(scene().robots.size()) {
  for (int s = 0; s < scene().stageCount(); ++s) {
    stages_of_robot_[static_cast<std::size_t>(scene().stage_robot[static_cast<std::size_t>(s)])]
        .push_back(s);
  }
  for (std::vector<int>& stages : stages_of_robot_) {
    std::stable_sort(stages.begin(), stages.end(),
                     [&](int a, int b) { return start(a) < start(b); });
  }
}

double Motion::end() const {
  double last = 0;
  for (int s = 0; s < scene().stageCount(); ++s) last = std::max(last, end(s));
  return last;
}

void Motion::jointsAt(int robot, double T, std::vector<double>& q) const {
  q = scene().q_start[static_cast<std::size_t>(robot)];
  for (const int s : stages_of_robot_[static_cast<std::size_t>(robot)]) {
    if (start(s) > T) break;
    curves_.setJoints(s, T - start(s), q);
  }
  scene().robot(robot).followMimics(q);
}

void Motion::linksAt(int robot, double T, std::vector<Pose>& X_WL) const {
  std::vector<double> q;
  jointsAt(robot, T, q);
  scene().kinematics[static_cast<std::size_t>(robot)].linkPoses(q, X_WL);
}

Pose Motion::linkAt(int robot, int link, double T) const {
  std::vector<double> q;
  jointsAt(robot, T, q);
  return scene().kinematics[static_cast<std::size_t>(robot)].linkPose(link, q);
}

Pose Motion::toolAt(int holder, double T) const {
  return linkAt(scene().holder(holder).robot, scene().holder(holder).tool_link, T);
}

void Motion::topSpeeds(int robot, double from, double to, std::vector<double>& speeds) const {
  const Robot& model = scene().robot(robot);
  speeds.assign(model.joints.size(), 0.0);
  for (const int s : stages_of_robot_[static_cast<std::size_t>(robot)]) {
    if (start(s) >= to || end(s) <= from) continue;
    curves_.raiseSpeeds(s, from - start(s), to - start(s), speeds);
  }
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    if (model.joints[j].mimic < 0) continue;
    const Law law = model.lawOf(j);
    speeds[j] = std::abs(law.multiplier) * speeds[law.master];
  }
}

Rates Motion::ratesOf(int robot, int link, const Eigen::Vector3d& p_L, double from,
                      double to) const {
  const Robot& model = scene().robot(robot);
  std::vector<double> speeds;
  topSpeeds(robot, from, to, speeds);
  Rates rates;
  std::vector<int> turning;
  for (const int j : model.jointsAbove(link)) {
    const double speed = speeds[static_cast<std::size_t>(j)];
    if (speed <= 0) continue;
    if (model.joints[static_cast<std::size_t>(j)].type == JointType::kPrismatic) {
      rates.point += speed;
    } else {
      rates.turn += speed;
      turning.push_back(j);
    }
  }
  if (turning.empty()) return rates;
  std::vector<Pose> X_WL;
  linksAt(robot, from, X_WL);
  const Eigen::Vector3d p_W = X_WL[static_cast<std::size_t>(link)] * p_L;
  for (const int j : turning) {
    const Joint& joint = model.joints[static_cast<std::size_t>(j)];
    const Pose& X_WC = X_WL[static_cast<std::size_t>(joint.child)];
    rates.point += speeds[static_cast<std::size_t>(j)] *
                   (X_WC.linear() * joint.axis).cross(p_W - X_WC.translation()).norm();
  }
  // A lever grows at most by as much as the point moves meanwhile.
  const double turned = rates.turn * (to - from);
  if (turned < 0.9) {
    rates.point /= 1 - turned;
  } else {
    // So fast that levers cannot be foreseen: none is longer than the whole robot.
    double reach = p_L.norm();
    for (const Joint& joint : model.joints) {
      reach += joint.X_PJ.translation().norm();
      if (joint.type == JointType::kPrismatic) reach += joint.upper - joint.lower;
    }
    for (const int j : turning) rates.point += speeds[static_cast<std::size_t>(j)] * reach;
  }
  return rates;
}

std::vector<double> Motion::cutsOf(int robot, double from, double to) const {
  std::vector<double> times = {from, to};
  const auto add = [&](double T) {
    if (T > from && T < to) times.push_back(T);
  };
  for (const int s : stages_of_robot_[static_cast<std::size_t>(robot)]) {
    if (start(s) >= to || end(s) <= from) continue;
    for (const double cut : curves_.cuts(s)) add(start(s) + cut);
    add(end(s));
  }
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

double Motion::holdBegins(int holder) const {
  const int grasp = task_.of[static_cast<std::size_t>(holder)].grasp;
  return grasp < 0 ? 0 : end(grasp);
}

double Motion::holdEnds(int holder) const {
  const int release = task_.of[static_cast<std::size_t>(holder)].release;
  return release < 0 ? std::numeric_limits<double>::infinity() : end(release);
}

int Motion::carrierAt(double T) const {
  int carrier = kAtStart;
  for (int k = 0; k <= task_.last(); ++k) {
    if (holdBegins(k) <= T) carrier = k;
  }
  return carrier >= 0 && carrier == task_.last() && T >= holdEnds(carrier) ? kAtGoal : carrier;
}

Pose Motion::objectBy(int holder, double T) const {
  return toolAt(holder, T) * scene().planHolder(holder).X_OT.inverse();
}

Pose Motion::objectAt(double T) const {
  const int carrier = carrierAt(T);
  if (carrier == kAtStart) return scene().plan.start.X_WO;
  if (carrier == kAtGoal) return objectBy(task_.last(), holdEnds(task_.last()));
  return objectBy(carrier, T);
}

Pose Motion::bodyAt(int body, double T) const {
  const SceneBody& entry = scene().body(body);
  if (entry.robot >= 0) return linkAt(entry.robot, entry.link, T);
  return entry.object == scene().object ? objectAt(T) : otherObjectAt(entry.object, T);
}

Pose Motion::otherObjectAt(int object, double T) const {
  const PlanObject& entry = scene().planObject(object);
  if (!entry.attached_to) return entry.X_WO;
  const int robot = scene().plan.findRobot(entry.attached_to->robot);
  return linkAt(robot, scene().robot(robot).findLink(entry.attached_to->link), T) *
         entry.attached_to->X_LO;
}

std::vector<double> plannedStarts(const Scene& scene) {
  std::vector<double> starts;
  for (const PlanStage& stage : scene.plan.stages) starts.push_back(stage.start);
  return starts;
}

}  // namespace handover::verify
