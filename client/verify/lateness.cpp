// SPDX-License-Identifier: Apache-2.0
// Contacts between arms of which any may be late. How a body of one arm stands to a body of another
// depends on two numbers alone: how far each arm has come in its own stages. All pairs of these
// that some lateness can bring together form a band around the plan's own; it is covered by
// rectangles, each of which is clear when the bodies are farther apart in its middle than they can
// move within it, and divided otherwise. So nothing depends on which latenesses are tried: no
// contact deeper than half a millimetre is passed over, whatever the amounts. A contact that is
// found is shown by starts that lead to it, and counts only if the whole plan, started so, has it.
#include "verify/bodies_in_motion.hpp"
#include "verify/checks.hpp"
#include "verify/contact_room.hpp"
#include "verify/unreadable.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <unordered_map>
#include <vector>

namespace handover::verify {
namespace {

constexpr double kMostTravel = 5e-3;  // [m] between two nodes of a table
constexpr double kReachSlack = 1e-2;  // [m] by which a lever may grow within one step
constexpr std::size_t kMostNodes = 200'000;
constexpr std::size_t kMostQueries = 20'000'000;
constexpr std::size_t kMostPoses = 4000;  // kept for a phase
constexpr double kExact = 0.1;            // [m] of motion from which boxes alone are asked

/// An actor that moves in a stage (or a part of it), or waits between two.
struct Phase {
  int stage = -1;               ///< -1: it waits
  int before = -1, after = -1;  ///< a wait's neighbours, -1: none
  double from = 0, to = 0;      ///< own time of the stage
  std::vector<double> q;        ///< of the robot, before the stage
  Allowances allowances;        ///< of the actor's own holders
  bool has_object = false;
  Mount object;  ///< how O is, as far as this actor has to do with it
  // Of a stage: how far each body can have moved since `from`, at nodes in time.
  std::vector<double> nodes;
  std::vector<std::vector<double>> travelled;  ///< [body of the actor][node]
  std::unordered_map<std::uint64_t, std::vector<Pose>> poses;
};

Eigen::AlignedBox3d worldBox(const Body& body, const Pose& X_WB) {
  const Eigen::Vector3d centre = X_WB * body.box().center();
  const Eigen::Vector3d half = X_WB.linear().cwiseAbs() * (body.box().sizes() / 2);
  return {centre - half, centre + half};
}

/// What one actor moves.
struct Crew {
  int robot = -1;
  std::vector<int> bodies;  ///< O is the last one
  std::vector<Mount> mounts;
  std::vector<std::vector<int>> joints;  ///< above each body, of this actor
  std::vector<Phase> phases;
};

struct Range {
  double from = 0, to = 0;

  double middle() const { return (from + to) / 2; }
};

/// Places of two bodies in the lists of their crews.
struct Pair {
  std::size_t a = 0, b = 0;
};

class LateCheck {
 public:
  LateCheck(const Motion& motion, const ContactRules& rules, ReportedPairs& reported,
            Report& report)
      : motion_(motion),
        scene_(motion.scene()),
        task_(motion.task()),
        rules_(rules),
        reported_(reported),
        report_(report),
        late_(scene_, task_, scene_.plan.slack) {
    for (std::size_t a = 0; a < task_.actors.size(); ++a) {
      crews_.push_back(makeCrew(static_cast<int>(a)));
    }
  }

  void run() {
    for (std::size_t a = 0; a < crews_.size(); ++a) {
      for (std::size_t b = a + 1; b < crews_.size(); ++b) {
        for (Phase& one : crews_[a].phases) {
          for (Phase& other : crews_[b].phases) together(crews_[a], one, crews_[b], other);
        }
      }
    }
  }

 private:
  // ---- what an actor does -------------------------------------------------------------------

