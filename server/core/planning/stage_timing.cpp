// SPDX-License-Identifier: Apache-2.0
#include "core/planning/stage_timing.hpp"

#include "core/motion/through_timing.hpp"
#include "core/planning/timed_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

namespace handover {
namespace {

constexpr std::array<double, 3> kBlends{0.05, 0.01, 0.001};  // corner deviations tried [rad]
// Of the straight ways to and from the object, kept to by curves that leave the polyline.
constexpr std::array<double, 4> kLineShares{0.2, 0.4, 0.7, 1};
constexpr std::array<double, 5> kPulls{1, 0.75, 0.5, 0.25, 0};  // of waypoints, tried

/// Of a way, by its length.
struct Part {
  double begin, end;
};

// Of a reach, in which the fingers open; they rest when it ends. The way is free with open fingers:
// where they would sweep over something, they wait until the hand is on its way, or open before.
constexpr std::array<Part, 3> kFingerParts{{{0, 0.7}, {0.4, 0.8}, {0, 0}}};
constexpr double kFingersAtRest = 1e-9;  // from their posture [rad]
// Of the contract's 1 mm, 0.5 deg, 1 deg and 5 mm (design §5, Straight).
constexpr double kOffLine = 0.0007;
constexpr double kTurned = 0.35 * M_PI / 180;
constexpr double kLeaning = 0.7 * M_PI / 180;
constexpr double kLeastRetreat = 0.006;
constexpr double kLook = 0.001;  // between looks for the clear distance [s]
constexpr double kLookExact = 1e-6;

TimingLimits limitsOf(const RobotModel& model, const std::vector<DofId>& dofs) {
  const auto size = static_cast<Eigen::Index>(dofs.size());
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(size);
  TimingLimits limits{zero, zero, zero, zero, zero};
  for (Eigen::Index i = 0; i < size; ++i) {
    const DofId dof = dofs[static_cast<std::size_t>(i)];
    const Joint& joint = model.joints[model.dof_joints[dof]];
    limits.lower[i] = joint.lower;
    limits.upper[i] = joint.upper;
    limits.velocity[i] = joint.velocity;
    limits.acceleration[i] = joint.acceleration;
    limits.jerk[i] = joint.jerk;
  }
  return limits;
}

using Polyline = std::vector<Eigen::VectorXd>;

double lengthOf(const Polyline& line) {
  double length = 0;
  for (std::size_t i = 1; i < line.size(); ++i) length += (line[i] - line[i - 1]).norm();
  return length;
}

/// The polyline with the fingers' joints below: they go straight while one part of the way is
/// covered.
Polyline withFingers(const Polyline& arm, const FingerMotion& fingers, const Part& part) {
  const double length = lengthOf(arm);
  const auto stacked = [&](const Eigen::VectorXd& q, double share) {
    Eigen::VectorXd both(q.size() + fingers.from.size());
    both << q, fingers.from + share * (fingers.to - fingers.from);
    return both;
  };
  const double begin = part.begin * length, end = part.end * length;
  const auto shareAt = [&](double way) {
    return end > begin ? std::clamp((way - begin) / (end - begin), 0.0, 1.0) : 1.0;
  };
  Polyline line{stacked(arm.front(), 0)};
  if (end == 0 && fingers.from != fingers.to) line.push_back(stacked(arm.front(), 1));
  double way = 0;
  for (std::size_t i = 1; i < arm.size(); ++i) {
    const double step = (arm[i] - arm[i - 1]).norm();
    for (const double turn : {begin, end}) {
      if (way < turn && way + step > turn) {
        line.push_back(
            stacked(arm[i - 1] + (turn - way) / step * (arm[i] - arm[i - 1]), shareAt(turn)));
      }
    }
    way += step;
    line.push_back(stacked(arm[i], i + 1 == arm.size() ? 1 : shareAt(way)));
  }
  return line;
}

/// A curve's first joints.
TimedPath head(const TimedPath& path, Eigen::Index size) {
  TimedPath first;
  first.t = path.t;
  for (std::size_t i = 0; i < path.t.size(); ++i) {
    first.q.emplace_back(path.q[i].head(size));
    first.qd.emplace_back(path.qd[i].head(size));
    first.qdd.emplace_back(path.qdd[i].head(size));
  }
  return first;
}

/// Several stages of one arm, timed together or each by itself.
class BlockTimer {
 public:
  BlockTimer(const TransportProblem& problem, CollisionContext& context,
             std::span<const StagePath> stages, const Deadline& deadline)
      : problem_(problem), context_(context), stages_(stages), deadline_(deadline) {
    for (const StagePath& stage : stages_) {
      has_fingers_ = has_fingers_ || stage.fingers.has_value();
    }
  }

