// SPDX-License-Identifier: Apache-2.0
// Contacts along the motion, by conservative advancement: a pair that is d apart cannot meet before
// its bodies have moved by d towards each other, and how far they can move is bounded from the
// joint speeds. Pairs far apart are hardly ever looked at, near ones as often as they need, and no
// contact deeper than half a millimetre slips between two looks.
//
// When stages of two robots overlap, a state is composed of both, and a contact is lawful if the
// row of any running stage allows it: the rows speak of different bodies, and a contact that one
// row allows (the object on its rest while it is lifted) does not turn unlawful because the other
// robot moves elsewhere.
#include "verify/checks.hpp"
#include "verify/unreadable.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <vector>

namespace handover::verify {
namespace {

constexpr double kMostTravel = 5e-3;     // [m] of any point between two states
constexpr double kFinest = 5e-4;         // [m] below which a pair's motion is not divided further
constexpr double kTiny = 1e-9;           // [m]
constexpr double kNear = 5e-2;           // [m] where boxes stop being good enough
constexpr double kReachSlack = 1e-2;     // [m] by which a lever may grow within one step
constexpr double kFirstMotion = 5e-3;    // [m] of a retreat in which the hand may still touch O
constexpr double kTimeTolerance = 1e-9;  // [s]
// A plan of a minute needs some thousands; a hostile file must not take hours.
constexpr double kMostStates = 3e5;

/// The link that a body moves with; robot -1: it stands.
struct Mount {
  int robot = -1, link = -1;
  Pose X_LB = Pose::Identity();  ///< of the body in the link; in the world where it stands
};

struct Pair {
  int a = -1, b = -1;
  std::size_t shared = 0;  ///< joints above both, which do not move them against each other
  int stage = -1;          ///< to which its contacts are put down
  double slack = 0;        ///< [m] that it may still move before it must be looked at
};

class CollisionCheck {
 public:
  CollisionCheck(const Motion& motion, const ContactRules& rules, Report& report)
      : motion_(motion), scene_(motion.scene()), rules_(rules), report_(report) {
    for (int s = 0; s < kStages; ++s) report_.stages.push_back({stageName(s)});
  }

  void run() {
    std::set<double> cuts;
    for (int s = 0; s < kStages; ++s) {
      cuts.insert(motion_.stage(s).start);
      cuts.insert(motion_.stage(s).end());
    }
    for (const int s : {static_cast<int>(kGiverRetreat), static_cast<int>(kReceiverRetreat)}) {
      first_5mm_end_[s] = endOfFirstMotion(s);
      cuts.insert(first_5mm_end_[s]);
    }
    for (auto from = cuts.begin(); std::next(from) != cuts.end(); ++from) {
      const double to = *std::next(from);
      if (to - *from > kTimeTolerance) interval(*from, to);
    }
  }

 private:
  const SceneBody& body(int index) const { return scene_.bodies[static_cast<std::size_t>(index)]; }

  StageChecks& counts(int stage) { return report_.stages[static_cast<std::size_t>(stage)]; }

  /// When the tool has moved 5 mm since the stage's start.
  double endOfFirstMotion(int s) const {
    const PlanEvent& stage = motion_.stage(s);
    const Party& party = scene_.partyOf(stage);
    const Eigen::Vector3d p_start =
        motion_.linkAt(party.robot, party.arm.tool_link, stage.start).translation();
    const auto moved = [&](double T) {
      return (motion_.linkAt(party.robot, party.arm.tool_link, T).translation() - p_start).norm();
    };
    constexpr int kParts = 8;
    double before = stage.start;
    for (std::size_t k = 0; k + 1 < stage.t.size(); ++k) {
      for (int part = 1; part <= kParts; ++part) {
        double after = stage.start + stage.t[k] + (stage.t[k + 1] - stage.t[k]) * part / kParts;
        if (moved(after) < kFirstMotion) {
          before = after;
          continue;
        }
        while (after - before > 1e-6) {
          const double middle = (before + after) / 2;
          (moved(middle) < kFirstMotion ? before : after) = middle;
        }
        return after;
      }
    }
    return stage.end();
  }

