// SPDX-License-Identifier: Apache-2.0
#include "verify/checks.hpp"
#include "verify/contact_room.hpp"
#include "verify/pair_sweep.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace handover::verify {
namespace {

constexpr double kDegree = M_PI / 180;
constexpr double kTimeClaim = 1e-6;          // [s]
constexpr double kAngleClaim = 0.1;          // [deg]
constexpr double kRelativeClaim = 1e-2;      // of everything else
constexpr double kZero = 1e-6;               // of relative claims
constexpr double kClearanceLower = 2e-3;     // [m] by which a claim may be lower
constexpr double kClearanceHigher = 5e-4;    // [m] by which it may be higher
constexpr double kMostClearance = 0.05;      // [m]
constexpr double kClearanceFineness = 2e-4;  // [m] to which it is measured
constexpr int kTurnSteps = 4;                // of a piece of 20 ms, for the way that O turns

/// A figure that the contract leaves some room for.
struct Span {
  double least = 0, most = 0;

  static Span of(double value) { return {value, value}; }
};

/// Whether T is between the two.
bool runs(const Motion& motion, int stage, double T) {
  return motion.start(stage) < T && T < motion.end(stage);
}

// ---- times ------------------------------------------------------------------------------------

double objectBegins(const Motion& motion) { return motion.holdBegins(0); }

double objectEnds(const Motion& motion) {
  const HolderStages& last = motion.task().of.back();
  return last.release < 0 ? motion.end(last.carry) : motion.start(last.release);
}

/// Seconds of [from, to] in which an arm of the robot has O and no stage runs: none of the robot's,
/// and (longer) none of the arms that have it.
Span idleOf(const Motion& motion, int robot, double from, double to) {
  const Scene& scene = motion.scene();
  std::set<double> cuts = {from, to};
  const auto cut = [&](double T) {
    if (from < T && T < to) cuts.insert(T);
  };
  for (int s = 0; s < scene.stageCount(); ++s) {
    cut(motion.start(s));
    cut(motion.end(s));
  }
  Span idle;
  for (auto at = cuts.begin(); std::next(at) != cuts.end(); ++at) {
    const double middle = (*at + *std::next(at)) / 2;
    bool has = false, robot_runs = false, arm_runs = false;
    for (int k = 0; k < scene.holderCount(); ++k) {
      if (scene.holder(k).robot != robot) continue;
      const bool holds = motion.holdBegins(k) < middle && middle < motion.holdEnds(k);
      has = has || holds;
      for (int s = 0; s < scene.stageCount(); ++s) {
        if (!runs(motion, s, middle)) continue;
        const PlanHolder& other = scene.planHolder(scene.stage(s).holder);
        robot_runs = robot_runs || other.robot == scene.planHolder(k).robot;
        arm_runs = arm_runs || (holds && other.robot == scene.planHolder(k).robot &&
                                other.arm == scene.planHolder(k).arm);
      }
    }
    const double length = *std::next(at) - *at;
    if (has && !robot_runs) idle.least += length;
    if (has && !arm_runs) idle.most += length;
  }
  return idle;
}

// ---- bound ------------------------------------------------------------------------------------

/// Stages that count as one movement.
struct Movement {
  std::vector<int> stages;
  double bound = 0;
};

bool oneMovement(const std::string& before, const std::string& after) {
  return (before == "reach" && after == "approach") || (before == "lift" && after == "carry") ||
         (before == "carry" && after == "place") || (before == "retreat" && after == "home");
}

/// From rest to rest over a distance, within velocity and acceleration.
double restToRest(double distance, const ClaimedLimits& limits) {
  if (distance <= 0) return 0;
  if (limits.velocity <= 0 || limits.acceleration <= 0) return 0;
  const double top = limits.velocity * limits.velocity / limits.acceleration;
  if (distance <= top) return 2 * std::sqrt(distance / limits.acceleration);
  return distance / limits.velocity + limits.velocity / limits.acceleration;
}

class Bound {
 public:
  explicit Bound(const Motion& motion) : motion_(motion), scene_(motion.scene()) {
    const Task& task = motion.task();
    for (int s = 0; s < scene_.stageCount(); ++s) {
      const int before = task.previous[static_cast<std::size_t>(s)];
      if (before >= 0 && (task.joined[static_cast<std::size_t>(s)] ||
                          oneMovement(scene_.stage(before).action, scene_.stage(s).action))) {
        movement_of_.push_back(movement_of_[static_cast<std::size_t>(before)]);
      } else {
        movement_of_.push_back(static_cast<int>(movements_.size()));
        movements_.emplace_back();
      }
      movements_[static_cast<std::size_t>(movement_of_.back())].stages.push_back(s);
    }
    for (Movement& movement : movements_) movement.bound = alone(movement);
  }

