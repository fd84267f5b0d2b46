// SPDX-License-Identifier: Apache-2.0
#include "core/motion/through_timing.hpp"

#include "core/motion/corner_path.hpp"
#include "core/motion/least_time.hpp"
#include "core/motion/smoothing.hpp"
#include "core/motion/speed_profile.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>

namespace handover {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using Points = std::vector<VectorXd>;

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kLeastGap = 2e-3;  // [s] of samples
constexpr double kStep = 0.01;      // [s] of those that are smoothed
constexpr double kLongest = 200;    // [s]: of slow joints, that gain nothing by being bold
constexpr double kLeastSegment = 2e-5;
constexpr int kRounds = 2;  // over the speeds of a free part's waypoints
// Speeds at waypoints, of the most there; run-ups of lines, that decide how fast they are entered
// or left [rad].
constexpr std::array<double, 5> kSpeeds{0, 0.25, 0.5, 0.75, 1};
constexpr std::array<double, 5> kRunUps{0.001, 0.02, 0.08, 0.25, 0.8};
constexpr double kAsideShare = 0.7;  // of the part in which joints aside move

/// A line from rest, or to rest: how it is passed where it meets a free part at speed.
class LinePass {
 public:
  /// @param run_up  by which the line is prolonged where it meets the free part [rad]; there it
  ///                would begin or end at rest.
  LinePass(Points line, bool from_rest, double run_up, double blend, const TimingLimits& limits)
      : from_rest_(from_rest) {
    if (from_rest) std::reverse(line.begin(), line.end());
    const VectorXd out = (line[0] - line[1]).normalized();
    line.insert(line.begin(), line[0] + run_up * out);
    double at = run_up;
    if (from_rest) {
      std::reverse(line.begin(), line.end());
      at = -run_up;
    }
    const std::vector<Corner> corners = roundCorners(line, blend);
    if (from_rest) at += corners.back().at;
    path_ = cutIntoCells(line, corners);
    profile_.emplace(path_, limits);
    // Acceleration that is reversed at once would ask for twice the window all along the movement.
    profile_->flattenPeaks(profile_->buildUp(limits));
    met_ = profile_->timeAt(at);
    velocity_ = profile_->speedAt(at) * (from_rest ? out : VectorXd(-out));
  }

  LinePass(const LinePass&) = delete;

  bool passable() const { return profile_->passable(); }

  double time() const { return from_rest_ ? met_ : profile_->duration() - met_; }

  const VectorXd& velocity() const { return velocity_; }

  void at(double t, Eigen::Ref<VectorXd> q) const {
    profile_->at(from_rest_ ? std::min(t, met_) : met_ + t, q);
  }

 private:
  bool from_rest_;
  CornerPath path_;
  std::optional<SpeedProfile> profile_;
  double met_ = 0;
  VectorXd velocity_;
};

/// A free part: its waypoints, and how fast each is passed.
class FreePass {
 public:
  FreePass(const Points& points, const TimingLimits& limits, double boldness)
      : limits_(limits), boldness_(boldness) {
    for (const VectorXd& q : points) states_.push_back({q, VectorXd::Zero(q.size())});
    directions_.resize(points.size());
    for (std::size_t i = 1; i + 1 < points.size(); ++i) directions_[i] = directionAt(points, i);
  }

  /// Finds the speeds at the waypoints; [s] that it takes, infinite where it cannot be passed.
  double settle(const VectorXd& v_begin, const VectorXd& v_end) {
    states_.front().qd = v_begin;
    states_.back().qd = v_end;
    for (int round = 0; round < kRounds; ++round) {
      for (std::size_t i = 1; i + 1 < states_.size(); ++i) settle(i);
      if (states_.size() < 4) break;
    }
    double time = 0;
    for (std::size_t i = 0; i + 1 < states_.size(); ++i) time += timeFrom(i);
    return time;
  }

  std::optional<std::vector<LeastTimeMotion>> motions() const {
    std::vector<LeastTimeMotion> motions;
    for (std::size_t i = 0; i + 1 < states_.size(); ++i) {
      auto motion = LeastTimeMotion::between(states_[i], states_[i + 1], limits_);
      if (!motion) return std::nullopt;
      motions.push_back(std::move(*motion));
    }
    return motions;
  }

 private:
  /// The most velocity along the way: none of a joint that turns round there.
  VectorXd directionAt(const Points& points, std::size_t i) const {
    const VectorXd before = points[i] - points[i - 1], after = points[i + 1] - points[i];
    VectorXd along = before / before.norm() + after / after.norm();
    for (Index j = 0; j < along.size(); ++j) {
      if (before[j] * after[j] <= 0) along[j] = 0;
    }
    const double most = (along.cwiseAbs().array() / limits_.velocity.array()).maxCoeff();
    return most > 0 ? VectorXd(along * (boldness_ / most)) : along;
  }

  double timeFrom(std::size_t i) const { return leastTime(states_[i], states_[i + 1], limits_); }