  /// A stretch of time in which the same stages run, the same hands hold, the same rules hold.
  void interval(double from, double to) {
    const double middle = (from + to) / 2;
    running_.clear();
    for (int s = 0; s < kStages; ++s) {
      if (motion_.stage(s).start < middle && middle < motion_.stage(s).end()) running_.push_back(s);
    }
    if (running_.empty()) return;
    mountBodies(middle);
    findPairs(middle);
    if (pairs_.empty()) return;

    std::set<double> times = {from, to};
    for (const int s : running_) {
      const PlanEvent& stage = motion_.stage(s);
      for (const double t : stage.t) {
        const double T = stage.start + t;
        if (T > from + kTimeTolerance && T < to - kTimeTolerance) times.insert(T);
      }
    }
    for (auto at = times.begin(); std::next(at) != times.end(); ++at) segment(*at, *std::next(at));
    place(to);
    for (std::size_t p = 0; p < pairs_.size();) {
      if (pairs_[p].slack <= kFinest && look(pairs_[p], to) < 0) {
        drop(p);
      } else {
        ++p;
      }
    }
  }

  void mountBodies(double middle) {
    mounts_.assign(scene_.bodies.size(), {});
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      const SceneBody& entry = scene_.bodies[i];
      if (entry.robot >= 0) {
        mounts_[i] = {entry.robot, entry.link, Pose::Identity()};
      } else if (entry.object != scene_.object) {
        const PlanObject& object = scene_.plan.objects[static_cast<std::size_t>(entry.object)];
        mounts_[i].X_LB = object.X_WO;
        if (object.attached_to) {
          mounts_[i] = mountOn(object.attached_to->robot, object.attached_to->link,
                               object.attached_to->X_LO);
        }
      } else {
        mounts_[i] = mountOfObject(middle);
      }
    }
    joints_.assign(scene_.bodies.size(), {});
    for (std::size_t i = 0; i < mounts_.size(); ++i) {
      if (mounts_[i].robot < 0) continue;
      const Robot& robot = scene_.robots[static_cast<std::size_t>(mounts_[i].robot)];
      for (const int joint : robot.jointsAbove(mounts_[i].link)) {
        if (runningStageOf(mounts_[i].robot, joint) >= 0) joints_[i].push_back(joint);
      }
    }
    suffix_.resize(scene_.bodies.size());
  }

  Mount mountOn(const std::string& robot, const std::string& link, const Pose& X_LO) const {
    const int index = scene_.plan.findRobot(robot);
    return {index, scene_.robots[static_cast<std::size_t>(index)].findLink(link), X_LO};
  }

  Mount mountOfObject(double middle) const {
    const Hold& giver = motion_.giverHold();
    const Hold& receiver = motion_.receiverHold();
    switch (motion_.carrierAt(middle)) {
      case Carrier::kGiver:
        return mountOn(giver.robot, giver.link, giver.X_LO);
      case Carrier::kReceiver:
        return mountOn(receiver.robot, receiver.link, receiver.X_LO);
      default:
        return {-1, -1, motion_.objectAt(middle)};
    }
  }

  /// The running stage that moves the joint, or -1.
  int runningStageOf(int robot, int joint) const {
    for (const int s : running_) {
      if (scene_.plan.findRobot(motion_.stage(s).robot) == robot && motion_.moves(s, joint)) {
        return s;
      }
    }
    return -1;
  }

  int movingStageOf(int index) const {
    const auto at = static_cast<std::size_t>(index);
    return joints_[at].empty() ? -1 : runningStageOf(mounts_[at].robot, joints_[at].front());
  }

  void findPairs(double middle) {
    pairs_.clear();
    const int bodies = static_cast<int>(scene_.bodies.size());
    for (int a = 0; a < bodies; ++a) {
      for (int b = a + 1; b < bodies; ++b) {
        const int stage = std::max(movingStageOf(a), movingStageOf(b));
        if (stage < 0 || rules_.standing(a, b) || allowed(a, b, middle)) continue;
        ++counts(stage).pairs;
        if (reported_.count({stage, {a, b}})) continue;
        pairs_.push_back({a, b, sharedJoints(a, b), stage, 0});
      }
    }
  }

  bool allowed(int a, int b, double middle) const {
    return std::any_of(running_.begin(), running_.end(), [&](int s) {
      const auto first = first_5mm_end_.find(s);
      return rules_.mayTouch(s, first != first_5mm_end_.end() && middle < first->second, a, b);
    });
  }