  std::variant<std::vector<TimedStage>, MotionFailure> time() {
    if (stages_.front().dofs.empty()) return std::vector<TimedStage>{timeSuction()};
    if (auto timed = timeThrough()) return std::move(*timed);
    for (const Part& part : kFingerParts) {
      finger_part_ = part;
      if (auto timed = timeAll()) return std::move(*timed);
      if (!has_fingers_) break;
    }
    return failure_;
  }

 private:
  std::optional<std::vector<TimedStage>> timeAll() {
    if (stages_.size() > 1) {
      for (const double blend : {kBlends[0], kBlends[1]}) {
        if (auto joined = timeJoined(blend)) return joined;
      }
    }
    std::vector<TimedStage> timed;
    for (const StagePath& stage : stages_) {
      auto one = timeAlone(stage);
      if (!one) return std::nullopt;
      timed.push_back(std::move(*one));
    }
    return timed;
  }

  Polyline lineOf(const StagePath& stage) const {
    return stage.fingers ? withFingers(stage.waypoints, *stage.fingers, finger_part_)
                         : stage.waypoints;
  }

  TimingSettings settingsOf(double blend) const {
    TimingSettings settings;
    settings.blend = blend;
    settings.speed_scale = problem_.speed_scale;
    return settings;
  }

  /// A cup engages; nothing moves.
  TimedStage timeSuction() const {
    const double engage_s = stages_.front().mover->hand->suction->engage_s;
    TimedPath path;
    path.t = {0, std::max(engage_s, 0.01)};
    path.q = path.qd = path.qdd = {Eigen::VectorXd(0), Eigen::VectorXd(0)};
    return {&stages_.front(), {}, std::move(path), 0, false};
  }

  static std::vector<DofId> dofsOf(const StagePath& stage, bool with_fingers) {
    std::vector<DofId> dofs = stage.dofs;
    const std::vector<DofId>& fingers = stage.mover->hand->dofs;
    if (with_fingers) dofs.insert(dofs.end(), fingers.begin(), fingers.end());
    return dofs;
  }

  void fail(const StagePath& stage, Cause cause, NamePair pair = {}) {
    failure_ = {{static_cast<std::uint32_t>(stage.stage.holder), stage.stage.action},
                cause,
                std::move(pair)};
  }

  std::optional<TimedStage> timeAlone(const StagePath& stage) {
    const std::vector<DofId> dofs = dofsOf(stage, stage.fingers.has_value());
    const Polyline line = lineOf(stage);
    const TimingLimits limits = limitsOf(*stage.mover->model, dofs);
    for (const double blend : kBlends) {
      if (deadline_.over()) return std::nullopt;
      auto path = parameterize(line, limits, settingsOf(blend));
      if (!path) {
        fail(stage, Cause::kTiming, {path.error().detail, {}});
        return std::nullopt;
      }
      TimedStage timed{&stage, dofs, std::move(*path), 0, false};
      if (accept(timed)) return timed;
    }
    return std::nullopt;
  }

  std::optional<std::vector<TimedStage>> timeJoined(double blend) {
    std::vector<Polyline> lines;
    for (const StagePath& stage : stages_) {
      if (!has_fingers_ || stage.fingers) {
        lines.push_back(lineOf(stage));
      } else {
        const Eigen::VectorXd& rest = stages_.front().fingers->to;
        lines.push_back(withFingers(stage.waypoints, {rest, rest}, finger_part_));
      }
    }
    const std::vector<DofId> dofs = dofsOf(stages_.front(), has_fingers_);
    const auto joined =
        parameterizeJoined(lines, limitsOf(*stages_.front().mover->model, dofs), settingsOf(blend));
    return joined ? cutAll(*joined, dofs) : std::nullopt;
  }