  Crew makeCrew(int actor) const {
    Crew crew;
    crew.robot = task_.actors[static_cast<std::size_t>(actor)].robot;
    for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
      if (static_cast<int>(b) == scene_.object_body) continue;
      const Mount mount = mountOf(scene_, static_cast<int>(b));
      if (actorOfLink(scene_, task_, mount.robot, mount.link) != actor) continue;
      crew.bodies.push_back(static_cast<int>(b));
      crew.mounts.push_back(mount);
      crew.joints.push_back(scene_.robot(mount.robot).jointsAbove(mount.link));
    }
    crew.bodies.push_back(scene_.object_body);
    crew.mounts.emplace_back();
    crew.joints.emplace_back();
    addPhases(actor, crew);
    return crew;
  }

  void addPhases(int actor, Crew& crew) const {
    const std::vector<int>& stages = task_.actors[static_cast<std::size_t>(actor)].stages;
    std::vector<double> q = scene_.q_start[static_cast<std::size_t>(crew.robot)];
    for (std::size_t i = 0; i <= stages.size(); ++i) {
      const int stage = i < stages.size() ? stages[i] : -1;
      const int before = i > 0 ? stages[i - 1] : -1;
      if (stage < 0 || !task_.joined[static_cast<std::size_t>(stage)]) {
        Phase wait;
        wait.before = before;
        wait.after = stage;
        wait.q = q;
        describe(actor, static_cast<int>(2 * i), false, wait);
        crew.phases.push_back(std::move(wait));
      }
      if (stage < 0) break;
      const double duration = scene_.stage(stage).duration();
      double leaves = duration;
      if (scene_.stage(stage).action == "retreat") {
        leaves = task_.hand_leaves[static_cast<std::size_t>(scene_.stage(stage).holder)];
      }
      for (const Range& part : {Range{0, leaves}, Range{leaves, duration}}) {
        if (part.to - part.from <= kTimeTolerance) continue;
        Phase moving;
        moving.stage = stage;
        moving.from = part.from;
        moving.to = part.to;
        moving.q = q;
        describe(actor, static_cast<int>(2 * i + 1), part.from > 0, moving);
        table(crew, moving);
        crew.phases.push_back(std::move(moving));
      }
      motion_.curves().setJoints(stage, duration, q);
    }
  }

  /// Place of a stage among those of its actor.
  int placeOf(int actor, int stage) const {
    const std::vector<int>& stages = task_.actors[static_cast<std::size_t>(actor)].stages;
    return static_cast<int>(std::find(stages.begin(), stages.end(), stage) - stages.begin());
  }

  /// What may touch and where O is at a place: 2 i before stage i of the actor, 2 i + 1 in it.
  void describe(int actor, int place, bool hand_has_left, Phase& phase) const {
    phase.allowances.hand.assign(task_.of.size(), false);
    for (int k = 0; k <= task_.last(); ++k) {
      if (task_.actor_of_holder[static_cast<std::size_t>(k)] != actor) continue;
      const HolderStages& stages = task_.of[static_cast<std::size_t>(k)];
      const auto in = [&](int stage) { return 2 * placeOf(actor, stage) + 1; };
      const bool begun = stages.grasp < 0 || place >= in(stages.grasp);
      const bool left = stages.retreat >= 0 && (place > in(stages.retreat) ||
                                                (place == in(stages.retreat) && hand_has_left));
      phase.allowances.hand[static_cast<std::size_t>(k)] = begun && !left;
      const bool taken = stages.grasp < 0 || place > in(stages.grasp);
      const bool given = stages.release >= 0 && place > in(stages.release);
      if (taken && !given) {
        phase.has_object = true;
        phase.object = mountInHand(scene_, k);
      } else if (k == 0 && !taken) {
        phase.has_object = true;
        phase.object = {-1, -1, scene_.plan.start.X_WO};
      } else if (k == task_.last() && given) {
        phase.has_object = true;
        phase.object = {-1, -1, motion_.objectBy(k, motion_.holdEnds(k))};
      }
      if (k == 0) {
        phase.allowances.start_rest = stages.lift >= 0 && place <= in(stages.lift);
      }
      if (k == task_.last()) {
        phase.allowances.goal_rest = stages.place >= 0 && place >= in(stages.place);
      }
    }
  }

  std::vector<int> jointsOf(const Crew& crew, const Phase& phase, std::size_t body) const {
    if (body + 1 < crew.bodies.size()) return crew.joints[body];
    if (!phase.has_object || phase.object.robot < 0) return {};
    return scene_.robot(phase.object.robot).jointsAbove(phase.object.link);
  }

