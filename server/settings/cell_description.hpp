// SPDX-License-Identifier: Apache-2.0
// A cell file as values: typed and in range, names not yet looked up.
#pragma once

#include "settings/cell_file.hpp"
#include "settings/yaml_reader.hpp"

#include <handover/common/geometry.hpp>
#include <handover/common/plan_event.hpp>

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace handover {

/// A pose in a named frame: "world", an object, a robot, or robot/link.
struct FramedPose {
  std::string frame = "world";
  Pose X_FO = Pose::Identity();
};

struct RobotDescription {
  std::string name, model, posture;
  FramedPose base;  ///< of the root link
  std::map<std::string, double> joints;
  std::vector<std::pair<std::string, Pose>> tools;  ///< arm, X_BT in the root link's frame
  std::vector<NamePair> resting;                    ///< link, object
};

struct AttachmentDescription {
  std::string robot, link;
  Pose X_LO = Pose::Identity();
  std::vector<std::string> touch_links;
};

struct ObjectDescription {
  std::string name;
  Geometry geometry;
  std::optional<FramedPose> pose;
  std::optional<AttachmentDescription> attached_to;
  std::vector<std::string> resting;
  std::map<std::string, std::map<std::string, int>> grasp_counts;
};

/// `none`, or objects' names.
struct RestDescription {
  bool none = false;
  std::vector<std::string> objects;
};

struct TaskDescription {
  std::string name, object;
  std::vector<std::string> chain;   ///< `robot` or `robot/arm` each; empty: auto
  bool giver_and_receiver = false;  ///< the keys that the chain, of two, is written with
  std::optional<FramedPose> start;
  std::string held_by;  ///< `robot/arm` that has the object at the start; empty: it lies
  std::optional<RestDescription> start_rest;
  FramedPose goal;
  std::optional<RestDescription> goal_rest;
  TransportEnd end = TransportEnd::kRelease;
  std::optional<UprightSnapshot> upright;
};

struct CellDescription {
  std::string name;
  std::vector<RobotDescription> robots;
  std::vector<ObjectDescription> objects;
  std::vector<TaskDescription> tasks;
  std::vector<Variation> variations;
};

/// Faults go to `report`; the description is usable only if there were none.
CellDescription readCell(const YamlNode& document, YamlReport& report);

}  // namespace handover
