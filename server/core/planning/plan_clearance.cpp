// SPDX-License-Identifier: Apache-2.0
#include "core/planning/plan_clearance.hpp"

#include "core/collision/clearance_meter.hpp"
#include "core/collision/moving_balls.hpp"
#include "core/planning/timed_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <optional>

namespace handover {
namespace {

constexpr double kSameTime = 1e-9;  // design §5: times nearer than this are equal [s]
constexpr double kStill = 1e-12;    // of a joint that a stage names and does not move [rad or m]
constexpr double kLook = 0.3;       // parts that a stretch is first divided into [s]
/// Bodies that travel farther than this [m] are seldom proven to be apart: divided at once.
constexpr double kFarTravel = 0.12;
/// Nothing moves farther than a fraction of the fineness in so short a time [s]: where curved
/// shapes are not measured to the last digit, halving ends all the same.
constexpr double kShortest = 1e-6;

enum Kind : std::size_t { kFurniture, kRobots, kObject, kKinds };

constexpr std::array<const char*, kKinds> kNames{"furniture", "robots", "object"};

/// Motions of several movers at once, each with joints of its own; they outlive this.
class AllMotions : public JointMotion {
 public:
  explicit AllMotions(const std::deque<TimedMotion>& motions) : motions_(motions) {}

  Eigen::Index joints() const override {
    Eigen::Index size = 0;
    for (const TimedMotion& it : motions_) size += it.joints();
    return size;
  }

  void fill(double from, double to, MotionIntervalRef out) const override {
    Eigen::Index first = 0;
    for (const TimedMotion& it : motions_) {
      const Eigen::Index size = it.joints();
      it.fill(from, to,
              {out.q_middle.segment(first, size), out.along.segment(first, size),
               out.rest.segment(first, size)});
      first += size;
    }
  }

 private:
  const std::deque<TimedMotion>& motions_;
};

bool isCounted(StageAction action) {
  return action == StageAction::kReach || action == StageAction::kCarry ||
         action == StageAction::kHome;
}

/// What a body belongs to, whatever moves.
struct Belonging {
  RobotId robot;    ///< it is one's link, or attached to one; none: furniture, or the object
  LinkId link;      ///< that carries it
  ArmId arm;        ///< the first that has a joint above it
  HolderSet hands;  ///< holders whose hand it is part of
};

/// Of a robot's link: how the stages that run move it.
struct Moved {
  JointId by;        ///< the last joint above it that moves; none: it stands still
  int counted = -1;  ///< a reach, carry or home that moves it
};

class ClearanceSearch {
 public:
  ClearanceSearch(const TransportProblem& problem, const TransportPath& path,
                  const std::vector<TimedStage>& timed, const std::vector<ScheduledStage>& schedule)
      : scene_(*problem.scene),
        bodies_(*problem.collision),
        meter_(bodies_),
        object_(scene_.findObject(problem.task.object)),
        object_body_(bodies_.objectBody(object_)),
        path_(path),
        timed_(timed),
        schedule_(schedule) {
    for (const SceneRobot& robot : scene_.robots) q_.push_back(robot.q_start);
    X_WL_.resize(scene_.robots.size());
    index_.assign(static_cast<std::size_t>(bodies_.bodies()), -1);
    holds_from_.assign(path.holders.size(), kNever);
    holds_to_ = holds_from_;
    if (problem.task.held_by) holds_from_.front() = 0;
    for (std::size_t i = 0; i < timed.size(); ++i) noteStage(i);
    std::sort(cuts_.begin(), cuts_.end());
    std::stable_sort(by_end_.begin(), by_end_.end(),
                     [&](std::size_t a, std::size_t b) { return endOf(a) < endOf(b); });
    findBelongings();
    for (std::size_t k = 0; k < kKinds; ++k) {
      found_[k].between = kNames[k];
      best_[k] = kMostClearance + kClearanceFineness;
    }
  }

  std::vector<ClearanceQuality> search() {
    placeObjects();
    for (std::size_t i = 0; i + 1 < cuts_.size(); ++i) {
      if (cuts_[i + 1] - cuts_[i] > kSameTime) searchStretch(cuts_[i], cuts_[i + 1]);
    }
    for (std::size_t k = 0; k < kKinds; ++k) {
      found_[k].least_m = std::clamp(best_[k] - kClearanceFineness, 0.0, kMostClearance);
    }
    return {found_.begin(), found_.end()};
  }

 private:
  static constexpr double kNever = std::numeric_limits<double>::infinity();

