// SPDX-License-Identifier: Apache-2.0
#include "verify/robot_settings.hpp"

#include "verify/input_file.hpp"
#include "verify/unreadable.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace handover::verify {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMaxBytes = 16u << 20;

YAML::Node load(const fs::path& file) {
  try {
    YAML::Node node = YAML::Load(readFile(file, kMaxBytes));
    if (!node.IsMap()) throw Unreadable(file.string(), "expected a map of keys");
    return node;
  } catch (const YAML::Exception& error) {
    throw Unreadable(file.string(), error.what());
  }
}

class SettingsReader {
 public:
  SettingsReader(const fs::path& file, const Robot& robot)
      : file_(file), robot_(robot), root_(load(file)) {}

  RobotSettings read() {
    bounds_.resize(robot_.joints.size());
    std::vector<int> all;
    for (std::size_t j = 0; j < robot_.joints.size(); ++j) all.push_back(static_cast<int>(j));
    apply(root_, all);
    for (const auto& [name, arm] : entriesOf("arms")) apply(arm, jointsOfArm(name));
    for (const char* list : {"hands", "grippers"}) {
      for (const auto& [name, hand] : entriesOf(list)) apply(hand, jointsOfHand(hand));
    }
    for (const auto& [name, arm] : entriesOf("arms")) {
      // A gripper may also be written where its arm is.
      const YAML::Node gripper = arm["gripper"];
      if (gripper && gripper.IsMap()) apply(gripper, jointsOfHand(gripper));
    }
    std::vector<std::vector<int>> arms;
    for (const auto& [name, arm] : entriesOf("arms")) arms.push_back(jointsOfArm(name));
    return {std::move(bounds_), readPackages(file_), std::move(arms)};
  }

 private:
  [[noreturn]] void fail(const YAML::Node& node, const std::string& what) const {
    throw Unreadable(file_.string() + ":" + std::to_string(node.Mark().line + 1), what);
  }

  std::vector<std::pair<std::string, YAML::Node>> entriesOf(const char* key) const {
    std::vector<std::pair<std::string, YAML::Node>> entries;
    const YAML::Node list = root_[key];
    if (!list) return entries;
    if (!list.IsMap()) fail(list, std::string(key) + ": expected a map");
    for (const auto& entry : list) {
      if (!entry.second.IsMap()) fail(entry.second, std::string(key) + ": expected a map");
      entries.emplace_back(entry.first.as<std::string>(""), entry.second);
    }
    return entries;
  }

  double number(const YAML::Node& node) const {
    double value = 0;
    if (!node.IsScalar() || !YAML::convert<double>::decode(node, value) || !std::isfinite(value)) {
      fail(node, "expected a number");
    }
    return value;
  }

  void set(const YAML::Node& value, std::optional<double> JointBounds::*member,
           const std::vector<int>& joints) {
    if (!value || value.IsNull()) return;
    if (!value.IsMap()) {
      const double bound = number(value);
      for (const int j : joints) bounds_[static_cast<std::size_t>(j)].*member = bound;
      return;
    }
    for (const auto& entry : value) {
      const int joint = robot_.findJoint(entry.first.as<std::string>(""));
      if (joint < 0) continue;
      bounds_[static_cast<std::size_t>(joint)].*member = number(entry.second);
    }
  }

  void apply(const YAML::Node& node, const std::vector<int>& joints) {
    set(node["velocity"], &JointBounds::velocity, joints);
    set(node["acceleration"], &JointBounds::acceleration, joints);
    set(node["jerk"], &JointBounds::jerk, joints);
    const YAML::Node limits = node["limits"];
    if (!limits || !limits.IsMap()) return;
    for (const auto& entry : limits) {
      const int joint = robot_.findJoint(entry.first.as<std::string>(""));
      if (joint < 0 || !entry.second.IsMap()) continue;
      const std::vector<int> one = {joint};
      set(entry.second["lower"], &JointBounds::lower, one);
      set(entry.second["upper"], &JointBounds::upper, one);
      set(entry.second["velocity"], &JointBounds::velocity, one);
      set(entry.second["acceleration"], &JointBounds::acceleration, one);
      set(entry.second["jerk"], &JointBounds::jerk, one);
    }
  }

  /// An arm is named as its group of the SRDF.
  std::vector<int> jointsOfArm(const std::string& name) const {
    for (const Group& group : robot_.groups) {
      if (group.name == name) return group.joints;
    }
    return {};
  }

  /// Joints that no arm has and that the entry names anywhere or that are beyond its palm link.
  std::vector<int> jointsOfHand(const YAML::Node& hand) const {
    std::set<int> joints;
    collectJoints(hand, joints);
    const YAML::Node palm = hand["palm_link"] ? hand["palm_link"] : hand["palm"];
    const int link = palm ? robot_.findLink(palm.as<std::string>("")) : -1;
    for (const int below : link >= 0 ? robot_.subtree(link) : std::vector<int>()) {
      if (below != link) {
        joints.insert(robot_.links[static_cast<std::size_t>(below)].parent_joint);
      }
    }
    for (const auto& [name, arm] : entriesOf("arms")) {
      for (const int j : jointsOfArm(name)) joints.erase(j);
    }
    return {joints.begin(), joints.end()};
  }

  void collectJoints(const YAML::Node& node, std::set<int>& joints) const {
    if (node.IsScalar()) {
      const int joint = robot_.findJoint(node.Scalar());
      if (joint >= 0) joints.insert(joint);
    } else if (node.IsSequence()) {
      for (const auto& entry : node) collectJoints(entry, joints);
    } else if (node.IsMap()) {
      for (const auto& entry : node) {
        collectJoints(entry.first, joints);
        collectJoints(entry.second, joints);
      }
    }
  }

  fs::path file_;
  const Robot& robot_;
  const YAML::Node root_;
  std::vector<JointBounds> bounds_;
};

}  // namespace

std::map<std::string, fs::path> readPackages(const fs::path& yaml) {
  std::map<std::string, fs::path> packages;
  const YAML::Node root = load(yaml);
  const YAML::Node list = root["packages"];
  if (!list || !list.IsMap()) return packages;
  for (const auto& entry : list) {
    packages[entry.first.as<std::string>("")] =
        yaml.parent_path() / entry.second.as<std::string>("");
  }
  return packages;
}

RobotSettings readRobotSettings(const fs::path& yaml, const Robot& robot) {
  try {
    return SettingsReader(yaml, robot).read();
  } catch (const YAML::Exception& error) {
    throw Unreadable(yaml.string(), error.what());
  }
}

}  // namespace handover::verify