  /// The contract leaves open whether a wait within a movement belongs to its actual duration, and
  /// the moment of the 5 mm to 1 ms.
  Span end() const {
    Span span{1e300, 0};
    for (const bool waits : {false, true}) {
      for (const bool late : {false, true}) {
        const double end = endWith(waits, late);
        span.least = std::min(span.least, end);
        span.most = std::max(span.most, end);
      }
    }
    return span;
  }

 private:
  double alone(const Movement& movement) const {
    std::map<std::string, double> distance;
    double still = 0;
    const PlanStage& first = scene_.stage(movement.stages.front());
    for (const int s : movement.stages) {
      const PlanStage& stage = scene_.stage(s);
      for (std::size_t c = 0; c < stage.joints.size(); ++c) {
        distance[stage.joints[c]] += std::abs(stage.q.back()[c] - stage.q.front()[c]);
      }
      if (stage.joints.empty()) still += stage.duration();
    }
    double longest = 0;
    const auto robot = static_cast<std::size_t>(scene_.plan.findRobot(first.robot));
    for (const auto& [joint, way] : distance) {
      longest = std::max(longest, restToRest(way, scene_.plan.robots[robot].limits.at(joint)));
    }
    return longest + still;
  }

  /// Of the stage's start in its movement, and of the whole movement, as they really are.
  double offset(int s, bool waits) const {
    const Movement& movement = movements_[static_cast<std::size_t>(movementOf(s))];
    if (waits) return motion_.start(s) - motion_.start(movement.stages.front());
    double sum = 0;
    for (const int other : movement.stages) {
      if (other == s) break;
      sum += scene_.stage(other).duration();
    }
    return sum;
  }

  double actual(int movement, bool waits) const {
    const int last = movements_[static_cast<std::size_t>(movement)].stages.back();
    return offset(last, waits) + scene_.stage(last).duration();
  }

  int movementOf(int s) const { return movement_of_[static_cast<std::size_t>(s)]; }

  double endWith(bool waits, bool late) const {
    std::vector<Precedence> edges;
    const Task& task = motion_.task();
    for (const RequiredEdge& edge : requiredEdges(scene_, task)) {
      const int to = movementOf(edge.stage), from = movementOf(edge.before);
      if (to == from) continue;
      double progress = edge.progress;
      if (late && scene_.stage(edge.before).action == "retreat" &&
          scene_.stage(edge.stage).action == "carry") {
        progress = task.hand_leaves[static_cast<std::size_t>(scene_.stage(edge.before).holder)];
      }
      const auto scale = [&](int m) {
        return movements_[static_cast<std::size_t>(m)].bound / actual(m, waits);
      };
      edges.push_back({from, to,
                       (offset(edge.before, waits) + progress) * scale(from) -
                           offset(edge.stage, waits) * scale(to)});
    }
    const int source = static_cast<int>(movements_.size());
    for (int m = 0; m < source; ++m) edges.push_back({source, m, 0});
    const LongestPaths paths(source + 1, edges);
    double end = 0;
    for (int m = 0; m < source; ++m) {
      end = std::max(end, paths.between(source, m).value_or(0) +
                              movements_[static_cast<std::size_t>(m)].bound);
    }
    return end;
  }

