// SPDX-License-Identifier: Apache-2.0
#include "verify/pair_sweep.hpp"

#include "verify/contact_room.hpp"
#include "verify/order.hpp"
#include "verify/unreadable.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace handover::verify {
namespace {

constexpr double kMostTravel = 5e-3;  // [m] of any point between two states
constexpr double kTiny = 1e-9;        // [m]
constexpr double kReachSlack = 1e-2;  // [m] by which a lever may grow within one step
// A plan of a minute needs some thousands; a hostile file must not take hours.
constexpr double kMostStates = 3e5;

}  // namespace

PairSweep::PairSweep(const Motion& motion, const std::vector<double>& cuts, Effort& effort)
    : motion_(motion), scene_(motion.scene()), cuts_(cuts), effort_(effort) {
  for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
    mounts_.push_back(mountOf(scene_, static_cast<int>(b)));
  }
}

void PairSweep::atStart(Client& client) {
  running_.clear();
  mountBodies(0);
  client.interval(0, running_);
  place(0);
  const int bodies = static_cast<int>(scene_.bodies.size());
  for (int a = 0; a < bodies; ++a) {
    for (int b = a + 1; b < bodies; ++b) {
      Pair pair;
      pair.a = a;
      pair.b = b;
      if (client.select(pair, false)) look(pair, 0, client);
    }
  }
}

void PairSweep::along(Client& client) {
  std::set<double> cuts(cuts_.begin(), cuts_.end());
  for (int s = 0; s < scene_.stageCount(); ++s) {
    cuts.insert(motion_.start(s));
    cuts.insert(motion_.end(s));
  }
  for (auto from = cuts.begin(); std::next(from) != cuts.end(); ++from) {
    const double to = *std::next(from);
    if (to - *from > kTimeTolerance) interval(*from, to, client);
  }
}

bool PairSweep::movedBy(int stage, int body) const {
  const Mount& mount = mounts_[static_cast<std::size_t>(body)];
  if (mount.robot != scene_.stage_robot[static_cast<std::size_t>(stage)]) return false;
  const std::vector<int>& joints = joints_[static_cast<std::size_t>(body)];
  return std::any_of(joints.begin(), joints.end(),
                     [&](int j) { return motion_.curves().moves(stage, j); });
}

void PairSweep::interval(double from, double to, Client& client) {
  const double middle = (from + to) / 2;
  running_.clear();
  for (int s = 0; s < scene_.stageCount(); ++s) {
    if (motion_.start(s) < middle && middle < motion_.end(s)) running_.push_back(s);
  }
  if (running_.empty()) return;
  mountBodies(middle);
  client.interval(middle, running_);
  findPairs(client);
  if (pairs_.empty()) return;

  std::set<double> times = {from, to};
  for (const int s : running_) {
    for (const double t : motion_.curves().cuts(s)) {
      const double T = motion_.start(s) + t;
      if (T > from + kTimeTolerance && T < to - kTimeTolerance) times.insert(T);
    }
  }
  for (auto at = times.begin(); std::next(at) != times.end(); ++at)
    segment(*at, *std::next(at), client);
  place(to);
  for (std::size_t p = 0; p < pairs_.size();) {
    if (pairs_[p].slack <= kFinest && look(pairs_[p], to, client) < 0) {
      drop(p);
    } else {
      ++p;
    }
  }
}

void PairSweep::mountBodies(double T) {
  mounts_[static_cast<std::size_t>(scene_.object_body)] = mountOfObject(motion_, T);
  joints_.assign(scene_.bodies.size(), {});
  for (std::size_t i = 0; i < mounts_.size(); ++i) {
    if (mounts_[i].robot < 0) continue;
    for (const int joint : scene_.robot(mounts_[i].robot).jointsAbove(mounts_[i].link)) {
      if (runningStageOf(mounts_[i].robot, joint) >= 0) joints_[i].push_back(joint);
    }
  }
  suffix_.resize(scene_.bodies.size());
}

int PairSweep::runningStageOf(int robot, int joint) const {
  for (const int s : running_) {
    if (scene_.stage_robot[static_cast<std::size_t>(s)] == robot &&
        motion_.curves().moves(s, joint)) {
      return s;
    }
  }
  return -1;
}

void PairSweep::findPairs(Client& client) {
  pairs_.clear();
  const int bodies = static_cast<int>(scene_.bodies.size());
  std::vector<int> stages;
  for (std::size_t i = 0; i < mounts_.size(); ++i) {
    stages.push_back(joints_[i].empty() ? -1
                                        : runningStageOf(mounts_[i].robot, joints_[i].front()));
  }
  for (int a = 0; a < bodies; ++a) {
    for (int b = a + 1; b < bodies; ++b) {
      Pair pair;
      pair.a = a;
      pair.b = b;
      pair.stage =
          std::max(stages[static_cast<std::size_t>(a)], stages[static_cast<std::size_t>(b)]);
      if (pair.stage < 0) continue;
      pair.shared = sharedJoints(a, b);
      const bool rigid = joints_[static_cast<std::size_t>(a)].size() == pair.shared &&
                         joints_[static_cast<std::size_t>(b)].size() == pair.shared;
      if (!client.select(pair, rigid)) continue;
      ++effort_.pairs;
      pairs_.push_back(pair);
    }
  }
}