  /// Curves that keep to the lines alone, or to the part of them next to the object: the quickest
  /// that is free.
  std::optional<std::vector<TimedStage>> timeThrough() {
    std::vector<MovementPart> parts;
    std::optional<JointsAside> aside;
    int free = 0;
    for (const StagePath& stage : stages_) {
      const StageType type = typeOf(stage.stage.action);
      if (type == StageType::kFree) ++free;
      if (stage.fingers && stage.fingers->from != stage.fingers->to) {
        aside = {parts.size(), stage.fingers->from, stage.fingers->to};
      }
      parts.push_back({stage.waypoints, type == StageType::kLinear});
    }
    const bool straight = parts.size() == 1 && parts.front().waypoints.size() < 3;
    if (free != 1 || straight) return std::nullopt;
    const std::vector<DofId> dofs = dofsOf(stages_.front(), aside.has_value());
    const TimingLimits limits = limitsOf(*stages_.front().mover->model, dofs);
    std::vector<ThroughMovement> movements;
    for (const double share : kLineShares) {
      const std::vector<MovementPart> shorter = shortened(parts, share);
      for (const double pull : kPulls) {
        if (deadline_.over()) return std::nullopt;
        ThroughMovement movement(pulled(shorter, pull), aside, limits, kBlends[0], 1);
        if (movement.found()) movements.push_back(std::move(movement));
        if (!hasWaypoints(shorter)) break;
      }
      if (parts.size() == 1) break;
    }
    std::stable_sort(movements.begin(), movements.end(),
                     [](const auto& a, const auto& b) { return a.duration() < b.duration(); });
    return cheapest(movements, dofs);
  }

  /// Of movements, the quickest first, the one that is worth most with what it keeps clear of.
  std::optional<std::vector<TimedStage>> cheapest(const std::vector<ThroughMovement>& movements,
                                                  const std::vector<DofId>& dofs) {
    std::optional<std::vector<TimedStage>> best;
    double least = std::numeric_limits<double>::infinity();
    for (const ThroughMovement& movement : movements) {
      if (movement.duration() >= least || deadline_.over()) break;
      auto timed = cutAll(movement.timing(settingsOf(kBlends[0])), dofs);
      if (!timed) continue;
      const double cost = movement.duration() + priceOf(*timed);
      if (cost >= least) continue;
      least = cost;
      best = std::move(timed);
    }
    return best;
  }

  /// [s] that what free stages pass closely is worth.
  double priceOf(const std::vector<TimedStage>& timed) {
    const CostWeights& weights = problem_.settings.cost;
    double price = 0;
    for (const TimedStage& stage : timed) {
      if (typeOf(stage.stage->stage.action) != StageType::kFree) continue;
      price =
          std::max(price, weights.clearance * (1 - std::min(1.0, skinOf(stage) / weights.wide)));
    }
    return price;
  }

  /// The widest skin that a stage keeps; none asked for: enough.
  double skinOf(const TimedStage& timed) {
    const StagePath& stage = *timed.stage;
    const Skins& skins = problem_.settings.free_motion.skins;
    if (skins.empty()) return problem_.settings.cost.wide;
    StateChecker checker =
        context_.make(stage.state, *stage.mover, timed.dofs, allowedContacts(stage.stage));
    const TimedMotion motion(timed.path);
    for (const double skin : skins) {
      if (checker.isMotionFree(motion, kTimedClearance, skinClearance(skin))) return skin;
    }
    return 0;
  }

  /// The lines cut to their share next to the object; the free part takes up where they now end.
  static std::vector<MovementPart> shortened(std::vector<MovementPart> parts, double share) {
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (!parts[i].line) continue;
      std::vector<Eigen::VectorXd>& line = parts[i].waypoints;
      const auto kept = std::max<std::size_t>(
          2, static_cast<std::size_t>(std::lround(share * static_cast<double>(line.size()))));
      if (kept >= line.size()) continue;
      if (i + 1 < parts.size() && !parts[i + 1].line) {
        line.resize(kept);
        parts[i + 1].waypoints.front() = line.back();
      } else {
        line.erase(line.begin(), line.end() - static_cast<std::ptrdiff_t>(kept));
        parts[i - 1].waypoints.back() = line.front();
      }
    }
    return parts;
  }

  static bool hasWaypoints(const std::vector<MovementPart>& parts) {
    return std::any_of(parts.begin(), parts.end(), [](const MovementPart& part) {
      return !part.line && part.waypoints.size() > 2;
    });
  }

  /// The waypoints of the free part nearer by a share to the straight way between its ends; at 1
  /// left out: often only the polyline needs them.
  static std::vector<MovementPart> pulled(std::vector<MovementPart> parts, double share) {
    for (MovementPart& part : parts) {
      if (part.line) continue;
      std::vector<Eigen::VectorXd>& points = part.waypoints;
      const Eigen::VectorXd from = points.front(), way = points.back() - from;
      if (share >= 1 || way.squaredNorm() == 0) {
        points = {from, points.back()};
        continue;
      }
      for (std::size_t i = 1; i + 1 < points.size(); ++i) {
        const double along = std::clamp((points[i] - from).dot(way) / way.squaredNorm(), 0.0, 1.0);
        points[i] += share * (from + along * way - points[i]);
      }
    }
    return parts;
  }

