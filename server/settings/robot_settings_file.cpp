// SPDX-License-Identifier: Apache-2.0
// robots/<name>/<name>.yaml
#include "settings/cell_file.hpp"
#include "settings/yaml_reader.hpp"

#include <cmath>

namespace handover {
namespace {

constexpr NumberRange kLength{-1000, 1000};      // [m]
constexpr NumberRange kAngle{-1000, 1000};       // [rad]
constexpr NumberRange kAcceleration{1e-3, 1e6};  // [rad/s^2]
constexpr NumberRange kJerk{1e-3, 1e9};          // [rad/s^3]
constexpr NumberRange kCupRadius{1e-3, 0.25};    // [m]
constexpr NumberRange kEngage{1e-2, 60};         // [s]
constexpr double kUnit = 1e-3;                   // of an axis: off unit length

std::string requiredText(YamlMap& map, const char* key) {
  const YamlValue* value = map.require(key);
  return value == nullptr ? "" : value->text().value_or("");
}

std::optional<double> optionalJerk(YamlMap& map) {
  const YamlValue* value = map.find("jerk");
  return value == nullptr ? std::nullopt : value->number(kJerk);
}

/// A PATH as the plan file shows it: relative to the root where it lies inside, else absolute.
std::string besides(const std::filesystem::path& file, const std::string& relative,
                    const std::filesystem::path& root) {
  namespace fs = std::filesystem;
  const fs::path full = (fs::absolute(file).parent_path() / relative).lexically_normal();
  const fs::path inside = full.lexically_relative(fs::absolute(root).lexically_normal());
  const bool outside = inside.empty() || *inside.begin() == "..";
  return (outside ? full : inside).generic_string();
}

ArmSettings readArm(const std::string& name, const YamlValue& value) {
  ArmSettings arm;
  arm.name = name;
  auto map = value.map();
  if (!map) return arm;
  arm.tool_link = requiredText(*map, "tool_link");
  arm.hand = requiredText(*map, "hand");
  if (const YamlValue* axis = map->require("approach_axis")) {
    arm.approach_axis = axis->vector(kLength).value_or(Eigen::Vector3d::UnitZ());
  }
  if (const YamlValue* acceleration = map->require("acceleration")) {
    arm.acceleration = acceleration->number(kAcceleration).value_or(1);
  }
  arm.jerk = optionalJerk(*map);
  if (const YamlValue* shoulder = map->find("shoulder"))
    arm.p_AShoulder = shoulder->vector(kLength);
  map->finish();
  return arm;
}

std::map<std::string, double> readPosture(YamlMap& hand, const char* key) {
  std::map<std::string, double> posture;
  const YamlValue* value = hand.require(key);
  auto map = value == nullptr ? std::nullopt : value->map();
  if (!map) return posture;
  for (const auto& [joint, position] : map->all()) {
    if (const auto number = position.number(kAngle)) posture.emplace(joint, *number);
  }
  return posture;
}

SuctionSettings readSuction(const YamlValue& value) {
  SuctionSettings suction;
  auto map = value.map();
  if (!map) return suction;
  suction.cup_link = requiredText(*map, "cup_link");
  if (const YamlValue* axis = map->require("axis")) {
    suction.axis = axis->vector(kLength).value_or(Eigen::Vector3d::UnitZ());
    if (std::abs(suction.axis.norm() - 1) > kUnit) axis->fault("must be of unit length");
    suction.axis.normalize();
  }
  if (const YamlValue* radius = map->require("radius")) {
    suction.radius = radius->number(kCupRadius).value_or(kCupRadius.high);
  }
  if (const YamlValue* engage = map->require("engage_s")) {
    suction.engage_s = engage->number(kEngage).value_or(kEngage.high);
  }
  map->finish();
  return suction;
}

HandSettings readHand(const std::string& name, const YamlValue& value) {
  HandSettings hand;
  hand.name = name;
  auto map = value.map();
  if (!map) return hand;
  if (const YamlValue* suction = map->find("suction")) {
    hand.suction = readSuction(*suction);
    for (const char* key :
         {"palm_link", "fingers", "finger_links", "open", "closed", "acceleration", "jerk"}) {
      if (const YamlValue* of_fingers = map->find(key)) {
        of_fingers->fault("is for fingers: a gripper has these or suction, not both");
      }
    }
    map->finish();
    return hand;
  }
  hand.palm_link = requiredText(*map, "palm_link");
  if (const YamlValue* fingers = map->require("fingers")) {
    for (const YamlValue& finger : fingers->list().value_or(std::vector<YamlValue>())) {
      if (auto joints = finger.texts()) hand.fingers.push_back(std::move(*joints));
    }
  }
  if (const YamlValue* links = map->require("finger_links")) {
    hand.finger_links = links->texts().value_or(std::vector<std::string>());
  }
  hand.open = readPosture(*map, "open");
  hand.closed = readPosture(*map, "closed");
  if (const YamlValue* acceleration = map->require("acceleration")) {
    hand.acceleration = acceleration->number(kAcceleration).value_or(1);
  }
  hand.jerk = optionalJerk(*map);
  map->finish();
  return hand;
}

}  // namespace

RobotSettings readRobotSettings(const std::filesystem::path& file,
                                const std::filesystem::path& root) {
  const std::string shown_file = file.string();
  YamlReport report;
  RobotSettings settings;
  settings.root = root;
  settings.settings_file = shown_file;
  const YamlNode document = parseYaml(readSettingsText(file), shown_file);
  auto map = YamlValue(document, "", report).map();
  if (!map) throw FileError(report.inFile(shown_file));
  if (const YamlValue* version = map->require("version")) version->integer(1, 1);
  if (const YamlValue* name = map->require("name")) settings.name = name->name().value_or("");
  settings.yaml = besides(file, file.filename().string(), root);
  settings.urdf = besides(file, requiredText(*map, "urdf"), root);
  settings.srdf = besides(file, requiredText(*map, "srdf"), root);
  if (const YamlValue* value = map->require("arms")) {
    if (auto arms = value->map()) {
      for (const auto& [name, arm] : arms->all()) {
        if (arm.checkName(name)) settings.arms.push_back(readArm(name, arm));
      }
    }
  }
  if (const YamlValue* value = map->require("hands")) {
    if (auto hands = value->map()) {
      for (const auto& [name, hand] : hands->all()) {
        if (hand.checkName(name)) settings.hands.push_back(readHand(name, hand));
      }
    }
  }
  if (const YamlValue* value = map->find("acceleration")) {
    settings.acceleration = value->number(kAcceleration).value_or(1);
  }
  settings.jerk = optionalJerk(*map);
  map->finish();
  if (!report.clean()) throw FileError(report.inFile(shown_file));
  settings.lines = report.lines();
  return settings;
}

}  // namespace handover
