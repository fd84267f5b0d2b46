// SPDX-License-Identifier: Apache-2.0
#include "verify/advance.hpp"
#include "verify/checks.hpp"

#include <algorithm>
#include <cmath>

namespace handover::verify {
namespace {

constexpr double kAside = 1e-3;  // [m] from the segment between the ends
constexpr double kTurn = 0.5 * M_PI / 180;
constexpr double kFineness = 0.05;             // of the tolerance, between two looks
constexpr double kUp = 1 * M_PI / 180;         // of a lift
constexpr double kShortest = 1e-6;             // [m] of a lift that has a direction
constexpr double kFirstMotion = 5e-3;          // [m] of a retreat
constexpr double kLengthTolerance = 1e-6;      // [m]
constexpr double kFirstMotionFineness = 1e-7;  // [m]

/// Distance of p from the segment from a to b.
double fromSegment(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d ab = b - a;
  const double length = ab.squaredNorm();
  const double along = length > 0 ? std::clamp((p - a).dot(ab) / length, 0.0, 1.0) : 0.0;
  return (p - a - along * ab).norm();
}

void checkStage(const Motion& motion, int s, Report& report) {
  const Scene& scene = motion.scene();
  const PlanStage& stage = scene.stage(s);
  const Holder& holder = scene.holder(stage.holder);
  const double from = motion.start(s), to = motion.end(s);
  const Pose X_WT_from = motion.toolAt(stage.holder, from);
  const Pose X_WT_to = motion.toolAt(stage.holder, to);
  const Eigen::Vector3d way = X_WT_to.translation() - X_WT_from.translation();
  const auto violation = [&](double time, const std::string& what) {
    report.add({s, time, "straight", what, {}});
  };
  if (stage.action == "retreat" && way.norm() < kFirstMotion - kLengthTolerance) {
    violation(to, "goes back by " + text(way.norm() * 1e3) + " mm instead of 5 at least");
  }
  if (stage.action == "lift" &&
      (way.norm() < kShortest || std::atan2(way.head<2>().norm(), way.z()) > kUp)) {
    violation(to, "does not go straight up");
  }
  const auto aside = [&](double T) {
    const Pose X_WT = motion.toolAt(stage.holder, T);
    return std::max(
        fromSegment(X_WT.translation(), X_WT_from.translation(), X_WT_to.translation()) / kAside,
        rotationBetween(X_WT_from, X_WT) / kTurn);
  };
  const auto rate = [&](double a, double b) {
    const Rates rates = motion.ratesOf(holder.robot, holder.tool_link, {0, 0, 0}, a, b);
    return std::max(rates.point / kAside, rates.turn / kTurn);
  };
  const auto found = firstAbove(motion.cutsOf(holder.robot, from, to), aside, rate, 1.0, kFineness);
  if (!found) return;
  const Pose X_WT = motion.toolAt(stage.holder, *found);
  violation(*found, "the tool link is " +
                        text(1e3 * fromSegment(X_WT.translation(), X_WT_from.translation(),
                                               X_WT_to.translation())) +
                        " mm and " + text(rotationBetween(X_WT_from, X_WT) * 180 / M_PI) +
                        " deg from the straight way");
}

/// The retreat's own time when the tool link's origin is first 5 mm from where it began; its
/// duration when that never happens. No point moves faster than its joints allow, so that no
/// crossing is passed over.
double firstMotion(const Motion& motion, int holder, int retreat) {
  const Holder& entry = motion.scene().holder(holder);
  const double from = motion.start(retreat);
  const Eigen::Vector3d p_W = motion.toolAt(holder, from).translation();
  const auto moved = [&](double T) {
    return (motion.toolAt(holder, T).translation() - p_W).norm();
  };
  const auto rate = [&](double a, double b) {
    return motion.ratesOf(entry.robot, entry.tool_link, {0, 0, 0}, a, b).point;
  };
  const auto found = firstAbove(motion.cutsOf(entry.robot, from, motion.end(retreat)), moved, rate,
                                kFirstMotion - kFirstMotionFineness, kFirstMotionFineness);
  return found ? *found - from : motion.scene().stage(retreat).duration();
}

}  // namespace

void checkStraight(const Motion& motion, Report& report) {
  for (int s = 0; s < motion.scene().stageCount(); ++s) {
    const std::string& action = motion.scene().stage(s).action;
    if (action == "approach" || action == "lift" || action == "retreat" || action == "place") {
      checkStage(motion, s, report);
    }
  }
}

void findLeaving(const Motion& motion, Task& task) {
  const Scene& scene = motion.scene();
  task.first_5mm.assign(task.of.size(), 0.0);
  task.hand_leaves.assign(task.of.size(), 0.0);
  for (int k = 0; k <= task.last(); ++k) {
    const auto index = static_cast<std::size_t>(k);
    const int retreat = task.of[index].retreat;
    if (retreat < 0) continue;
    task.first_5mm[index] = firstMotion(motion, k, retreat);
    task.hand_leaves[index] = task.first_5mm[index];
    if (k == task.last()) continue;
    for (const After& after : scene.stage(task.of[index + 1].carry).after) {
      if (after.stage != retreat) continue;
      task.hand_leaves[index] =
          std::clamp(after.progress, task.first_5mm[index], scene.stage(retreat).duration());
    }
  }
}

}  // namespace handover::verify