  /// Two bodies that may come near each other.
  struct Pair {
    BodyId a, b;
    Kind kind;
    std::uint32_t stage;  ///< that makes their distance count
  };

  /// Part of a stretch, and what may come near in it.
  struct Interval {
    double from, to;
    std::size_t first, last;  ///< in pairs_
    bool has_pairs;
  };

  double startOf(std::size_t stage) const { return schedule_[stage].start; }

  double endOf(std::size_t stage) const { return startOf(stage) + timed_[stage].path.duration(); }

  void noteStage(std::size_t i) {
    const TaskStage& stage = timed_[i].stage->stage;
    cuts_.push_back(startOf(i));
    cuts_.push_back(endOf(i));
    by_end_.push_back(i);
    if (stage.action == StageAction::kGrasp) holds_from_[stage.holder] = endOf(i);
    if (stage.action == StageAction::kRelease) holds_to_[stage.holder] = endOf(i);
    std::vector<bool>& moves = moves_.emplace_back(timed_[i].dofs.size());
    const TimedPath& curve = timed_[i].path;
    for (std::size_t j = 0; j < moves.size(); ++j) {
      const auto at = static_cast<Eigen::Index>(j);
      for (std::size_t s = 0; s < curve.t.size() && !moves[j]; ++s) {
        moves[j] = std::abs(curve.q[s][at] - curve.q[0][at]) > kStill ||
                   std::abs(curve.qd[s][at]) > kStill || std::abs(curve.qdd[s][at]) > kStill;
      }
    }
  }

  // ---- what bodies are --------------------------------------------------------------------------

  void findBelongings() {
    belongings_.resize(static_cast<std::size_t>(bodies_.bodies()));
    for (const RobotId r : IdRange<RobotId>(scene_.robots.size())) {
      const RobotModel& model = *scene_.robots[r].model;
      for (const LinkId link : IdRange<LinkId>(model.links.size())) {
        const BodyId body = bodies_.linkBody(r, link);
        if (body.valid()) belongings_[body] = {r, link, armAbove(model, link), {}};
      }
    }
    for (const ObjectId o : IdRange<ObjectId>(scene_.objects.size())) {
      const std::optional<Attachment>& attached = scene_.objects[o].attached_to;
      if (!attached || o == object_) continue;
      const RobotModel& model = *scene_.robots[attached->robot].model;
      belongings_[bodies_.objectBody(o)] = {
          attached->robot, attached->link, armAbove(model, attached->link), {}};
    }
    for (std::size_t k = 0; k < path_.holders.size(); ++k) {
      for (const BodyId body : path_.holders[k].manipulator->hand_bodies) {
        belongings_[body].hands.insert(k);
      }
    }
  }

  static ArmId armAbove(const RobotModel& model, LinkId link) {
    for (const ArmId arm : IdRange<ArmId>(model.arms.size())) {
      const std::vector<JointId>& joints = model.arms[arm].joints;
      for (LinkId it = link; model.links[it].parent_joint.valid();) {
        const JointId joint = model.links[it].parent_joint;
        if (std::find(joints.begin(), joints.end(), joint) != joints.end()) return arm;
        it = model.joints[joint].parent_link;
      }
    }
    return {};
  }

  /// nullopt: their distance is no part of the plan's quality.
  std::optional<Kind> kindOf(BodyId a, BodyId b) const {
    if (a == object_body_ || b == object_body_) {
      const Belonging& other = belongings_[a == object_body_ ? b : a];
      if (carrier_ == nullptr || !other.hands.empty()) return std::nullopt;
      return kObject;
    }
    const Belonging &of_a = belongings_[a], &of_b = belongings_[b];
    if (!of_a.robot.valid() || !of_b.robot.valid()) return kFurniture;
    if (of_a.robot == of_b.robot &&
        (!of_a.arm.valid() || !of_b.arm.valid() || of_a.arm == of_b.arm)) {
      return std::nullopt;
    }
    return successiveHands(of_a.hands, of_b.hands) ? std::nullopt : std::optional(kRobots);
  }

  static bool successiveHands(HolderSet a, HolderSet b) {
    bool successive = false;
    a.forEach([&](std::size_t k) {
      successive = successive || b.contains(k + 1) || (k > 0 && b.contains(k - 1));
    });
    return successive;
  }

  // ---- a stretch of time in which the same stages run -------------------------------------------