  void placeBodies(const Crew& crew, const Phase& phase, const std::vector<Pose>& X_WL,
                   std::vector<Pose>& poses) const {
    poses.resize(crew.bodies.size());
    for (std::size_t i = 0; i < crew.bodies.size(); ++i) {
      const Mount& mount = i + 1 < crew.bodies.size() ? crew.mounts[i] : phase.object;
      poses[i] =
          mount.robot < 0 ? mount.X_LB : X_WL[static_cast<std::size_t>(mount.link)] * mount.X_LB;
    }
  }

  void linksAt(const Crew& crew, const Phase& phase, double t, std::vector<Pose>& X_WL) const {
    std::vector<double> q = phase.q;
    if (phase.stage >= 0) motion_.curves().setJoints(phase.stage, t, q);
    scene_.robot(crew.robot).followMimics(q);
    scene_.kinematics[static_cast<std::size_t>(crew.robot)].linkPoses(q, X_WL);
  }

  /// Moments between which every joint of a moving phase follows one piece of its curve.
  std::vector<double> cutsOf(const Phase& phase) const {
    std::vector<double> cuts = {phase.from};
    for (const double cut : motion_.curves().cuts(phase.stage)) {
      if (cut > phase.from && cut < phase.to) cuts.push_back(cut);
    }
    cuts.push_back(phase.to);
    return cuts;
  }

  /// Of every joint of the robot: the most that it turns or slides per second between two cuts.
  std::vector<double> speedsBetween(const Robot& robot, int stage, double from, double to) const {
    std::vector<double> speeds(robot.joints.size(), 0.0);
    motion_.curves().raiseSpeeds(stage, from, to, speeds);
    for (std::size_t j = 0; j < robot.joints.size(); ++j) {
      if (robot.joints[j].mimic < 0) continue;
      const Law law = robot.lawOf(j);
      speeds[j] = std::abs(law.multiplier) * speeds[law.master];
    }
    return speeds;
  }

  /// Bounds how fast the crew's bodies move about a time [m/s]: for the next kMostTravel of the
  /// fastest of them, by which no lever grows more than kReachSlack.
  std::vector<double> ratesAt(const Crew& crew, const Phase& phase, double t,
                              const std::vector<std::vector<int>>& joints,
                              const std::vector<double>& speeds) const {
    const Robot& robot = scene_.robot(crew.robot);
    std::vector<Pose> X_WL, poses;
    linksAt(crew, phase, t, X_WL);
    placeBodies(crew, phase, X_WL, poses);
    std::vector<double> rates(crew.bodies.size(), 0.0);
    for (std::size_t i = 0; i < crew.bodies.size(); ++i) {
      const Body& shape = scene_.body(crew.bodies[i]).body;
      for (const int joint : joints[i]) {
        const auto j = static_cast<std::size_t>(joint);
        if (speeds[j] <= 0) continue;
        double lever = 1;
        if (robot.joints[j].type != JointType::kPrismatic) {
          const Pose& X_WC = X_WL[static_cast<std::size_t>(robot.joints[j].child)];
          lever = (X_WC.linear() * robot.joints[j].axis)
                      .cross(poses[i] * shape.centre() - X_WC.translation())
                      .norm() +
                  shape.radius() + kReachSlack;
        }
        rates[i] += speeds[j] * lever;
      }
    }
    return rates;
  }

