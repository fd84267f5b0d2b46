// SPDX-License-Identifier: Apache-2.0
#include "core/planning/free_motion.hpp"

#include "core/motion/lazy_roadmap.hpp"

#include <handover/common/random.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace handover {
namespace {

// Of the straight way, where it is projected: one in nine of kneeling's roadmap ways needs them.
constexpr std::array<double, 3> kBetween{0.25, 0.5, 0.75};
constexpr double kUprightBeyond = 1e-3;  // what a step aims for beyond [rad]
constexpr double kUprightDamping = 1e-2;
constexpr int kUprightSteps = 10;

/// Past the object and out of what stands about it: back or up from one of the ends.
void addViasAbout(const Manipulator& arm, const ArmVector& end, const FreeMotionSettings& settings,
                  std::vector<ArmVector>& vias) {
  const Pose X_WT = arm.toolPose(end);
  const auto add = [&](const Pose& X_WT_via) {
    ArmVector q;
    if (arm.kinematics->trackPose(arm.worldToArm(X_WT_via), end, settings.farthest_via, q)) {
      vias.push_back(q);
    }
  };
  for (const double distance : settings.back) {
    const Pose X_WT_back = arm.backedOff(X_WT, distance);
    add(X_WT_back);
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d aside = settings.aside * Eigen::Vector3d::Unit(axis);
      if (std::abs(arm.arm_model->approach_axis.dot(aside)) > 0.5 * settings.aside) continue;
      for (const double side : {1.0, -1.0}) add(X_WT_back * Eigen::Translation3d(side * aside));
    }
  }
  for (const double height : settings.up) {
    add(Eigen::Translation3d(0, 0, height) * X_WT);
  }
}

/// Round what stands before the arm where it is: a joint turned far first.
void addBows(const Manipulator& arm, const ArmVector& from, const FreeMotionSettings& settings,
             std::vector<ArmVector>& vias) {
  const auto joints = std::min(static_cast<Eigen::Index>(settings.bowed_joints), from.size());
  for (Eigen::Index k = 0; k < joints; ++k) {
    for (const double by : settings.bow) {
      ArmVector q = from;
      q[k] += by;
      if (q[k] >= arm.kinematics->lower()[k] && q[k] <= arm.kinematics->upper()[k]) {
        vias.push_back(q);
      }
    }
  }
}

/// Some joints first, then the others.
void addSplits(const ArmVector& from, const ArmVector& to, std::vector<ArmVector>& vias) {
  for (Eigen::Index k = 1; k < from.size(); ++k) {
    ArmVector near_first = from, far_first = to;
    near_first.head(k) = to.head(k);
    far_first.head(k) = from.head(k);
    vias.push_back(near_first);
    vias.push_back(far_first);
  }
}

/// Turns what the arm holds about a horizontal axis to within its limit, by damped least squares;
/// false: not that near.
bool turnUpright(const Manipulator& arm, const HeldObject& held, ArmVector& q) {
  const double wanted = held.tilt->within();
  const Eigen::Matrix3d R_AW = arm.worldToArm(Pose::Identity()).linear();
  ArmJacobian J;
  for (int step = 0; step < kUprightSteps; ++step) {
    const Pose X_AT = arm.kinematics->toolPose(q, J);
    const Eigen::Vector3d axis_A = X_AT.linear() * held.X_LO.linear() * held.tilt->axis_O;
    const double tilt = tiltOf(R_AW.transpose() * axis_A);
    if (tilt <= wanted) return true;
    const Eigen::Vector3d across = axis_A.cross(R_AW.col(2));
    if (!(across.norm() > 0)) return false;  // upside down: any way is as good
    const Eigen::VectorXd by = J.bottomRows<3>().transpose() * across.normalized();
    q += (tilt - wanted + kUprightBeyond) / (by.squaredNorm() + kUprightDamping) * by;
    q = q.cwiseMax(arm.kinematics->lower()).cwiseMin(arm.kinematics->upper());
  }
  return false;
}

}  // namespace

std::optional<Clearance> skinClearance(double skin) {
  constexpr double kProven = 0.93;  // of the skin, all along a motion that keeps it where looked at
  if (skin <= 0) return std::nullopt;
  return Clearance{skin, kProven * skin};
}

MotionProblem FreeMotionSolver::problemOf(const Manipulator& arm, StateChecker& checker,
                                          double skin) const {
  MotionProblem motion;
  motion.lower = arm.kinematics->lower();
  motion.upper = arm.kinematics->upper();
  motion.valid = [&checker](const ArmVector& q) { return checker.valid(q); };
  motion.valid_between = [&checker, wide = skinClearance(skin)](const ArmVector& from,
                                                                const ArmVector& to) {
    return checker.isMotionFree(SegmentMotion(from, to), kPlannedClearance, wide);
  };
  motion.rounding = settings_.rounding;
  if (const auto& held = checker.setup().held; held && held->tilt) {
    motion.project = [&arm, &held = *held](ArmVector& q) { return turnUpright(arm, held, q); };
  }
  return motion;
}