  void searchStretch(double from, double to) {
    const double middle = 0.5 * (from + to);
    running_.clear();
    bool counts = false;
    for (std::size_t i = 0; i < timed_.size(); ++i) {
      if (!(startOf(i) < middle && middle < endOf(i))) continue;
      running_.push_back(i);
      counts = counts || isCounted(timed_[i].stage->stage.action);
    }
    finishStages(from);
    if (!counts) return;
    // All of a robot's joints together.
    std::stable_sort(running_.begin(), running_.end(), [&](std::size_t a, std::size_t b) {
      return timed_[a].stage->mover->robot < timed_[b].stage->mover->robot;
    });
    place(middle);
    mount(from, to);
    divide(to - from);
  }

  /// Leaves joints where the stages that ended by then have left them.
  void finishStages(double time) {
    for (; ended_ < by_end_.size() && endOf(by_end_[ended_]) <= time + kSameTime; ++ended_) {
      const TimedStage& stage = timed_[by_end_[ended_]];
      setJoints(stage, stage.path.q.back());
    }
  }

  void setJoints(const TimedStage& stage, const Eigen::VectorXd& q) {
    RobotVector& all = q_[stage.stage->mover->robot];
    for (std::size_t j = 0; j < stage.dofs.size(); ++j) {
      all[stage.dofs[j].value()] = q[static_cast<Eigen::Index>(j)];
    }
  }

  void placeObjects() {
    for (const ObjectId o : IdRange<ObjectId>(scene_.objects.size())) {
      meter_.setPose(bodies_.objectBody(o), scene_.objects[o].X_WO);
    }
  }

  /// Everything as it is at a time; finds who has the object.
  void place(double time) {
    for (const std::size_t i : running_) {
      setJoints(timed_[i], evaluate(timed_[i].path, time - startOf(i)));
    }
    for (const RobotId r : IdRange<RobotId>(scene_.robots.size())) {
      const SceneRobot& robot = scene_.robots[r];
      linkPoses(*robot.model, robot.X_WB, q_[r], X_WL_[r]);
      for (const LinkId link : IdRange<LinkId>(robot.model->links.size())) {
        const BodyId body = bodies_.linkBody(r, link);
        if (body.valid()) meter_.setPose(body, X_WL_[r][link]);
      }
    }
    for (const ObjectId o : IdRange<ObjectId>(scene_.objects.size())) {
      const std::optional<Attachment>& attached = scene_.objects[o].attached_to;
      if (!attached || o == object_) continue;
      meter_.setPose(bodies_.objectBody(o),
                     X_WL_[attached->robot][attached->link] * attached->X_LO);
    }
    carrier_ = nullptr;
    for (std::size_t k = 0; k < path_.holders.size(); ++k) {
      if (holds_from_[k] < time && time < holds_to_[k]) carrier_ = &path_.holders[k];
    }
    // In nobody's hand its distances do not count.
    if (carrier_ == nullptr) return;
    const Manipulator& arm = *carrier_->manipulator;
    meter_.setPose(object_body_, X_WL_[arm.robot][arm.arm_model->tool_link] * X_TO());
  }

  /// Of the object in the carrier's tool.
  Pose X_TO() const { return carrier_->manipulator->grasp(carrier_->grasp).X_OT.inverse(); }

  /// What moves in the stretch, and how.
  void mount(double from, double to) {
    motions_.clear();
    moving_.clear();
    std::fill(index_.begin(), index_.end(), -1);
    moved_.assign(scene_.robots.size(), {});
    groups_.reset();
    for (std::size_t i = 0; i < running_.size();) {
      const RobotId robot = timed_[running_[i]].stage->mover->robot;
      std::size_t end = i;
      std::vector<DofId> dofs;
      for (; end < running_.size() && timed_[running_[end]].stage->mover->robot == robot; ++end) {
        const TimedStage& stage = timed_[running_[end]];
        if (stage.dofs.empty()) continue;
        const double start = startOf(running_[end]);
        motions_.emplace_back(stage.path, from - start, to - start);
        dofs.insert(dofs.end(), stage.dofs.begin(), stage.dofs.end());
      }
      findMoved(robot, i, end);
      addRobot(robot, dofs);
      i = end;
    }
    for (std::size_t i = 0; i < moving_.size(); ++i) index_[moving_[i].body] = static_cast<int>(i);
    if (groups_) setBalls(bodies_, moving_, *groups_);
  }

