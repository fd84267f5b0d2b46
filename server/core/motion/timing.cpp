// SPDX-License-Identifier: Apache-2.0
#include "core/motion/timing.hpp"

#include "core/motion/corner_path.hpp"
#include "core/motion/smoothing.hpp"
#include "core/motion/speed_profile.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

namespace handover {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kLeastSegment = 2e-5;   // [rad] nearer waypoints are one
constexpr double kLeastGap = 2e-3;       // [s] of samples
constexpr double kPositionSlack = 1e-9;  // [rad]
constexpr double kOffTheLine = 1e-4;     // [rad] that still count as on a junction's straight line
constexpr double kLongest = 3600;        // [s] of motion at full speed

// Steps of the samples that are smoothed.
constexpr double kStepsPerMotion = 24;  // at least
constexpr double kFineStep = 0.01;      // [s] fine enough for any motion
constexpr double kCoarseStep = 0.02;    // [s] for long ones
constexpr double kLongMotion = 600;     // fine steps from which on they become coarse
constexpr double kMostSteps = 20'000;   // of slow joints, whose steps become longer
constexpr double kMostSamples = 5'000;  // of a curve, corners apart: then its gaps become longer

// A motion from rest to rest along one line takes the least time for its jerk if, before it is
// smoothed over a window w, it takes sqrt(8) w at full acceleration all the time.
constexpr double kLeastBuildUps = 2.8284271247461903;

// Build-ups for which the speed is held on paths with corners, whose acceleration is not 0 then.
constexpr double kPause = 1.2;

std::string faultOf(const TimingLimits& limits, Index dof) {
  for (const VectorXd* v :
       {&limits.lower, &limits.upper, &limits.velocity, &limits.acceleration, &limits.jerk}) {
    if (v->size() != dof) return "limits: their number differs from the waypoints' joints";
  }
  const auto positive = [](double x) { return x > 0 && std::isfinite(x); };
  for (Index j = 0; j < dof; ++j) {
    const std::string joint = "limits of joint " + std::to_string(j);
    if (!(limits.lower[j] <= limits.upper[j])) return joint + ": lower is not below upper";
    if (!positive(limits.velocity[j])) return joint + ": velocity is not above 0 and finite";
    if (!positive(limits.acceleration[j]))
      return joint + ": acceleration is not above 0 and finite";
    if (!positive(limits.jerk[j])) return joint + ": jerk is not above 0 and finite";
  }
  return "";
}

std::string faultOf(const TimingSettings& settings) {
  if (!(settings.blend >= 0) || !std::isfinite(settings.blend)) return "blend: not >= 0";
  if (!(settings.max_sample_gap >= kLeastGap)) return "max_sample_gap: not at least 2 ms";
  if (!(settings.speed_scale > 0 && settings.speed_scale <= 1)) return "speed_scale: not in (0, 1]";
  return "";
}

// The first fault of the input, or an empty text.
std::string faultOf(const std::vector<VectorXd>& waypoints, const TimingLimits& limits,
                    const TimingSettings& settings) {
  if (waypoints.empty()) return "path: no waypoints";
  const Index dof = waypoints.front().size();
  if (dof == 0) return "path: waypoints without joints";
  if (const std::string fault = faultOf(limits, dof); !fault.empty()) return fault;
  for (std::size_t i = 0; i < waypoints.size(); ++i) {
    const std::string point = "waypoint " + std::to_string(i);
    if (waypoints[i].size() != dof) return point + ": size differs from the first one's";
    for (Index j = 0; j < dof; ++j) {
      const double q = waypoints[i][j];
      if (!std::isfinite(q)) return point + ": joint " + std::to_string(j) + " is not finite";
      if (q < limits.lower[j] - kPositionSlack || q > limits.upper[j] + kPositionSlack) {
        return point + ": joint " + std::to_string(j) + " is outside its limits";
      }
    }
  }
  return faultOf(settings);
}

// Both ends as given, between them no two nearer than kLeastSegment; one point if nothing moves.
// `kept` gets, for each waypoint, the point that stands for it.
std::vector<VectorXd> distinct(const std::vector<VectorXd>& waypoints,
                               std::vector<std::size_t>& kept) {
  std::vector<VectorXd> points{waypoints.front()};
  kept.clear();
  for (const VectorXd& q : waypoints) {
    if ((q - points.back()).norm() > kLeastSegment) points.push_back(q);
    kept.push_back(points.size() - 1);
  }
  const VectorXd& last = waypoints.back();
  if (points.back() != last) {
    if (points.size() > 1 && (last - points.back()).norm() <= kLeastSegment) points.pop_back();
    points.push_back(last);
  }
  for (std::size_t& point : kept) point = std::min(point, points.size() - 1);
  kept.back() = points.size() - 1;
  return points;
}

// A divisor of the build-up time, so that the window it asks for is a whole number of steps.
double stepFor(double duration, double build_up, double gap) {
  if (duration > kMostSteps * kCoarseStep) return duration / kMostSteps;
  double step = std::clamp(duration / kLongMotion, kFineStep, kCoarseStep);
  step = std::clamp(std::min(step, duration / kStepsPerMotion), kLeastGap, gap);
  const double parts = std::ceil(build_up / step - 1e-9);
  const double most = std::floor(build_up / kLeastGap);
  return std::min(parts, most) >= 1 ? build_up / std::min(parts, most) : step;
}

// A motion that is ready to become a spline.
struct Smoothed {
  SpeedProfile profile;
  EvenSamples samples;
  int window;