  /// A joined curve as stages; nullopt where one of them may not be so.
  std::optional<std::vector<TimedStage>> cutAll(const JoinedTiming& joined_curve,
                                                const std::vector<DofId>& dofs) {
    const JoinedTiming* joined = &joined_curve;
    std::vector<TimedStage> timed;
    std::size_t first = 0;
    for (std::size_t i = 0; i < stages_.size(); ++i) {
      if (deadline_.over()) return std::nullopt;
      const bool ends = i + 1 == stages_.size();
      const std::size_t last = ends ? joined->path.t.size() - 1 : cut(joined->junctions[i], i);
      if (last <= first) return std::nullopt;
      auto piece = pieceOf(stages_[i], slice(joined->path, first, last), dofs);
      if (!piece) return std::nullopt;
      piece->goes_on = i > 0;
      if (!accept(*piece)) return std::nullopt;
      timed.push_back(std::move(*piece));
      first = last;
    }
    return timed;
  }

  /// Where a stage ends and the next begins: what has to be straight has no part in the corner.
  std::size_t cut(const Junction& junction, std::size_t stage) const {
    const bool line_before = typeOf(stages_[stage].stage.action) == StageType::kLinear;
    return line_before ? junction.first : junction.last;
  }

  /// The curve of one of joined stages; nullopt if its fingers still move at its end.
  static std::optional<TimedStage> pieceOf(const StagePath& stage, TimedPath path,
                                           const std::vector<DofId>& dofs) {
    const auto arm = static_cast<Eigen::Index>(stage.dofs.size());
    if (path.q.front().size() == arm) return TimedStage{&stage, dofs, std::move(path), 0, false};
    if (!stage.fingers) return TimedStage{&stage, stage.dofs, head(path, arm), 0, false};
    const Eigen::Index fingers = stage.fingers->to.size();
    if ((path.q.back().tail(fingers) - stage.fingers->to).cwiseAbs().maxCoeff() > kFingersAtRest ||
        path.qd.back().tail(fingers).cwiseAbs().maxCoeff() > kFingersAtRest ||
        path.qdd.back().tail(fingers).cwiseAbs().maxCoeff() > kFingersAtRest) {
      return std::nullopt;
    }
    path.q.back().tail(fingers) = stage.fingers->to;
    path.qd.back().tail(fingers).setZero();
    path.qdd.back().tail(fingers).setZero();
    return TimedStage{&stage, dofs, std::move(path), 0, false};
  }

  bool accept(TimedStage& timed) {
    const StagePath& stage = *timed.stage;
    if (typeOf(stage.stage.action) == StageType::kLinear && !staysStraight(timed)) {
      fail(stage, Cause::kStraightApproach);
      return false;
    }
    if (stage.stage.action == StageAction::kRetreat) timed.clear = clearTime(timed);
    if (!keepsTilt(timed)) {
      fail(stage, Cause::kTilt);
      return false;
    }
    const auto hit = hitOnCurve(timed);
    if (!hit) return true;
    fail(stage, Cause::kTiming, {nameOf(hit->a), nameOf(hit->b)});
    return false;
  }

  const std::string& nameOf(BodyId body) const { return problem_.collision->name(body); }

  static Pose toolAt(const TimedStage& timed, double t) {
    const Manipulator& arm = *timed.stage->mover;
    return arm.toolPose(evaluate(timed.path, t).head(arm.kinematics->dofs()));
  }