  /// Fills nodes and travelled, by the same bound as the plan's own contacts are found with.
  void table(const Crew& crew, Phase& phase) const {
    phase.travelled.assign(crew.bodies.size(), {0.0});
    phase.nodes = {phase.from};
    std::vector<std::vector<int>> joints;
    for (std::size_t i = 0; i < crew.bodies.size(); ++i) {
      joints.push_back(jointsOf(crew, phase, i));
    }
    const std::vector<double> cuts = cutsOf(phase);
    for (std::size_t c = 0; c + 1 < cuts.size(); ++c) {
      const std::vector<double> speeds =
          speedsBetween(scene_.robot(crew.robot), phase.stage, cuts[c], cuts[c + 1]);
      for (double t = cuts[c]; t < cuts[c + 1];) {
        const std::vector<double> rates = ratesAt(crew, phase, t, joints, speeds);
        const double fastest = *std::max_element(rates.begin(), rates.end());
        const double next =
            fastest > 0 ? std::min(cuts[c + 1], t + kMostTravel / fastest) : cuts[c + 1];
        if (phase.nodes.size() > kMostNodes || next <= t) {
          throw Unreadable("/plan/stages", "too much motion to be checked");
        }
        for (std::size_t i = 0; i < rates.size(); ++i) {
          phase.travelled[i].push_back(phase.travelled[i].back() + rates[i] * (next - t));
        }
        phase.nodes.push_back(next);
        t = next;
      }
    }
  }

  // ---- what two actors do together ----------------------------------------------------------

  /// How far the body can move between two own times of the phase.
  static double travel(const Phase& phase, std::size_t body, double from, double to) {
    if (phase.stage < 0) return 0;
    const auto at = [&](double t) {
      const auto after = std::upper_bound(phase.nodes.begin(), phase.nodes.end(), t);
      const auto n = static_cast<std::size_t>(after - phase.nodes.begin());
      const std::vector<double>& sums = phase.travelled[body];
      if (n >= phase.nodes.size()) return sums.back();
      if (n == 0) return 0.0;
      const double share = (t - phase.nodes[n - 1]) / (phase.nodes[n] - phase.nodes[n - 1]);
      return sums[n - 1] + share * (sums[n] - sums[n - 1]);
    };
    return at(to) - at(from);
  }

  const std::vector<Pose>& posesAt(const Crew& crew, Phase& phase, double t) {
    const auto [found, is_new] = phase.poses.try_emplace(std::bit_cast<std::uint64_t>(t));
    if (is_new) {
      linksAt(crew, phase, t, X_WL_);
      placeBodies(crew, phase, X_WL_, found->second);
      ++report_.late.states;
    }
    return found->second;
  }

  /// Own times of the moving phase at which the other may be waiting.
  Range whileWaiting(const Phase& moving, const Phase& wait) const {
    Range range{moving.from, moving.to};
    if (wait.before >= 0) {
      range.from = std::max(range.from, scene_.stage(wait.before).duration() -
                                            late_.greatest(wait.before, moving.stage));
    }
    if (wait.after >= 0) range.to = std::min(range.to, late_.greatest(moving.stage, wait.after));
    return range;
  }

  void together(Crew& crew_a, Phase& a, Crew& crew_b, Phase& b) {
    if (a.stage < 0 && b.stage < 0) return;  // as before the one of them moved
    a_ = &a;
    b_ = &b;
    crew_a_ = &crew_a;
    crew_b_ = &crew_b;
    Range own_a{a.from, a.to}, own_b{b.from, b.to};
    if (b.stage < 0) own_a = whileWaiting(a, b);
    if (a.stage < 0) own_b = whileWaiting(b, a);
    if (own_a.from > own_a.to || own_b.from > own_b.to) return;
    if (a.stage >= 0 && b.stage >= 0) {
      apart_ = {late_.least(a.stage, b.stage), late_.greatest(a.stage, b.stage)};
    } else {
      apart_ = {-1e300, 1e300};
    }
    if (!possible(own_a, own_b)) return;
    std::vector<Pair> pairs;
    for (std::size_t i = 0; i < crew_a.bodies.size(); ++i) {
      for (std::size_t j = 0; j < crew_b.bodies.size(); ++j) {
        if (counts(i, j)) pairs.push_back({i, j});
      }
    }
    report_.late.pairs += pairs.size();
    cover(own_a, own_b, pairs);
  }