  const Motion& motion_;
  const Scene& scene_;
  std::vector<int> movement_of_;
  std::vector<Movement> movements_;
};

// ---- O's turning, limits ----------------------------------------------------------------------

double turnOfObject(const Motion& motion) {
  const Scene& scene = motion.scene();
  const Task& task = motion.task();
  double sum = 0;
  for (int k = 0; k <= task.last(); ++k) {
    const double from = motion.holdBegins(k);
    const double to =
        std::min(motion.end(), k < task.last() ? motion.holdBegins(k + 1) : motion.holdEnds(k));
    if (!(to > from)) continue;
    const int robot = scene.holder(k).robot;
    const std::vector<double> cuts = motion.cutsOf(robot, from, to);
    Pose before = motion.objectBy(k, from);
    for (std::size_t c = 0; c + 1 < cuts.size(); ++c) {
      const Rates rates =
          motion.ratesOf(robot, scene.holder(k).tool_link, {0, 0, 0}, cuts[c], cuts[c + 1]);
      if (rates.turn <= 0) continue;
      for (int step = 1; step <= kTurnSteps; ++step) {
        const Pose now = motion.objectBy(k, cuts[c] + (cuts[c + 1] - cuts[c]) * step / kTurnSteps);
        sum += rotationBetween(before, now);
        before = now;
      }
    }
  }
  return sum / kDegree;
}

std::optional<double> limitMargin(const Motion& motion) {
  const Scene& scene = motion.scene();
  std::optional<double> least;
  for (int k = 0; k < scene.holderCount(); ++k) {
    const int robot = scene.holder(k).robot;
    const int carry = motion.task().of[static_cast<std::size_t>(k)].carry;
    for (const double T : {takeTime(motion, k), giveTime(motion, k)}) {
      std::vector<double> q;
      motion.jointsAt(robot, T, q);
      for (const int j : scene.stage_joints[static_cast<std::size_t>(carry)]) {
        const auto joint = static_cast<std::size_t>(j);
        const ClaimedLimits& limits = scene.plan.robots[static_cast<std::size_t>(robot)].limits.at(
            scene.robot(robot).joints[joint].name);
        if (!limits.lower || !limits.upper || *limits.upper <= *limits.lower) continue;
        const double margin = std::min(q[joint] - *limits.lower, *limits.upper - q[joint]) /
                              (*limits.upper - *limits.lower);
        least = std::min(margin, least.value_or(margin));
      }
    }
  }
  return least;
}

// ---- clearance --------------------------------------------------------------------------------

/// Least distances over reach, carry and home.
class ClearanceSearch : public PairSweep::Client {
 public:
  enum Kind { kFurniture, kRobots, kObject, kObjectToLaterHands, kKinds };

  ClearanceSearch(const Motion& motion, const ContactRules& rules)
      : motion_(motion), scene_(motion.scene()), rules_(rules), sweep_(motion, {}, effort_) {
    for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
      const Mount mount = mountOf(scene_, static_cast<int>(b));
      robots_.push_back(mount.robot);
      arms_.push_back(armOf(mount));
      std::vector<int> hands;
      for (int k = 0; k < scene_.holderCount(); ++k) {
        const std::vector<int>& bodies = scene_.holder(k).hand_bodies;
        if (std::find(bodies.begin(), bodies.end(), static_cast<int>(b)) != bodies.end()) {
          hands.push_back(k);
        }
      }
      hands_.push_back(std::move(hands));
    }
    sweep_.along(*this);
  }

  const MeasuredClearance& found(Kind kind) const { return found_[kind]; }

  void interval(double middle, const std::vector<int>& running) override {
    counted_.clear();
    for (const int s : running) {
      const std::string& action = scene_.stage(s).action;
      if (action == "reach" || action == "carry" || action == "home") counted_.push_back(s);
    }
    in_hand_of_.clear();
    for (int k = 0; k < scene_.holderCount(); ++k) {
      if (motion_.holdBegins(k) < middle && middle < motion_.holdEnds(k)) in_hand_of_.push_back(k);
    }
  }

  bool select(PairSweep::Pair& pair, bool rigid) override {
    if (rigid || counted_.empty() || rules_.standing(pair.a, pair.b)) return false;
    pair.stage = -1;
    for (const int s : counted_) {
      if (sweep_.movedBy(s, pair.a) || sweep_.movedBy(s, pair.b)) pair.stage = s;
    }
    if (pair.stage < 0) return false;
    pair.tag = kindOf(pair);
    return pair.tag < kKinds;
  }

  double look(const PairSweep::Pair& pair, const Pose& X_WA, const Pose& X_WB, double) override {
    MeasuredClearance& least = found_[static_cast<std::size_t>(pair.tag)];
    const SceneBody& a = scene_.body(pair.a);
    const SceneBody& b = scene_.body(pair.b);
    const Clearance gap = clearance(a.body, X_WA, b.body, X_WB, least.least + kMostClearance);
    const double distance = gap.touching ? 0 : gap.distance;
    if (distance < least.least) least = {distance, pair.stage, {a.name, b.name}};
    return distance - least.least + kClearanceFineness;
  }