  static bool staysStraight(const TimedStage& timed) {
    constexpr int kParts = 4;  // looks from one sample to the next
    const Pose X_WT_from = toolAt(timed, 0);
    const Pose X_WT_to = toolAt(timed, timed.path.duration());
    const Eigen::Vector3d way = X_WT_to.translation() - X_WT_from.translation();
    const double length = way.norm();
    if (length <= 0) return false;
    const StageAction action = timed.stage->stage.action;
    if (action == StageAction::kRetreat && length < kLeastRetreat) return false;
    if (action == StageAction::kLift && way.z() < std::cos(kLeaning) * length) return false;
    const Eigen::Vector3d along = way / length;
    const Eigen::Quaterniond from(X_WT_from.linear()), to(X_WT_to.linear());
    for (std::size_t i = 1; i < timed.path.t.size(); ++i) {
      for (int part = 1; part <= kParts; ++part) {
        const double before = timed.path.t[i - 1];
        const Pose X = toolAt(timed, before + (timed.path.t[i] - before) * part / kParts);
        const Eigen::Vector3d gone = X.translation() - X_WT_from.translation();
        const double at = std::clamp(gone.dot(along), 0.0, length);
        if ((gone - at * along).norm() > kOffLine) return false;
        const Eigen::Quaterniond expected = from.slerp(at / length, to);
        if (expected.angularDistance(Eigen::Quaterniond(X.linear())) > kTurned) return false;
      }
    }
    return true;
  }

  static double clearTime(const TimedStage& timed) {
    const Eigen::Vector3d start = toolAt(timed, 0).translation();
    const auto clear = [&](double t) {
      return (toolAt(timed, t).translation() - start).norm() >= kClearDistance;
    };
    double high = kLook;
    while (high < timed.path.duration() && !clear(high)) high += kLook;
    double low = high - kLook;
    while (high - low > kLookExact) {
      const double middle = 0.5 * (low + high);
      (clear(middle) ? high : low) = middle;
    }
    return std::min(high, timed.path.duration());
  }

  bool keepsTilt(const TimedStage& timed) {
    const StagePath& stage = *timed.stage;
    return !context_.tilt() || !carries(stage.stage) ||
           context_.make(stage.state, *stage.mover, timed.dofs, allowedContacts(stage.stage))
               .keepsTilt(TimedMotion(timed.path));
  }

  /// A contact on the timed curve, if any.
  std::optional<BodyContact> hitOnCurve(const TimedStage& timed) {
    const StagePath& stage = *timed.stage;
    const TimedMotion motion(timed.path);
    AllowedContacts contacts = allowedContacts(stage.stage);
    if (stage.stage.action == StageAction::kApproach && stage.mover->hand->suction) {
      StateChecker cup = context_.make(stage.state, *stage.mover, timed.dofs, contacts);
      if (auto hit = cup.hitAlong(motion, 0, 1, kCupClearance)) return hit;
      contacts = besideObject(contacts, stage.stage.holder, *stage.mover);
    }
    StateChecker checker = context_.make(stage.state, *stage.mover, timed.dofs, contacts);
    double from = 0;
    if (stage.stage.action == StageAction::kRetreat) {
      StateChecker departing =
          context_.make(stage.state, *stage.mover, timed.dofs, departingContacts(stage.stage));
      from = (timed.clear - kLookExact) / timed.path.duration();
      if (auto hit = departing.hit(timed.path.q.front())) return hit;
      if (auto hit = departing.hitAlong(motion, 0, from, kTimedClearance)) return hit;
    } else if (auto hit = checker.hit(timed.path.q.front())) {
      return hit;
    }
    if (auto hit = checker.hit(timed.path.q.back())) return hit;
    return checker.hitAlong(motion, from, 1, kTimedClearance);
  }

  const TransportProblem& problem_;
  CollisionContext& context_;
  std::span<const StagePath> stages_;
  const Deadline& deadline_;
  bool has_fingers_ = false;
  Part finger_part_ = kFingerParts.front();
  MotionFailure failure_;
};

/// One past the last of the stages that may be joined from `first` on.
std::size_t blockEnd(const std::vector<StagePath>& stages, std::size_t first) {
  std::size_t end = first + 1;
  while (end < stages.size() && joinable(stages[end - 1].stage, stages[end].stage)) ++end;
  return end;
}

}  // namespace

std::variant<std::vector<TimedStage>, MotionFailure> timeStages(const TransportProblem& problem,
                                                                CollisionContext& context,
                                                                const TransportPath& path,
                                                                const Deadline& deadline) {
  std::vector<TimedStage> timed;
  for (std::size_t first = 0; first < path.stages.size();) {
    const std::size_t end = blockEnd(path.stages, first);
    const std::span block(path.stages.data() + first, end - first);
    auto result = BlockTimer(problem, context, block, deadline).time();
    if (auto* failure = std::get_if<MotionFailure>(&result)) return std::move(*failure);
    for (TimedStage& stage : std::get<std::vector<TimedStage>>(result)) {
      timed.push_back(std::move(stage));
    }
    first = end;
  }
  return timed;
}

}  // namespace handover