  bool counts(std::size_t i, std::size_t j) const {
    const bool object_a = i + 1 == crew_a_->bodies.size();
    const bool object_b = j + 1 == crew_b_->bodies.size();
    if (object_a && object_b) return false;
    if ((object_a && !a_->has_object) || (object_b && !b_->has_object)) return false;
    const int one = crew_a_->bodies[i], other = crew_b_->bodies[j];
    if (rules_.standing(one, other) || reported_.count(std::minmax(one, other))) return false;
    Allowances allowances = a_->allowances;
    for (std::size_t k = 0; k < allowances.hand.size(); ++k) {
      if (b_->allowances.hand[k]) allowances.hand[k] = true;
    }
    // Only the arm that has O says what it rests on.
    allowances.start_rest = object_a ? a_->allowances.start_rest : b_->allowances.start_rest;
    allowances.goal_rest = object_a ? a_->allowances.goal_rest : b_->allowances.goal_rest;
    return !rules_.depthAllowed(allowances, one, other);
  }

  /// Whether starts exist that bring the two together somewhere in the rectangle.
  bool possible(const Range& own_a, const Range& own_b) const {
    return own_a.to - own_b.from >= apart_.from - kTimeTolerance &&
           own_a.from - own_b.to <= apart_.to + kTimeTolerance;
  }

  void cover(const Range& own_a, const Range& own_b, const std::vector<Pair>& pairs) {
    if (pairs.empty() || !possible(own_a, own_b)) return;
    // A point of the rectangle that starts can lead to, in the middle if that is one.
    double at_a = own_a.middle(), at_b = own_b.middle();
    const double apart = std::clamp(at_a - at_b, apart_.from, apart_.to);
    at_a = std::clamp(at_a + (apart - (at_a - at_b)) / 2, own_a.from, own_a.to);
    at_b = std::clamp(at_a - apart, own_b.from, own_b.to);
    at_a = std::clamp(at_b + apart, own_a.from, own_a.to);
    for (Phase* phase : {a_, b_}) {
      if (phase->poses.size() > kMostPoses) phase->poses.clear();
    }
    const std::vector<Pose>& poses_a = posesAt(*crew_a_, *a_, at_a);
    const std::vector<Pose>& poses_b = posesAt(*crew_b_, *b_, at_b);

    std::vector<Pair> left;
    double most_a = 0, most_b = 0;
    for (const Pair& pair : pairs) {
      const double travel_a =
          std::max(travel(*a_, pair.a, own_a.from, at_a), travel(*a_, pair.a, at_a, own_a.to));
      const double travel_b =
          std::max(travel(*b_, pair.b, own_b.from, at_b), travel(*b_, pair.b, at_b, own_b.to));
      const double needed = travel_a + travel_b;
      const Body& one = scene_.body(crew_a_->bodies[pair.a]).body;
      const Body& other = scene_.body(crew_b_->bodies[pair.b]).body;
      const double centres =
          (poses_a[pair.a] * one.centre() - poses_b[pair.b] * other.centre()).norm();
      if (centres - one.radius() - other.radius() > needed) continue;
      const double boxes =
          worldBox(one, poses_a[pair.a]).exteriorDistance(worldBox(other, poses_b[pair.b]));
      if (boxes > needed) continue;
      if (needed < kExact && !stays(pair, needed, at_a, at_b)) continue;
      most_a = std::max(most_a, travel_a);
      most_b = std::max(most_b, travel_b);
      left.push_back(pair);
    }
    if (left.empty()) return;
    if (most_a >= most_b) {
      cover({own_a.from, own_a.middle()}, own_b, left);
      cover({own_a.middle(), own_a.to}, own_b, remaining(left));
    } else {
      cover(own_a, {own_b.from, own_b.middle()}, left);
      cover(own_a, {own_b.middle(), own_b.to}, remaining(left));
    }
  }

  /// Whether the pair must be looked at in parts of a rectangle within which its bodies move by
  /// `needed` from where they are at the point.
  bool stays(const Pair& pair, double needed, double at_a, double at_b) {
    if (++report_.late.queries > kMostQueries) {
      throw Unreadable("/plan/stages", "too much motion to be checked");
    }
    const double room =
        contactRoom(scene_.body(crew_a_->bodies[pair.a]).body, posesAt(*crew_a_, *a_, at_a)[pair.a],
                    scene_.body(crew_b_->bodies[pair.b]).body, posesAt(*crew_b_, *b_, at_b)[pair.b],
                    std::nullopt, needed + kFinest);
    if (room > needed) return false;
    if (room < 0 && shown(pair, at_a, at_b)) return false;
    return needed > kFinest;
  }