  /// Which links of a robot the stages running_[first] to [end] move.
  void findMoved(RobotId robot, std::size_t first, std::size_t end) {
    const RobotModel& model = *scene_.robots[robot].model;
    std::vector<int> stage_of(static_cast<std::size_t>(model.dofs()), -1);
    for (std::size_t i = first; i < end; ++i) {
      const TimedStage& stage = timed_[running_[i]];
      for (std::size_t j = 0; j < stage.dofs.size(); ++j) {
        if (moves_[running_[i]][j]) stage_of[stage.dofs[j]] = static_cast<int>(running_[i]);
      }
    }
    std::vector<Moved>& moved = moved_[robot];
    moved.resize(model.links.size());
    for (const LinkId link : IdRange<LinkId>(model.links.size())) {
      const JointId parent = model.links[link].parent_joint;
      if (!parent.valid()) continue;
      const Joint& joint = model.joints[parent];
      moved[link] = moved[joint.parent_link];
      const int stage = joint.dof.valid() ? stage_of[joint.dof] : -1;
      if (stage < 0) continue;
      moved[link].by = parent;
      if (isCounted(timed_[static_cast<std::size_t>(stage)].stage->stage.action)) {
        moved[link].counted = std::max(moved[link].counted, stage);
      }
    }
  }

  void addRobot(RobotId r, const std::vector<DofId>& dofs) {
    if (dofs.empty()) return;
    const RobotModel& model = *scene_.robots[r].model;
    RigidGroups groups(model, dofs);
    groups.setPosture(model, X_WL_[r]);
    const int before = groups_ ? groups_->size() : 0;
    const auto add = [&](BodyId body, LinkId link, const Pose& X_LB) {
      const int group = groups.groupOf(link);
      if (!body.valid() || group < 0) return;
      const Pose X_GL = X_WL_[r][groups.linkOf(group)].inverse() * X_WL_[r][link];
      moving_.push_back({body, before + group, X_GL * X_LB});
    };
    if (carrier_ != nullptr && carrier_->manipulator->robot == r) {
      add(object_body_, carrier_->manipulator->arm_model->tool_link, X_TO());
    }
    for (const ObjectId o : IdRange<ObjectId>(scene_.objects.size())) {
      const std::optional<Attachment>& attached = scene_.objects[o].attached_to;
      if (!attached || attached->robot != r || o == object_) continue;
      add(bodies_.objectBody(o), attached->link, attached->X_LO);
    }
    for (const LinkId link : IdRange<LinkId>(model.links.size())) {
      add(bodies_.linkBody(r, link), link, Pose::Identity());
    }
    if (groups_) {
      groups_->append(groups);
    } else {
      groups_.emplace(std::move(groups));
    }
  }

  /// How the stages that run move a body, and of which robot.
  std::pair<RobotId, Moved> movedOf(BodyId body) const {
    RobotId robot = belongings_[body].robot;
    LinkId link = belongings_[body].link;
    if (body == object_body_) {
      if (carrier_ == nullptr) return {};
      robot = carrier_->manipulator->robot;
      link = carrier_->manipulator->arm_model->tool_link;
    }
    if (!robot.valid() || moved_[robot].empty()) return {};
    return {robot, moved_[robot][link]};
  }

  /// The stage that makes the pair's distance count; -1: none does.
  int countedStage(BodyId a, BodyId b) const {
    const auto [robot_a, moved_a] = movedOf(a);
    const auto [robot_b, moved_b] = movedOf(b);
    const bool as_one = robot_a == robot_b && moved_a.by == moved_b.by;
    return as_one ? -1 : std::max(moved_a.counted, moved_b.counted);
  }

  // ---- halving ----------------------------------------------------------------------------------

  /// What comes nearer than this is looked at more closely [m].
  double sought(Kind kind) const { return best_[kind] - kClearanceFineness; }

  void divide(double duration) {
    if (!groups_) return;
    duration_ = duration;
    const int parts = std::max(1, static_cast<int>(std::ceil(duration / kLook)));
    const AllMotions motion(motions_);
    intervals_.clear();
    pairs_.clear();
    for (int part = 0; part < parts; ++part) {
      intervals_.push_back({double(part) / parts, double(part + 1) / parts, 0, 0, false});
    }
    for (std::size_t i = 0; i < intervals_.size(); ++i) look(motion, intervals_[i]);
  }