 private:
  /// The arm (of the yaml's list) that moves the body; -1: none.
  int armOf(const Mount& mount) const {
    if (mount.robot < 0) return -1;
    const Robot& robot = scene_.robot(mount.robot);
    const auto& arms = scene_.settings[static_cast<std::size_t>(mount.robot)].arms;
    const std::vector<int> above = robot.jointsAbove(mount.link);
    for (std::size_t a = 0; a < arms.size(); ++a) {
      if (std::find_first_of(above.begin(), above.end(), arms[a].begin(), arms[a].end()) !=
          above.end()) {
        return static_cast<int>(a);
      }
    }
    return -1;
  }

  int kindOf(const PairSweep::Pair& pair) const {
    if (pair.a == scene_.object_body || pair.b == scene_.object_body) {
      return objectKind(pair.a == scene_.object_body ? pair.b : pair.a);
    }
    const auto a = static_cast<std::size_t>(pair.a);
    const auto b = static_cast<std::size_t>(pair.b);
    if (robots_[a] < 0 || robots_[b] < 0) return kFurniture;
    if (robots_[a] == robots_[b] && (arms_[a] < 0 || arms_[b] < 0 || arms_[a] == arms_[b])) {
      return kKinds;
    }
    for (const int k : hands_[a]) {
      for (const int other : hands_[b]) {
        if (std::abs(k - other) == 1) return kKinds;
      }
    }
    return kRobots;
  }

  /// "All but its holders' hands" may mean those that have it now or all of the chain.
  int objectKind(int other) const {
    if (in_hand_of_.empty()) return kKinds;
    const std::vector<int>& hands = hands_[static_cast<std::size_t>(other)];
    if (hands.empty()) return kObject;
    const bool now = std::find_first_of(hands.begin(), hands.end(), in_hand_of_.begin(),
                                        in_hand_of_.end()) != hands.end();
    return now ? kKinds : kObjectToLaterHands;
  }

  const Motion& motion_;
  const Scene& scene_;
  const ContactRules& rules_;
  Effort effort_;
  PairSweep sweep_;
  std::vector<int> robots_, arms_;       ///< per body, of what carries it
  std::vector<std::vector<int>> hands_;  ///< per body: holders whose hand it belongs to
  std::vector<int> counted_, in_hand_of_;
  std::array<MeasuredClearance, kKinds> found_ = {
      MeasuredClearance{kMostClearance, -1, {}}, MeasuredClearance{kMostClearance, -1, {}},
      MeasuredClearance{kMostClearance, -1, {}}, MeasuredClearance{kMostClearance, -1, {}}};
};

// ---- claims -----------------------------------------------------------------------------------

class Comparison {
 public:
  Comparison(const QualityClaim& claim, Report& report) : claim_(claim), report_(report) {}

  void time(const std::string& name, double claimed, const Span& found) {
    check(name, claimed, {found.least - kTimeClaim, found.most + kTimeClaim}, found);
  }

  void angle(const std::string& name, double claimed, double found) {
    check(name, claimed, {found - kAngleClaim, found + kAngleClaim}, Span::of(found));
  }

  void relative(const std::string& name, double claimed, double found) {
    const double room = kRelativeClaim * std::max(std::abs(claimed), std::abs(found)) + kZero;
    check(name, claimed, {found - room, found + room}, Span::of(found));
  }

  void clearance(const std::string& name, double claimed, const Span& found) {
    check(name, claimed, {found.least - kClearanceLower, found.most + kClearanceHigher}, found);
  }

  void fault(const std::string& what) { report_.add({-1, 0, "quality", what, {}}); }

  const QualityClaim& claim() const { return claim_; }

 private:
  void check(const std::string& name, double claimed, const Span& lawful, const Span& found) {
    if (lawful.least <= claimed && claimed <= lawful.most) return;
    fault(name + " is given as " + text(claimed) + ", the plan has " + text(found.least) +
          (found.most > found.least ? " to " + text(found.most) : ""));
  }

  const QualityClaim& claim_;
  Report& report_;
};

// ---- all of it --------------------------------------------------------------------------------

/// What a plan is like, and the room for claims where the contract leaves some.
struct Measured {
  MeasuredQuality quality;
  Span bound;
  std::map<std::string, Span> idle, clearance;
};