  void settle(std::size_t i) {
    double least = kNever;
    VectorXd best = VectorXd::Zero(states_[i].q.size());
    for (const double speed : kSpeeds) {
      states_[i].qd = speed * directions_[i];
      const double time = timeFrom(i - 1) + timeFrom(i);
      if (time < least) {
        least = time;
        best = states_[i].qd;
      }
    }
    states_[i].qd = best;
  }

  const TimingLimits& limits_;
  double boldness_;
  std::vector<MotionState> states_;
  std::vector<VectorXd> directions_;
};

TimingLimits headOf(const TimingLimits& limits, Index size) {
  return {limits.lower.head(size), limits.upper.head(size), limits.velocity.head(size),
          limits.acceleration.head(size), limits.jerk.head(size)};
}

TimingLimits tailOf(const TimingLimits& limits, Index size) {
  return {limits.lower.tail(size), limits.upper.tail(size), limits.velocity.tail(size),
          limits.acceleration.tail(size), limits.jerk.tail(size)};
}

Points distinct(const Points& points) {
  Points kept{points.front()};
  for (std::size_t i = 1; i < points.size(); ++i) {
    if ((points[i] - kept.back()).norm() > kLeastSegment) kept.push_back(points[i]);
  }
  if (kept.size() > 1) kept.back() = points.back();
  return kept;
}

}  // namespace