  /// One look at the middle of an interval; what it leaves open goes to both its halves.
  void look(const AllMotions& motion, Interval it) {
    motion.stretch(it.from, it.to, stretch_);
    groups_->place(stretch_.q_middle);
    groups_->boundTravel(stretch_);
    if (!it.has_pairs && isFar()) return halve(it);
    if (!it.has_pairs) listPairs(it);
    const std::size_t open = pairs_.size();
    for (std::size_t i = it.first; i < it.last; ++i) {
      const Pair pair = pairs_[i];
      if (!keepsApart(pair)) pairs_.push_back(pair);
    }
    if (pairs_.size() == open) return;
    it.first = open;
    it.last = pairs_.size();
    halve(it);
  }

  bool isFar() const {
    for (int group = 0; group < groups_->size(); ++group) {
      if (groups_->travel(group) > kFarTravel) return true;
    }
    return false;
  }

  void halve(Interval it) {
    if ((it.to - it.from) * duration_ < kShortest) return;
    const double middle = 0.5 * (it.from + it.to);
    Interval second = it;
    it.to = second.from = middle;
    intervals_.push_back(it);
    intervals_.push_back(second);
  }

  void listPairs(Interval& it) {
    for (const MovingBody& body : moving_) placeBody(body);
    const double within = *std::max_element(best_.begin(), best_.end());
    meter_.findPairs(*groups_, moving_, index_, within, near_);
    it.has_pairs = true;
    it.first = pairs_.size();
    for (const auto& [a, b] : near_) {
      const std::optional<Kind> kind = kindOf(a, b);
      if (!kind || bodies_.standingPairs().contains(a, b)) continue;
      const int stage = countedStage(a, b);
      if (stage >= 0) pairs_.push_back({a, b, *kind, static_cast<std::uint32_t>(stage)});
    }
    it.last = pairs_.size();
  }

  void placeBody(const MovingBody& body) {
    meter_.setPose(body.body, groups_->pose(body.group) * body.X_GB);
  }

  /// Whether the pair is nowhere in the interval nearer than what is sought.
  bool keepsApart(const Pair& pair) {
    const int a = index_[pair.a], b = index_[pair.b];
    const auto groupOf = [&](int index) {
      return index < 0 ? -1 : moving_[static_cast<std::size_t>(index)].group;
    };
    for (const int index : {a, b}) {
      if (index >= 0) placeBody(moving_[static_cast<std::size_t>(index)]);
    }
    const PairMotion motion = groups_->approach(groupOf(a), groupOf(b));
    double at_most = 0;
    if (meter_.keepApart(pair.a, pair.b, motion, sought(pair.kind), at_most)) return true;
    if (at_most < best_[pair.kind]) {
      best_[pair.kind] = at_most;
      found_[pair.kind].stage = pair.stage;
      found_[pair.kind].pair = std::minmax(bodies_.name(pair.a), bodies_.name(pair.b));
    }
    return false;
  }

  const Scene& scene_;
  const CollisionScene& bodies_;
  ClearanceMeter meter_;
  const ObjectId object_;
  const BodyId object_body_;
  const TransportPath& path_;
  const std::vector<TimedStage>& timed_;
  const std::vector<ScheduledStage>& schedule_;
  std::vector<double> cuts_;                   ///< starts and ends of stages, rising
  std::vector<std::size_t> by_end_;            ///< stages
  std::vector<std::vector<bool>> moves_;       ///< by stage: which of its joints move
  std::vector<double> holds_from_, holds_to_;  ///< by holder
  std::vector<Belonging> belongings_;          ///< by body

  std::array<double, kKinds> best_{};
  std::array<ClearanceQuality, kKinds> found_;

  // Of the stretch.
  std::size_t ended_ = 0;  ///< of by_end_
  std::vector<RobotVector> q_;
  std::vector<std::vector<Pose>> X_WL_;  ///< by robot
  std::vector<std::size_t> running_;
  const HolderPath* carrier_ = nullptr;  ///< who has the object; nullptr: nobody
  std::deque<TimedMotion> motions_;
  std::optional<RigidGroups> groups_;
  std::vector<MovingBody> moving_;
  std::vector<int> index_;                 ///< by body: in moving_
  std::vector<std::vector<Moved>> moved_;  ///< by robot and link
  double duration_ = 0;                    ///< [s]
  std::vector<Interval> intervals_;
  std::vector<Pair> pairs_;
  std::vector<BodyPair> near_;
  MotionInterval stretch_;
};

}  // namespace

std::vector<ClearanceQuality> clearanceOf(const TransportProblem& problem,
                                          const TransportPath& path,
                                          const std::vector<TimedStage>& timed,
                                          const std::vector<ScheduledStage>& schedule) {
  return ClearanceSearch(problem, path, timed, schedule).search();
}

}  // namespace handover