  std::size_t sharedJoints(int a, int b) const {
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

  /// Body poses at time T.
  void place(double T) {
    link_poses_.resize(scene_.robots.size());
    for (std::size_t r = 0; r < scene_.robots.size(); ++r) {
      link_poses_[r] = motion_.linksAt(static_cast<int>(r), T);
    }
    poses_.resize(scene_.bodies.size());
    for (std::size_t i = 0; i < mounts_.size(); ++i) {
      const Mount& mount = mounts_[i];
      poses_[i] = mount.robot < 0 ? mount.X_LB
                                  : link_poses_[static_cast<std::size_t>(mount.robot)]
                                               [static_cast<std::size_t>(mount.link)] *
                                        mount.X_LB;
    }
    for (const int s : running_) ++counts(s).states;
  }

  /// suffix_[body][i]: how far any point of the body can move by its joints from the i-th on, when
  /// the joints turn at these speeds for `duration`. @pre poses are those at the step's start.
  void boundTravel(const std::vector<std::vector<double>>& speeds, double duration) {
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
        suffix[k] = suffix[k + 1] + speeds[r][j] * duration * lever;
      }
    }
  }

  /// Between two samples of every running stage.
  void segment(double from, double to) {
    std::vector<std::vector<double>> speeds;
    for (std::size_t r = 0; r < scene_.robots.size(); ++r) {
      speeds.push_back(motion_.topSpeeds(static_cast<int>(r), from, to));
    }
    place(from);
    boundTravel(speeds, to - from);
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
      boundTravel(speeds, end - start);
      step(start, end);
    }
  }

  void step(double from, double to) {
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
      if (advance(pair, from, to, travel, disturbed)) {
        ++p;
      } else {
        drop(p);
      }
    }
  }

  /// Looks at the pair as often as needed between two times; false: it touches, and was reported.
  bool advance(Pair& pair, double from, double to, double travel, bool& disturbed) {
    double T = from;
    while (true) {
      const double distance = look(pair, T);
      if (distance < 0) return false;
      const double ahead = travel * (to - T) / (to - from);
      if (ahead <= std::max(distance, kFinest)) {
        pair.slack = travel > 0 ? distance - ahead : std::max(distance, kTiny);
        return true;
      }
      T += (to - from) * std::max(distance, kFinest) / travel;
      place(T);
      disturbed = true;
    }
  }

  /// Distance of the pair as it stands, or -1 when it touches, which is reported.
  double look(Pair& pair, double T) {
    const Clearance gap =
        clearance(body(pair.a).body, poses_[static_cast<std::size_t>(pair.a)], body(pair.b).body,
                  poses_[static_cast<std::size_t>(pair.b)], kNear);
    StageChecks& stage = counts(pair.stage);
    ++stage.queries;
    if (!gap.touching) {
      if (gap.distance < kNear) stage.clearance = std::min(stage.clearance, gap.distance);
      return gap.distance;
    }
    stage.clearance = 0;
    reported_.insert({pair.stage, {pair.a, pair.b}});
    const std::string& a = body(pair.a).name;
    const std::string& b = body(pair.b).name;
    report_.violations.push_back(
        {stageName(pair.stage), pair.stage, T, "collision", a + " touches " + b, {a, b}});
    return -1;
  }

  void drop(std::size_t p) {
    pairs_[p] = pairs_.back();
    pairs_.pop_back();
  }

  const Motion& motion_;
  const Scene& scene_;
  const ContactRules& rules_;
  Report& report_;
  double states_ = 0;
  std::map<int, double> first_5mm_end_;                     // of the retreats
  std::set<std::pair<int, std::pair<int, int>>> reported_;  // stage, bodies

  // Of the current interval:
  std::vector<int> running_;
  std::vector<Mount> mounts_;             // per body
  std::vector<std::vector<int>> joints_;  // per body: moving joints above it, root first
  std::vector<Pair> pairs_;
  // Of the current time:
  std::vector<std::vector<Pose>> link_poses_;  // per robot
  std::vector<Pose> poses_;                    // per body
  std::vector<std::vector<double>> suffix_;    // see boundTravel
};

}  // namespace

void checkCollisions(const Motion& motion, const ContactRules& rules, Report& report) {
  CollisionCheck(motion, rules, report).run();
}

}  // namespace handover::verify