  Smoothed(SpeedProfile speeds, double step, const VectorXd& jerk)
      : profile(std::move(speeds)),
        samples(profile.sample(step), step, jerk),
        window(samples.leastWindow()) {}

  double duration() const {
    return static_cast<double>(samples.knots(window) - 1) * samples.step();
  }
};

// Slows motions that are too short for their acceleration to build up.
void spareJerk(SpeedProfile& profile, const TimingLimits& limits) {
  const double least = kLeastBuildUps * profile.buildUp(limits);
  if (profile.duration() < least) profile.slowDown(std::cbrt(least / profile.duration()));
}

// Acceleration that turns from one way at once to the other needs two build-ups to do so smoothly;
// it is often quicker to hold the speed for one build-up in between.
Smoothed smoothed(SpeedProfile profile, const TimingLimits& limits, double gap, bool has_corners) {
  const double build_up = profile.buildUp(limits);
  const double step = stepFor(profile.duration(), build_up, gap);
  SpeedProfile flat = profile;
  flat.flattenPeaks(has_corners ? kPause * build_up : build_up);
  Smoothed smooth(std::move(flat), step, limits.jerk);
  if (smooth.duration() <= profile.duration() + 2 * build_up + 2 * step) return smooth;
  Smoothed peaked(std::move(profile), step, limits.jerk);
  return peaked.duration() < smooth.duration() ? std::move(peaked) : std::move(smooth);
}

// The knots from where the curve leaves the straight line before the corner to where it is on the
// one after; a knot sees a step more than the window.
struct KnotRange {
  Index first, nearest, last;
};

KnotRange aroundCorner(const Smoothed& motion, const Corner& corner, double start) {
  if (corner.half == 0) return {0, 0, 0};  // the stop from which the motion begins
  const double step = motion.samples.step(), at = corner.at - start;
  // The parabola is off its tangent by turn s^2 / (4 half).
  const double on_line =
      corner.turn > 0 ? std::sqrt(4 * corner.half * kOffTheLine / corner.turn) : corner.half;
  const double reach = std::max(0.0, corner.half - on_line);
  const auto in_steps = [&](double s) { return motion.profile.timeAt(s) / step; };
  const Index last = motion.samples.knots(motion.window) - 1;
  const auto knot = [&](double k) { return std::clamp<Index>(static_cast<Index>(k), 0, last); };
  KnotRange range{knot(std::floor(in_steps(at - reach))),
                  knot(std::round(in_steps(at) + 0.5 * (motion.window + 1))),
                  knot(std::ceil(in_steps(at + reach)) + motion.window + 1)};
  range.nearest = std::clamp(range.nearest, range.first, range.last);
  return range;
}

// Times the points from rest to rest without a stop; `junctions` gets one entry per corner asked
// for (rising indices of points).
Result<TimedPath> timeMoving(const std::vector<VectorXd>& points,
                             const std::vector<Corner>& corners,
                             const std::vector<std::size_t>& asked, const TimingLimits& limits,
                             double gap, std::vector<Junction>& junctions) {
  const CornerPath path = cutIntoCells(points, corners);
  SpeedProfile profile(path, limits);
  if (!profile.passable()) {
    return {ErrorCode::kInternal, "timing: the path cannot be passed at any speed"};
  }
  spareJerk(profile, limits);
  if (!(profile.duration() <= kLongest)) {
    return {ErrorCode::kInvalidInput, "limits: the path takes more than an hour"};
  }
  gap = std::max(gap, profile.duration() / kMostSamples);
  const Smoothed motion = smoothed(std::move(profile), limits, gap, points.size() > 2);
  std::vector<KnotRange> ranges;
  std::vector<Index> keep, kept;
  for (const std::size_t corner : asked) {
    const KnotRange range = aroundCorner(motion, corners[corner], corners.front().at);
    ranges.push_back(range);
    keep.insert(keep.end(), {range.first, range.nearest, range.last});
  }
  std::sort(keep.begin(), keep.end());
  TimedPath timed = motion.samples.spline(motion.window, gap, keep, kept);
  const auto sample = [&](Index knot) {
    return static_cast<std::size_t>(std::lower_bound(kept.begin(), kept.end(), knot) -
                                    kept.begin());
  };
  junctions.clear();
  for (const KnotRange& range : ranges) {
    junctions.push_back({sample(range.first), sample(range.nearest), sample(range.last)});
  }
  return timed;
}

JoinedTiming atRest(const VectorXd& from, const VectorXd& to, std::size_t junctions) {
  const VectorXd rest = VectorXd::Zero(from.size());
  return {{{0, kLeastGap}, {from, to}, {rest, rest}, {rest, rest}},
          std::vector<Junction>(junctions)};
}

// The junctions are waypoints, by index.
Result<JoinedTiming> timeAll(const std::vector<VectorXd>& waypoints,
                             const std::vector<std::size_t>& junctions, const TimingLimits& limits,
                             const TimingSettings& settings) {
  if (const std::string fault = faultOf(waypoints, limits, settings); !fault.empty()) {
    return {ErrorCode::kInvalidInput, fault};
  }
  std::vector<std::size_t> point_of;
  const std::vector<VectorXd> points = distinct(waypoints, point_of);
  if (points.size() == 1) return atRest(waypoints.front(), waypoints.back(), junctions.size());

  const std::vector<Corner> corners = roundCorners(points, settings.blend);
  JoinedTiming joined;
  joined.junctions.resize(junctions.size());
  std::vector<std::size_t> asked;
  std::vector<Junction> found;
  auto next = junctions.begin();
  // From stop to stop.
  for (std::size_t begin = 0, end = 1; begin + 1 < points.size(); begin = end++) {
    while (corners[end].half > 0) ++end;
    const auto from = static_cast<std::ptrdiff_t>(begin), to = static_cast<std::ptrdiff_t>(end) + 1;
    asked.clear();
    const auto first_asked = next;
    for (; next != junctions.end() && point_of[*next] < end; ++next) {
      asked.push_back(point_of[*next] - begin);
    }
    auto timed = timeMoving({points.begin() + from, points.begin() + to},
                            {corners.begin() + from, corners.begin() + to}, asked, limits,
                            settings.max_sample_gap, found);
    if (!timed) return timed.error();
    const std::size_t offset = joined.path.t.empty() ? 0 : joined.path.t.size() - 1;
    auto out = joined.junctions.begin() + (first_asked - junctions.begin());
    for (const Junction& it : found) {
      *out++ = {offset + it.first, offset + it.nearest, offset + it.last};
    }
    if (joined.path.t.empty()) {
      joined.path = std::move(*timed);
    } else {
      append(joined.path, *timed);
    }
  }
  for (; next != junctions.end(); ++next) {
    const std::size_t last = joined.path.t.size() - 1;
    joined.junctions[static_cast<std::size_t>(next - junctions.begin())] = {last, last, last};
  }
  if (settings.speed_scale < 1) stretchTime(joined.path, 1 / settings.speed_scale);
  keepLimits(joined.path, limits);
  return joined;
}

}  // namespace

Result<TimedPath> parameterize(const std::vector<VectorXd>& waypoints, const TimingLimits& limits,
                               const TimingSettings& settings) {
  auto joined = timeAll(waypoints, {}, limits, settings);
  if (!joined) return joined.error();
  return std::move(joined->path);
}

Result<JoinedTiming> parameterizeJoined(const std::vector<std::vector<VectorXd>>& polylines,
                                        const TimingLimits& limits,
                                        const TimingSettings& settings) {
  std::vector<VectorXd> waypoints;
  std::vector<std::size_t> junctions;
  for (const auto& polyline : polylines) {
    if (polyline.empty()) return {ErrorCode::kInvalidInput, "path: a polyline without waypoints"};
    if (waypoints.empty()) {
      waypoints = polyline;
      continue;
    }
    if (polyline.front() != waypoints.back()) {
      return {ErrorCode::kInvalidInput,
              "path: a polyline begins elsewhere than the one before ends"};
    }
    junctions.push_back(waypoints.size() - 1);
    waypoints.insert(waypoints.end(), polyline.begin() + 1, polyline.end());
  }
  return timeAll(waypoints, junctions, limits, settings);
}

}  // namespace handover
