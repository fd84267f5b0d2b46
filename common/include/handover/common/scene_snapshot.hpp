// SPDX-License-Identifier: Apache-2.0
// The scene of a plan as the wire and the plan file show it (`scene` of handover-plan/2), as plain
// values. Units: m, rad, s. Bodies are named `robot/link` or by the object's name.
#pragma once

#include <handover/common/enum_names.hpp>
#include <handover/common/geometry.hpp>
#include <handover/common/pose.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace handover {

struct JointLimits {
  /// [rad] or [m]; nullopt both: a continuous joint.
  std::optional<double> lower = 0, upper = 0;
  double velocity = 0;      ///< [rad/s]
  double acceleration = 0;  ///< [rad/s^2]
  double jerk = 0;          ///< [rad/s^3]
  bool operator==(const JointLimits&) const = default;
};

/// Two names: [link, object], [object, object] or [robot/link, ...], as said at the member.
using NamePair = std::pair<std::string, std::string>;

struct RobotSnapshot {
  std::string name;
  std::string urdf, srdf, yaml;                         ///< paths relative to the root
  std::string urdf_sha256, yaml_sha256;                 ///< 64 hex digits each
  PoseValue X_WB;                                       ///< of the URDF's root link
  std::vector<std::pair<std::string, double>> q_start;  ///< every non-fixed joint, mimic ones too
  std::vector<std::pair<std::string, JointLimits>> limits;  ///< of the same joints
  std::vector<NamePair> resting;                            ///< [link, object name]
  bool operator==(const RobotSnapshot&) const = default;
};

struct AttachmentSnapshot {
  std::string robot, link;
  PoseValue X_LO;
  std::vector<std::string> touch_links;
  bool operator==(const AttachmentSnapshot&) const = default;
};

struct ObjectSnapshot {
  std::string name;
  Geometry geometry;
  PoseValue X_WO;  ///< at the start
  std::optional<AttachmentSnapshot> attached_to;
  std::vector<std::string> resting;  ///< objects that it may touch for good; none for O
  bool operator==(const ObjectSnapshot&) const = default;
};

/// An arm of a robot, by names.
struct ArmName {
  std::string robot, arm;
  auto operator<=>(const ArmName&) const = default;
};

/// What O rests on. `none`: it hangs or is fixed there, so nothing below it is asked
/// for.
struct RestSnapshot {
  bool none = false;
  std::vector<std::string> objects;
  bool operator==(const RestSnapshot&) const = default;
};

struct StartSnapshot {
  PoseValue X_WO;
  std::optional<ArmName> held_by;
  RestSnapshot rest;  ///< empty where O is held
  bool operator==(const StartSnapshot&) const = default;
};

/// What becomes of O at its goal: put down, or still held there.
enum class TransportEnd { kUnspecified = 0, kRelease, kHold };

template <>
struct EnumNames<TransportEnd> {
  static constexpr std::array value{"unspecified", "release", "hold"};
};

struct GoalSnapshot {
  PoseValue X_WO;
  TransportEnd end = TransportEnd::kRelease;
  RestSnapshot rest;  ///< empty where O ends in a hand
  bool operator==(const GoalSnapshot&) const = default;
};

/// While held, O's axis leans at most so far beyond the larger of its leans at start and goal.
struct UprightSnapshot {
  std::array<double, 3> axis{0, 0, 1};  ///< in O
  double within_deg = 0;
  bool operator==(const UprightSnapshot&) const = default;
};

/// The scene after the request's overrides.
struct SceneSnapshot {
  std::string cell, task;
  std::uint64_t seed = 0;
  std::string scene_hash;  ///< hex digits
  std::string object;
  std::vector<RobotSnapshot> robots;
  std::vector<ObjectSnapshot> objects;
  StartSnapshot start;
  GoalSnapshot goal;
  std::optional<UprightSnapshot> upright;
  bool operator==(const SceneSnapshot&) const = default;
};

}  // namespace handover
