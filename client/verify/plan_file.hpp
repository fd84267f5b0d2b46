// SPDX-License-Identifier: Apache-2.0
// The plan file (format handover-plan/1) as values, and its reader.
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
  double lower, upper, velocity, acceleration;
};

struct PlanRobot {
  std::string name, urdf, urdf_sha256, srdf;
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

struct Hold {
  std::string object, robot, link;
  Pose X_LO;
};

struct PlanEvent {
  int index = 0;
  std::string kind, robot;
  std::vector<std::string> joints;
  double start = 0;                        ///< [s] from the plan's start
  std::vector<double> t;                   ///< [s] from the stage's start
  std::vector<std::vector<double>> q, qd;  ///< [sample][joint]
  std::vector<Hold> holding;
  std::vector<NamePair> may_touch;

  double end() const { return t.empty() ? start : start + t.back(); }
};

struct Plan {
  std::string cell, task, object, giver, receiver, giver_arm, receiver_arm;
  std::string giver_tool_link, receiver_tool_link;
  std::vector<PlanRobot> robots;
  std::vector<PlanObject> objects;
  Pose X_WO_start, X_WO_goal, X_WO_handover, X_OT_giver, X_OT_receiver;
  double receiver_place = 0, receiver_handover = 0, giver_pick = 0, giver_handover = 0;
  std::vector<PlanEvent> stages;

  /// Index by name, or -1.
  int findRobot(std::string_view name) const;
  int findObject(std::string_view name) const;
};

/// Reads and checks form: types, finite numbers, unit quaternions (1e-3), sizes, names that the
/// file itself defines. Whether the plan is a good one is not asked here.
/// @throws Unreadable naming the field as a JSON pointer.
Plan parsePlan(std::string_view text);

/// The text of a plan file. @throws Unreadable when it cannot be opened or is too large.
std::string readPlanText(const std::filesystem::path& file);

/// Both. @throws Unreadable naming the file, and the field in it.
Plan readPlan(const std::filesystem::path& file);

}  // namespace handover::verify