std::vector<ArmVector> FreeMotionSolver::viasBetween(const Manipulator& arm, const ArmVector& from,
                                                     const ArmVector& to) const {
  std::vector<ArmVector> vias;
  addViasAbout(arm, from, settings_, vias);
  addViasAbout(arm, to, settings_, vias);
  addBows(arm, from, settings_, vias);
  addSplits(from, to, vias);
  return vias;
}

std::optional<JointPath> FreeMotionSolver::roadmapPath(const Manipulator& arm,
                                                       const MotionProblem& motion,
                                                       const ArmVector& from, const ArmVector& to,
                                                       const std::vector<ArmVector>& known,
                                                       std::uint32_t checks) const {
  // Nothing is cheaper than to go straight, and often that is free.
  if (segmentValid(motion, from, to)) return JointPath{{from, to}};
  const auto cost = [&](const ArmVector& a, const ArmVector& b) {
    return travelTime(arm, a, b) + settings_.corner_time;
  };
  LazyRoadmapSettings settings;
  settings.most_checks = checks;
  settings.most = settings_.most_detour * travelTime(arm, from, to) +
                  settings_.most_corners * settings_.corner_time;
  settings.straight = false;
  std::vector<ArmVector> vias = viasBetween(arm, from, to);
  vias.insert(vias.end(), known.begin(), known.end());
  if (motion.project) {
    for (const double share : kBetween) vias.push_back(from + share * (to - from));
    std::erase_if(vias, [&](ArmVector& q) { return !motion.project(q); });
  }
  return lazyShortestPath(motion, from, to, std::move(vias), cost, settings, deadline_);
}

/// With the widest skin that gives one.
std::optional<JointPath> FreeMotionSolver::wideRoadmapPath(
    const Manipulator& arm, const ArmVector& from, const ArmVector& to, StateChecker& checker,
    const std::vector<ArmVector>& known, std::uint32_t checks) const {
  for (const double skin : settings_.skins) {
    const MotionProblem motion = problemOf(arm, checker, skin);
    if (!motion.valid_between(from, from) || !motion.valid_between(to, to)) continue;
    if (auto path = roadmapPath(arm, motion, from, to, known, checks)) return path;
  }
  return roadmapPath(arm, problemOf(arm, checker, 0), from, to, known, checks);
}

std::optional<JointPath> FreeMotionSolver::treePath(const MotionProblem& motion,
                                                    const ArmVector& from, const GoalSampler& goals,
                                                    std::uint64_t seed, const SeedPaths& known,
                                                    std::uint32_t& goal, std::uint32_t patience) {
  IkBiRrtSettings settings;
  settings.direct_goals = 0;
  settings.max_iterations =
      patience * (failed_trees_ < settings_.patient_trees ? settings_.rrt_iterations
                                                          : settings_.rrt_iterations_then);
  settings.seed = SeededRandom::mix(seed);
  settings.from_start = known.from_start;
  settings.from_goal = known.from_goal;
  const auto path = planIkBiRrt(motion, from, goals, settings, deadline_, &goal);
  if (!path) {
    ++failed_trees_;
    return std::nullopt;
  }
  return shortcut(motion, *path, settings.seed, settings_.shortcut_attempts, deadline_);
}

std::optional<JointPath> FreeMotionSolver::solve(const Manipulator& arm, const ArmVector& from,
                                                 const ArmVector& to, StateChecker& checker,
                                                 std::uint64_t seed, const SeedPaths& known) {
  if (!checker.valid(from) || !checker.valid(to)) return std::nullopt;
  // If a tree was needed last time, the few cheap attempts are skipped.
  const bool hard = known.from_start.size() > settings_.simple_path;
  const std::uint32_t checks = hard ? settings_.few_checks : settings_.most_checks;
  if (auto path = wideRoadmapPath(arm, from, to, checker, known.from_goal, checks)) return path;
  const auto only_goal = [&](std::uint32_t i, ArmVector& q) {
    q = to;
    return i == 0;
  };
  std::uint32_t goal = 0;
  return treePath(problemOf(arm, checker, 0), from, only_goal, seed, known, goal);
}

std::optional<JointPath> FreeMotionSolver::solveToAny(const Manipulator& arm, const ArmVector& from,
                                                      const GoalSampler& goals,
                                                      StateChecker& checker, std::uint64_t seed,
                                                      std::uint32_t& goal, std::uint32_t patience) {
  if (!checker.valid(from)) return std::nullopt;
  // Try a roadmap path to each goal before trees.
  ArmVector to;
  for (const std::uint32_t checks : {settings_.few_checks, settings_.most_checks}) {
    for (std::uint32_t i = 0; i < settings_.direct_goals && goals(i, to); ++i) {
      if (!checker.valid(to)) continue;
      if (auto path = wideRoadmapPath(arm, from, to, checker, {}, checks)) {
        goal = i;
        return path;
      }
    }
  }
  return treePath(problemOf(arm, checker, 0), from, goals, seed, {}, goal, patience);
}

}  // namespace handover