class ThroughMovement::Impl {
 public:
  Impl(const std::vector<MovementPart>& parts, const std::optional<JointsAside>& aside,
       const TimingLimits& limits, double blend, double boldness)
      : arm_(parts.front().waypoints.front().size()),
        limits_(limits),
        arm_limits_(headOf(limits, arm_)),
        aside_(aside),
        first_(parts.front().waypoints.front()),
        last_(parts.back().waypoints.back()) {
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (!parts[i].line) free_ = i;
    }
    FreePass pass(parts[free_].waypoints, arm_limits_, boldness);
    std::vector<std::unique_ptr<LinePass>> befores, afters;
    if (free_ > 0) befores = linesOf(parts[free_ - 1].waypoints, true, blend, boldness);
    if (free_ + 1 < parts.size()) {
      afters = linesOf(parts[free_ + 1].waypoints, false, blend, boldness);
    }
    choose(pass, std::move(befores), std::move(afters));
    if (found_) moveAside();
    found_ = found_ && duration() <= kLongest;
  }

  bool found() const { return found_; }

  double duration() const { return ends_.back(); }

  Eigen::MatrixXd sample(double step) const {
    const auto steps = static_cast<Index>(std::ceil(duration() / step - 1e-9));
    const Index dof = arm_ + (aside_ ? aside_->from.size() : 0);
    Eigen::MatrixXd samples(dof, steps + 1);
    VectorXd q(arm_), q_aside(dof - arm_);
    for (Index k = 0; k <= steps; ++k) {
      const double t = std::min(static_cast<double>(k) * step, duration());
      armAt(t, q);
      samples.col(k).head(arm_) = q;
      if (!aside_) continue;
      asideAt(t, q_aside);
      samples.col(k).tail(dof - arm_) = q_aside;
    }
    // To the bit.
    samples.col(0).head(arm_) = first_;
    samples.col(steps).head(arm_) = last_;
    if (aside_) {
      samples.col(0).tail(dof - arm_) = aside_->from;
      samples.col(steps).tail(dof - arm_) = aside_->to;
    }
    return samples;
  }

  const TimingLimits& limits() const { return limits_; }

  /// Smoothed over the least window that jerk allows.
  JoinedTiming smooth(double gap) const {
    const EvenSamples samples(sample(kStep), kStep, limits_.jerk);
    const int window = samples.leastWindow();
    std::vector<Index> keep, kept;
    const Index last = samples.knots(window) - 1;
    for (std::size_t i = 0; i + 1 < ends_.size(); ++i) {
      const double at = ends_[i] / kStep;
      keep.push_back(std::clamp<Index>(static_cast<Index>(std::floor(at)), 0, last));
      keep.push_back(std::clamp<Index>(static_cast<Index>(std::ceil(at)) + window + 1, 0, last));
    }
    std::vector<Index> sorted = keep;
    std::sort(sorted.begin(), sorted.end());
    JoinedTiming timing;
    timing.path = samples.spline(window, gap, sorted, kept);
    const auto sampleOf = [&](Index knot) {
      return static_cast<std::size_t>(std::lower_bound(kept.begin(), kept.end(), knot) -
                                      kept.begin());
    };
    for (std::size_t i = 0; i < keep.size(); i += 2) {
      const std::size_t first = sampleOf(keep[i]);
      timing.junctions.push_back({first, first, sampleOf(keep[i + 1])});
    }
    return timing;
  }

 private:
  std::vector<std::unique_ptr<LinePass>> linesOf(const Points& line, bool from_rest, double blend,
                                                 double boldness) const {
    std::vector<std::unique_ptr<LinePass>> passes;
    for (const double run_up : kRunUps) {
      passes.push_back(
          std::make_unique<LinePass>(line, from_rest, boldness * run_up, blend, arm_limits_));
      if (!passes.back()->passable()) passes.pop_back();
    }
    return passes;
  }

  /// How the lines before and after the free part are passed.
  struct Passing {
    const LinePass *before, *after;
    double time;
  };

  /// The quickest combination that joint limits allow.
  void choose(FreePass& pass, std::vector<std::unique_ptr<LinePass>> befores,
              std::vector<std::unique_ptr<LinePass>> afters) {
    if (befores.empty()) befores.push_back(nullptr);
    if (afters.empty()) afters.push_back(nullptr);
    std::vector<Passing> passings;
    for (const auto& before : befores) {
      for (const auto& after : afters) {
        Passing passing{before.get(), after.get(), 0};
        passing.time =
            settle(pass, passing) + (before ? before->time() : 0) + (after ? after->time() : 0);
        if (passing.time < kNever) passings.push_back(passing);
      }
    }
    std::stable_sort(passings.begin(), passings.end(),
                     [](const Passing& a, const Passing& b) { return a.time < b.time; });
    for (const Passing& passing : passings) {
      settle(pass, passing);
      auto motions = pass.motions();
      if (!motions) continue;
      free_motions_ = std::move(*motions);
      for (auto& before : befores) {
        if (before.get() == passing.before) before_ = std::move(before);
      }
      for (auto& after : afters) {
        if (after.get() == passing.after) after_ = std::move(after);
      }
      found_ = true;
      break;
    }
    double time = 0;
    if (before_) ends_.push_back(time = before_->time());
    for (const LeastTimeMotion& motion : free_motions_) time += motion.duration();
    ends_.push_back(time);
    if (after_) ends_.push_back(time + after_->time());
  }

  double settle(FreePass& pass, const Passing& passing) const {
    const VectorXd rest = VectorXd::Zero(arm_);
    return pass.settle(passing.before ? passing.before->velocity() : rest,
                       passing.after ? passing.after->velocity() : rest);
  }

  double beginOf(std::size_t part) const { return part == 0 ? 0 : ends_[part - 1]; }

  void moveAside() {
    if (!aside_) return;
    const TimingLimits its = tailOf(limits_, aside_->from.size());
    const VectorXd rest = VectorXd::Zero(aside_->from.size());
    const double time = ends_[aside_->part] - beginOf(aside_->part);
    aside_motion_ =
        LeastTimeMotion::between({aside_->from, rest}, {aside_->to, rest}, its, kAsideShare * time);
    found_ = aside_motion_ && aside_motion_->duration() <= time;
  }

  void asideAt(double t, Eigen::Ref<VectorXd> q) const {
    aside_motion_->at(t - beginOf(aside_->part), q);
  }

  void armAt(double t, Eigen::Ref<VectorXd> q) const {
    if (before_ && t <= before_->time()) return before_->at(t, q);
    t -= before_ ? before_->time() : 0;
    for (const LeastTimeMotion& motion : free_motions_) {
      const bool last = &motion == &free_motions_.back();
      if (t <= motion.duration() || (last && !after_)) return motion.at(t, q);
      t -= motion.duration();
    }
    after_->at(t, q);
  }

  Index arm_;
  TimingLimits limits_, arm_limits_;
  std::optional<JointsAside> aside_;
  VectorXd first_, last_;
  std::size_t free_ = 0;  ///< the free part
  std::unique_ptr<LinePass> before_, after_;
  std::vector<LeastTimeMotion> free_motions_;
  std::optional<LeastTimeMotion> aside_motion_;
  std::vector<double> ends_;  ///< of the parts [s]
  bool found_ = false;
};

ThroughMovement::ThroughMovement(const std::vector<MovementPart>& parts,
                                 const std::optional<JointsAside>& aside,
                                 const TimingLimits& limits, double blend, double boldness) {
  std::vector<MovementPart> cleaned;
  for (const MovementPart& part : parts) {
    cleaned.push_back({distinct(part.waypoints), part.line});
    if (cleaned.back().waypoints.size() < 2) return;
  }
  impl_ = std::make_unique<Impl>(cleaned, aside, limits, blend, boldness);
}

ThroughMovement::~ThroughMovement() = default;
ThroughMovement::ThroughMovement(ThroughMovement&&) noexcept = default;
ThroughMovement& ThroughMovement::operator=(ThroughMovement&&) noexcept = default;

bool ThroughMovement::found() const { return impl_ && impl_->found(); }

double ThroughMovement::duration() const { return impl_->duration(); }

JoinedTiming ThroughMovement::timing(const TimingSettings& settings) const {
  JoinedTiming timing = impl_->smooth(std::max(kLeastGap, settings.max_sample_gap));
  if (settings.speed_scale < 1) stretchTime(timing.path, 1 / settings.speed_scale);
  keepLimits(timing.path, impl_->limits());
  return timing;
}

}  // namespace handover