void measureTimes(const Motion& motion, Measured& found) {
  const Scene& scene = motion.scene();
  found.quality.duration = motion.end();
  found.bound = Bound(motion).end();
  found.quality.bound = found.bound.least;
  const double from = objectBegins(motion), to = objectEnds(motion);
  found.quality.object = to - from;
  for (const PlanHolder& holder : scene.plan.holders) {
    const Span span = idleOf(motion, scene.plan.findRobot(holder.robot), from, to);
    found.idle[holder.robot] = span;
    found.quality.idle[holder.robot] = span.least;
  }
}

void measureClearance(const Motion& motion, const ContactRules& rules, Measured& found) {
  const ClearanceSearch search(motion, rules);
  const auto& object = search.found(ClearanceSearch::kObject);
  const auto& strict = search.found(ClearanceSearch::kObjectToLaterHands);
  found.quality.clearance["furniture"] = search.found(ClearanceSearch::kFurniture);
  found.quality.clearance["robots"] = search.found(ClearanceSearch::kRobots);
  found.quality.clearance["object"] = object;
  for (const auto& [between, least] : found.quality.clearance) {
    found.clearance[between] = Span::of(least.least);
  }
  found.clearance["object"].least = std::min(object.least, strict.least);
}

Measured measure(const Motion& motion, const ContactRules& rules, double tilt_deg) {
  const Scene& scene = motion.scene();
  Measured found;
  measureTimes(motion, found);
  found.quality.tilt_deg = std::max(0.0, tilt_deg);
  found.quality.turn_deg = turnOfObject(motion);
  found.quality.least_turn_deg =
      rotationBetween(scene.plan.start.X_WO, scene.plan.goal.X_WO) / kDegree;
  found.quality.limit_margin = limitMargin(motion);
  found.quality.jerk_share = jerkShare(scene);
  measureClearance(motion, rules, found);
  return found;
}

void compareIdle(const Measured& found, Comparison& compare) {
  const std::map<std::string, double>& claimed = compare.claim().idle;
  for (const auto& [robot, span] : found.idle) {
    const auto given = claimed.find(robot);
    if (given == claimed.end()) {
      compare.fault("idle_s says nothing of " + robot);
    } else {
      compare.time("idle_s of " + robot, given->second, span);
    }
  }
  for (const auto& [robot, seconds] : claimed) {
    if (!found.idle.count(robot)) compare.time("idle_s of " + robot, seconds, Span::of(0));
  }
}

void compareClearance(const Measured& found, Comparison& compare) {
  std::set<std::string> told;
  for (const ClearanceClaim& entry : compare.claim().clearance) {
    told.insert(entry.between);
    const auto span = found.clearance.find(entry.between);
    compare.clearance("clearance to " + entry.between, entry.least,
                      span == found.clearance.end() ? Span{} : span->second);
  }
  for (const auto& [between, span] : found.clearance) {
    if (!told.count(between)) compare.fault("clearance says nothing of " + between);
  }
}

void compareAll(const Measured& found, Comparison& compare) {
  const QualityClaim& claim = compare.claim();
  const MeasuredQuality& quality = found.quality;
  compare.time("duration_s", claim.duration, Span::of(quality.duration));
  compare.time("bound_s", claim.bound, found.bound);
  compare.time("object_s", claim.object, Span::of(quality.object));
  compareIdle(found, compare);
  compareClearance(found, compare);
  compare.angle("tilt_deg", claim.tilt_deg, quality.tilt_deg);
  compare.angle("object_turn_deg", claim.turn_deg, quality.turn_deg);
  compare.angle("the least object_turn_deg", claim.least_turn_deg, quality.least_turn_deg);
  if (claim.limit_margin.has_value() != quality.limit_margin.has_value()) {
    compare.fault("limit_margin is given where there is none, or not where there is one");
  } else if (quality.limit_margin) {
    compare.relative("limit_margin", *claim.limit_margin, *quality.limit_margin);
  }
  compare.relative("jerk_share", claim.jerk_share, quality.jerk_share);
}

}  // namespace

void checkQuality(const Motion& motion, const ContactRules& rules, double tilt_deg, bool all,
                  Report& report) {
  const auto& claim = motion.scene().plan.quality;
  if (!claim && !all) return;
  const Measured found = measure(motion, rules, tilt_deg);
  report.quality = found.quality;
  if (!claim) return;
  Comparison compare(*claim, report);
  compareAll(found, compare);
}

}  // namespace handover::verify
