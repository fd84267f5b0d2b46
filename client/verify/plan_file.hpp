// SPDX-License-Identifier: Apache-2.0
// The plan file (format handover-plan/2) as values, and its reader.
#pragma once

#include "verify/geometry.hpp"
#include "verify/pose.hpp"

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace handover::verify {

using NamePair = std::pair<std::string, std::string>;

struct ClaimedLimits {
  std::optional<double> lower, upper;  ///< null: the joint turns without end
  double velocity = 0, acceleration = 0, jerk = 0;
};

struct PlanRobot {
  std::string name, urdf, urdf_sha256, srdf, yaml, yaml_sha256;
  Pose X_WB;
  std::map<std::string, double> q_start;
  std::map<std::string, ClaimedLimits> limits;
  std::vector<NamePair> resting;  ///< [link, object]
};

struct Attachment {
  std::string robot, link;
  Pose X_LO;
  std::vector<std::string> touch_links;
};

struct PlanObject {
  std::string name;
  Geometry geometry;
  Pose X_WO;
  std::optional<Attachment> attached_to;
  std::vector<std::string> resting;
};

/// What O rests on; nullopt is the file's "none": held by a hook, a fixture, a magnet.
using Rest = std::optional<std::vector<std::string>>;

struct PlanStart {
  Pose X_WO;
  std::optional<NamePair> held_by;  ///< robot, arm
  Rest rest;
};

struct PlanGoal {
  Pose X_WO;
  bool release = true;  ///< false: the last holder keeps O
  Rest rest;
};

struct UprightRule {
  Eigen::Vector3d axis;  ///< unit, in O
  double within_deg = 0;
};

struct PlanHolder {
  std::string robot, arm, tool_link;
  bool suction = false;
  std::string palm;                                 ///< of fingers
  std::vector<std::string> fingers;                 ///< links
  std::string cup_link;                             ///< of suction
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit, in the cup link
  Pose X_OT;
  double take = 0, give = 0;  ///< dexterity
};

struct Hold {
  std::string object, robot, link;
  Pose X_LO;
};

/// Stage `stage` must have run `progress` seconds of its own time.
struct After {
  int stage = 0;
  double progress = 0;
};

struct PlanStage {
  int index = 0, holder = 0;
  std::string action, robot;
  std::vector<std::string> joints;
  double start = 0;                             ///< [s] from the plan's start
  std::vector<double> t;                        ///< [s] from the stage's start
  std::vector<std::vector<double>> q, qd, qdd;  ///< [sample][joint]
  std::vector<Hold> holding;
  std::vector<NamePair> may_touch;
  std::vector<After> after;

  double duration() const { return t.empty() ? 0 : t.back(); }

  double end() const { return start + duration(); }
};

struct ClearanceClaim {
  std::string between;  ///< furniture, robots, object
  double least = 0;     ///< [m]
  int stage = 0;
  std::optional<NamePair> pair;
};

struct QualityClaim {
  double duration = 0, bound = 0, object = 0;  ///< [s]
  std::map<std::string, double> idle;          ///< [s], by robot
  std::vector<ClearanceClaim> clearance;
  double tilt_deg = 0, turn_deg = 0, least_turn_deg = 0;
  std::optional<double> limit_margin;  ///< null: no joint with limits at a hold
  double jerk_share = 0;
};

struct Plan {
  std::string object;  ///< O's name
  std::vector<PlanRobot> robots;
  std::vector<PlanObject> objects;
  PlanStart start;
  PlanGoal goal;
  std::optional<UprightRule> upright;
  std::vector<PlanHolder> holders;
  std::vector<Pose> handovers;  ///< X_WO
  std::vector<PlanStage> stages;
  double slack = 0;  ///< [s]
  std::optional<QualityClaim> quality;

  /// Index by name, or -1.
  int findRobot(std::string_view name) const;
  int findObject(std::string_view name) const;
};

/// Reads and checks form: types, finite numbers, unit quaternions (1e-3), sizes, names that the
/// file itself defines. Whether the plan is a good one is not asked here.
/// @throws Unreadable naming the field as a JSON pointer; a file whose plan is null is unreadable.
Plan parsePlan(std::string_view text);

/// The text of a plan file. @throws Unreadable when it cannot be opened or is too large.
std::string readPlanText(const std::filesystem::path& file);

/// Both. @throws Unreadable naming the file, and the field in it.
Plan readPlan(const std::filesystem::path& file);

}  // namespace handover::verify