std::size_t PairSweep::sharedJoints(int a, int b) const {
  const auto i = static_cast<std::size_t>(a);
  const auto k = static_cast<std::size_t>(b);
  if (mounts_[i].robot != mounts_[k].robot) return 0;
  std::size_t shared = 0;
  while (shared < joints_[i].size() && shared < joints_[k].size() &&
         joints_[i][shared] == joints_[k][shared]) {
    ++shared;
  }
  return shared;
}

void PairSweep::place(double T) {
  link_poses_.resize(scene_.robots.size());
  for (std::size_t r = 0; r < scene_.robots.size(); ++r) {
    motion_.linksAt(static_cast<int>(r), T, link_poses_[r]);
  }
  poses_.resize(scene_.bodies.size());
  for (std::size_t i = 0; i < mounts_.size(); ++i) {
    const Mount& mount = mounts_[i];
    poses_[i] = mount.robot < 0 ? mount.X_LB
                                : link_poses_[static_cast<std::size_t>(mount.robot)]
                                             [static_cast<std::size_t>(mount.link)] *
                                      mount.X_LB;
  }
  ++effort_.states;
}

void PairSweep::boundTravel(double duration) {
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    auto& suffix = suffix_[i];
    suffix.assign(joints_[i].size() + 1, 0.0);
    if (joints_[i].empty()) continue;
    const auto r = static_cast<std::size_t>(mounts_[i].robot);
    const Body& shape = scene_.bodies[i].body;
    const Eigen::Vector3d centre = poses_[i] * shape.centre();
    for (std::size_t k = joints_[i].size(); k-- > 0;) {
      const auto j = static_cast<std::size_t>(joints_[i][k]);
      const Joint& joint = scene_.robots[r].joints[j];
      double lever = 1;
      if (joint.type != JointType::kPrismatic) {
        const Pose& X_WC = link_poses_[r][static_cast<std::size_t>(joint.child)];
        const Eigen::Vector3d arm = centre - X_WC.translation();
        lever = (X_WC.linear() * joint.axis).cross(arm).norm() + shape.radius() + kReachSlack;
      }
      suffix[k] = suffix[k + 1] + speeds_[r][j] * duration * lever;
    }
  }
}

void PairSweep::segment(double from, double to, Client& client) {
  speeds_.resize(scene_.robots.size());
  for (std::size_t r = 0; r < scene_.robots.size(); ++r) {
    motion_.topSpeeds(static_cast<int>(r), from, to, speeds_[r]);
  }
  place(from);
  boundTravel(to - from);
  double travel = 0;
  for (const auto& suffix : suffix_) travel = std::max(travel, suffix.front());
  const double wanted = std::max(1.0, std::ceil(travel / kMostTravel));
  states_ += wanted;
  if (states_ > kMostStates) throw Unreadable("/plan/stages", "too much motion to be checked");
  const int steps = static_cast<int>(wanted);
  for (int k = 0; k < steps; ++k) {
    const double start = from + (to - from) * k / steps;
    const double end = k + 1 == steps ? to : from + (to - from) * (k + 1) / steps;
    if (k > 0) place(start);
    boundTravel(end - start);
    step(start, end, client);
  }
}

void PairSweep::step(double from, double to, Client& client) {
  bool disturbed = false;  // poses_ are no longer those at `from`
  for (std::size_t p = 0; p < pairs_.size();) {
    Pair& pair = pairs_[p];
    const double travel = suffix_[static_cast<std::size_t>(pair.a)][pair.shared] +
                          suffix_[static_cast<std::size_t>(pair.b)][pair.shared];
    if (travel <= pair.slack && pair.slack > 0) {
      pair.slack -= travel;
      ++p;
      continue;
    }
    if (disturbed) place(from);
    disturbed = false;
    if (advance(pair, from, to, travel, disturbed, client)) {
      ++p;
    } else {
      drop(p);
    }
  }
}

bool PairSweep::advance(Pair& pair, double from, double to, double travel, bool& disturbed,
                        Client& client) {
  double T = from;
  while (true) {
    const double room = look(pair, T, client);
    if (room < 0) return false;
    const double ahead = travel * (to - T) / (to - from);
    if (ahead <= std::max(room, kFinest)) {
      pair.slack = travel > 0 ? room - ahead : std::max(room, kTiny);
      return true;
    }
    T += (to - from) * std::max(room, kFinest) / travel;
    place(T);
    disturbed = true;
  }
}

double PairSweep::look(const Pair& pair, double T, Client& client) {
  ++effort_.queries;
  return client.look(pair, poses_[static_cast<std::size_t>(pair.a)],
                     poses_[static_cast<std::size_t>(pair.b)], T);
}

void PairSweep::drop(std::size_t p) {
  pairs_[p] = pairs_.back();
  pairs_.pop_back();
}

}  // namespace handover::verify