  /// Those that have not been reported meanwhile.
  std::vector<Pair> remaining(const std::vector<Pair>& pairs) const {
    std::vector<Pair> left;
    for (const Pair& pair : pairs) {
      if (!reported_.count(std::minmax(crew_a_->bodies[pair.a], crew_b_->bodies[pair.b]))) {
        left.push_back(pair);
      }
    }
    return left;
  }

  /// Reports the contact if starts lead to it and the whole plan, started so, has it.
  bool shown(const Pair& pair, double at_a, double at_b) {
    const int one = crew_a_->bodies[pair.a], other = crew_b_->bodies[pair.b];
    if (reported_.count(std::minmax(one, other))) return true;
    std::vector<Precedence> further;
    const auto meanwhile = [&](const Phase& moving, double t, const Phase& wait) {
      if (wait.before >= 0) {
        further.push_back({wait.before, moving.stage, scene_.stage(wait.before).duration() - t});
      }
      if (wait.after >= 0) further.push_back({moving.stage, wait.after, t});
    };
    if (a_->stage >= 0 && b_->stage >= 0) {
      further.push_back({a_->stage, b_->stage, at_a - at_b});
      further.push_back({b_->stage, a_->stage, at_b - at_a});
    } else if (a_->stage >= 0) {
      meanwhile(*a_, at_a, *b_);
    } else {
      meanwhile(*b_, at_b, *a_);
    }
    const auto starts = late_.starts(further);
    if (!starts) return false;
    const int stage = a_->stage >= 0 ? a_->stage : b_->stage;
    const double T = (*starts)[static_cast<std::size_t>(stage)] + (a_->stage >= 0 ? at_a : at_b);
    const Motion late(motion_.curves(), task_, *starts);
    const double room =
        contactRoom(scene_.body(one).body, late.bodyAt(one, T), scene_.body(other).body,
                    late.bodyAt(other, T), rules_.depthAllowed(allowancesAt(late, T), one, other));
    if (room >= 0) return false;
    reported_.insert(std::minmax(one, other));
    const std::string& name = scene_.body(one).name;
    const std::string& other_name = scene_.body(other).name;
    report_.add({stage,
                 T,
                 "order",
                 name + " touches " + other_name + " when " + whoIsLate(*starts),
                 {name, other_name}});
    return true;
  }

  /// Runs that are later than the plan and what they wait for make them.
  std::string whoIsLate(const std::vector<double>& starts) const {
    std::string who;
    for (const std::vector<int>& run : task_.runs) {
      const int first = run.front();
      const double start = starts[static_cast<std::size_t>(first)];
      double due = scene_.stage(first).start;
      for (const After& after : scene_.stage(first).after) {
        due = std::max(due, starts[static_cast<std::size_t>(after.stage)] + after.progress);
      }
      if (start - due < 1e-6) continue;
      char by[32];
      std::snprintf(by, sizeof by, " is %.3f s late", start - scene_.stage(first).start);
      who += (who.empty() ? "" : ", ") + scene_.stageName(first) + by;
    }
    return who.empty() ? "nothing is late" : who;
  }

  const Motion& motion_;
  const Scene& scene_;
  const Task& task_;
  const ContactRules& rules_;
  ReportedPairs& reported_;
  Report& report_;
  LateStarts late_;
  std::vector<Crew> crews_;
  std::vector<Pose> X_WL_;
  // Of the two that are looked at:
  Crew* crew_a_ = nullptr;
  Crew* crew_b_ = nullptr;
  Phase* a_ = nullptr;
  Phase* b_ = nullptr;
  Range apart_;  ///< own time of a less that of b, as starts allow it
};

}  // namespace

void checkContactsLate(const Motion& motion, const ContactRules& rules, ReportedPairs& reported,
                       Report& report) {
  if (motion.scene().plan.slack <= 0) return;
  LateCheck(motion, rules, reported, report).run();
}

}  // namespace handover::verify
