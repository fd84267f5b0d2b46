// SPDX-License-Identifier: Apache-2.0
#include "settings/cell_description.hpp"

#include <handover/common/check.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

namespace handover {
namespace {

constexpr NumberRange kPlace{-1000, 1000};  // [m]
constexpr NumberRange kDegrees{-3600, 3600};
constexpr NumberRange kJoint{-1000, 1000};  // [rad] or [m]
constexpr NumberRange kSize{1e-6, 1000};    // [m]
constexpr double kLeastAxis = 1e-6;
constexpr std::size_t kMaxParts = 256;
constexpr std::size_t kMaxVariations = 512;  // each is checked with the whole cell

/// Quarter turns come out exact: what rounding left of 0 and 1 is taken away.
Eigen::Matrix3d rotationFromDegrees(const Eigen::Vector3d& rpy) {
  const Eigen::Vector3d radians = rpy * (std::numbers::pi / 180.0);
  Eigen::Matrix3d R = rotationFromRpy(radians.x(), radians.y(), radians.z());
  for (double& entry : R.reshaped()) {
    if (std::abs(entry - std::round(entry)) < 1e-15) entry = std::round(entry) + 0.0;
  }
  return R;
}

void readQuaternion(const YamlValue& value, Pose& X) {
  const auto given = value.numbers({-2, 2});
  if (!given) return;
  if (given->size() != 4) return value.fault("must be a list of four numbers: w, x, y, z");
  const Eigen::Quaterniond quat((*given)[0], (*given)[1], (*given)[2], (*given)[3]);
  if (std::abs(quat.norm() - 1.0) > 1e-3) return value.fault("must have length 1");
  X.linear() = quat.normalized().toRotationMatrix();
}

/// Keys xyz and rpy_deg or quat_wxyz of a map that is finished by the caller.
Pose readPlace(YamlMap& map, YamlReport& report) {
  Pose X = Pose::Identity();
  if (const YamlValue* xyz = map.find("xyz")) {
    X.translation() = xyz->vector(kPlace).value_or(Eigen::Vector3d::Zero());
  }
  const YamlValue* rpy = map.find("rpy_deg");
  const YamlValue* quat = map.find("quat_wxyz");
  if (rpy != nullptr && quat != nullptr) report.add(map.path(), "has both rpy_deg and quat_wxyz");
  if (rpy != nullptr) {
    if (const auto degrees = rpy->vector(kDegrees)) X.linear() = rotationFromDegrees(*degrees);
  } else if (quat != nullptr) {
    readQuaternion(*quat, X);
  }
  return X;
}

Pose readPose(const YamlValue& value) {
  auto map = value.map();
  if (!map) return Pose::Identity();
  Pose X = readPlace(*map, value.report());
  map->finish();
  return X;
}

FramedPose readFramedPose(const YamlValue& value) {
  FramedPose pose;
  auto map = value.map();
  if (!map) return pose;
  if (const YamlValue* frame = map->find("frame")) pose.frame = frame->text().value_or("world");
  pose.X_FO = readPlace(*map, value.report());
  map->finish();
  return pose;
}

std::string requiredName(YamlMap& map, const char* key) {
  const YamlValue* value = map.require(key);
  return value == nullptr ? "" : value->text().value_or("");
}

std::vector<std::string> optionalTexts(YamlMap& map, const char* key) {
  const YamlValue* value = map.find(key);
  return value == nullptr ? std::vector<std::string>()
                          : value->texts().value_or(std::vector<std::string>());
}

// ---- robots

void readTools(const YamlValue& value, RobotDescription& robot) {
  auto arms = value.map();
  if (!arms) return;
  for (const auto& [name, arm] : arms->all()) {
    auto map = arm.map();
    if (!map) continue;
    if (const YamlValue* tool = map->find("tool")) robot.tools.emplace_back(name, readPose(*tool));
    map->finish();
  }
}

void readRobotResting(const YamlValue& value, RobotDescription& robot) {
  for (const YamlValue& entry : value.list().value_or(std::vector<YamlValue>())) {
    const auto pair = entry.texts();
    if (!pair) continue;
    if (pair->size() != 2) {
      entry.fault("must be [link, object]");
      continue;
    }
    robot.resting.emplace_back((*pair)[0], (*pair)[1]);
  }
}

RobotDescription readRobot(const std::string& name, const YamlValue& value) {
  RobotDescription robot;
  robot.name = name;
  auto map = value.map();
  if (!map) return robot;
  if (const YamlValue* model = map->require("model")) robot.model = model->name().value_or("");
  if (const YamlValue* base = map->require("base")) robot.base = readFramedPose(*base);
  if (const YamlValue* posture = map->find("posture")) {
    robot.posture = posture->text().value_or("");
  }
  if (const YamlValue* joints = map->find("joints")) {
    if (auto entries = joints->map()) {
      for (const auto& [joint, position] : entries->all()) {
        if (const auto number = position.number(kJoint)) robot.joints.emplace(joint, *number);
      }
    }
  }
  if (const YamlValue* arms = map->find("arms")) readTools(*arms, robot);
  if (const YamlValue* resting = map->find("resting")) readRobotResting(*resting, robot);
  map->finish();
  return robot;
}

// ---- objects

double readSize(YamlMap& map, const char* key) {
  const YamlValue* value = map.require(key);
  return value == nullptr ? 0.0 : value->number(kSize).value_or(0.0);
}

std::array<double, 3> arrayOf(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

MeshGeometry readMesh(YamlMap& map) {
  MeshGeometry mesh;
  if (const YamlValue* value = map.require("path")) {
    mesh.path = value->text().value_or("");
    const std::filesystem::path path = std::filesystem::path(mesh.path).lexically_normal();
    if (path.is_absolute() || (!path.empty() && *path.begin() == "..")) {
      value->fault("must lie inside the root");
    }
  }
  if (const YamlValue* value = map.find("scale")) {
    const auto scale = value->vector({-1000, 1000});
    if (scale && scale->cwiseAbs().minCoeff() < 1e-6) value->fault("must not be zero");
    mesh.scale = arrayOf(scale.value_or(Eigen::Vector3d::Ones()));
  }
  return mesh;
}

Geometry readGeometry(const YamlValue& value, bool may_be_compound);

CompoundGeometry readCompound(YamlMap& map) {
  CompoundGeometry compound;
  const YamlValue* parts = map.require("parts");
  if (parts == nullptr) return compound;
  const auto entries = parts->list();
  if (!entries) return compound;
  if (entries->empty() || entries->size() > kMaxParts) {
    parts->fault("must have 1 to " + std::to_string(kMaxParts) + " entries");
    return compound;
  }
  for (const YamlValue& entry : *entries) {
    auto part_map = entry.map();
    if (!part_map) continue;
    GeometryPart part;
    if (const YamlValue* name = part_map->find("name")) name->name();  // for overrides only
    if (const YamlValue* pose = part_map->find("pose")) part.X_OS = toValue(readPose(*pose));
    if (const YamlValue* geometry = part_map->require("geometry")) {
      part.geometry = readGeometry(*geometry, false);
    }
    part_map->finish();
    compound.parts.push_back(std::move(part));
  }
  return compound;
}

Geometry readGeometry(const YamlValue& value, bool may_be_compound) {
  Geometry geometry;
  auto map = value.map();
  if (!map) return geometry;
  const YamlValue* type = map->require("type");
  if (type == nullptr) return geometry;
  const auto word = may_be_compound ? type->oneOf({"box", "sphere", "cylinder", "mesh", "compound"})
                                    : type->oneOf({"box", "sphere", "cylinder", "mesh"});
  if (!word) return geometry;
  if (*word == "box") {
    const YamlValue* size = map->require("size");
    const auto edges = size == nullptr ? std::nullopt : size->vector(kSize);
    geometry = BoxGeometry{arrayOf(edges.value_or(Eigen::Vector3d::Ones()))};
  } else if (*word == "sphere") {
    geometry = SphereGeometry{readSize(*map, "radius")};
  } else if (*word == "cylinder") {
    const double radius = readSize(*map, "radius");
    geometry = CylinderGeometry{radius, readSize(*map, "length")};
  } else if (*word == "mesh") {
    geometry = readMesh(*map);
  } else {
    geometry = readCompound(*map);
  }
  map->finish();
  return geometry;
}

AttachmentDescription readAttachment(const YamlValue& value) {
  AttachmentDescription attachment;
  auto map = value.map();
  if (!map) return attachment;
  attachment.robot = requiredName(*map, "robot");
  attachment.link = requiredName(*map, "link");
  if (const YamlValue* pose = map->find("pose")) attachment.X_LO = readPose(*pose);
  attachment.touch_links = optionalTexts(*map, "touch_links");
  map->finish();
  return attachment;
}

void readGrasps(const YamlValue& value, ObjectDescription& object) {
  auto robots = value.map();
  if (!robots) return;
  for (const auto& [robot, hands] : robots->all()) {
    auto map = hands.map();
    if (!map) continue;
    for (const auto& [hand, count] : map->all()) {
      if (const auto number = count.integer(1, 10000)) object.grasp_counts[robot][hand] = *number;
    }
  }
}

ObjectDescription readObject(const std::string& name, const YamlValue& value) {
  ObjectDescription object;
  object.name = name;
  auto map = value.map();
  if (!map) return object;
  if (const YamlValue* geometry = map->require("geometry")) {
    object.geometry = readGeometry(*geometry, true);
  }
  const YamlValue* pose = map->find("pose");
  const YamlValue* attached = map->find("attached_to");
  if (pose != nullptr) object.pose = readFramedPose(*pose);
  if (attached != nullptr) object.attached_to = readAttachment(*attached);
  if ((pose == nullptr) == (attached == nullptr)) {
    value.fault(pose == nullptr ? "has neither pose nor attached_to"
                                : "has both pose and attached_to");
  }
  object.resting = optionalTexts(*map, "resting");
  if (const YamlValue* grasps = map->find("grasps")) readGrasps(*grasps, object);
  map->finish();
  return object;
}

// ---- tasks and variations

/// A list of `robot` or `robot/arm`, or `auto`; or giver and receiver, a chain of two.
std::vector<std::string> readChain(YamlMap& task, const YamlValue& value) {
  const YamlValue* chain = task.find("chain");
  const YamlValue* giver = task.find("giver");
  const YamlValue* receiver = task.find("receiver");
  if (chain == nullptr && (giver != nullptr || receiver != nullptr)) {
    return {requiredName(task, "giver"), requiredName(task, "receiver")};
  }
  if (chain == nullptr) {
    value.fault("needs a chain: [robot or robot/arm, ...] or auto");
    return {};
  }
  if (giver != nullptr || receiver != nullptr) {
    chain->fault("stands in place of giver and receiver: not both");
  }
  if (chain->isScalar()) {
    if (chain->text().value_or("") != kAutoChain) chain->fault("must be a list or auto");
    return {};
  }
  auto holders = chain->texts().value_or(std::vector<std::string>());
  if (holders.empty()) chain->fault("is empty");
  if (holders.size() > bounds::kHolders) {
    chain->fault("has more than " + std::to_string(bounds::kHolders) + " holders");
  }
  return holders;
}

std::optional<RestDescription> readRest(YamlMap& task, const char* key) {
  const YamlValue* value = task.find(key);
  if (value == nullptr) return std::nullopt;
  if (value->isScalar()) {
    if (value->text().value_or("") != "none") value->fault("must be a list of objects or none");
    return RestDescription{true, {}};
  }
  return RestDescription{false, value->texts().value_or(std::vector<std::string>())};
}

/// A pose, or {held_by: robot/arm}.
void readStart(const YamlValue& value, TaskDescription& task) {
  auto map = value.map();
  if (!map) return;
  if (map->find("held_by") == nullptr) {
    task.start = readFramedPose(value);
    return;
  }
  task.held_by = requiredName(*map, "held_by");
  map->finish();
}

UprightSnapshot readUpright(const YamlValue& value) {
  UprightSnapshot upright;
  auto map = value.map();
  if (!map) return upright;
  if (const YamlValue* axis = map->require("axis")) {
    const Eigen::Vector3d axis_O = axis->vector(kPlace).value_or(Eigen::Vector3d::UnitZ());
    if (axis_O.norm() < kLeastAxis) axis->fault("is zero");
    upright.axis = {axis_O.x(), axis_O.y(), axis_O.z()};
  }
  if (const YamlValue* within = map->require("within_deg")) {
    upright.within_deg = within->number({0, 180}).value_or(0);
  }
  map->finish();
  return upright;
}

TaskDescription readTask(const std::string& name, const YamlValue& value) {
  TaskDescription task;
  task.name = name;
  auto map = value.map();
  if (!map) return task;
  task.object = requiredName(*map, "object");
  task.chain = readChain(*map, value);
  task.giver_and_receiver = map->find("chain") == nullptr;
  if (const YamlValue* start = map->find("start")) readStart(*start, task);
  task.start_rest = readRest(*map, "start_rest");
  if (const YamlValue* goal = map->require("goal")) task.goal = readFramedPose(*goal);
  task.goal_rest = readRest(*map, "goal_rest");
  if (const YamlValue* end = map->find("end")) {
    const auto word = end->oneOf({"release", "hold"});
    if (word) task.end = fromString<TransportEnd>(*word).value_or(TransportEnd::kRelease);
  }
  if (const YamlValue* upright = map->find("upright")) task.upright = readUpright(*upright);
  map->finish();
  return task;
}

std::vector<double> readEnd(const YamlValue& value) {
  if (value.isList()) return value.numbers().value_or(std::vector<double>());
  const auto number = value.number();
  return number ? std::vector<double>{*number} : std::vector<double>();
}

void readRange(const YamlValue& range, Variation& variation) {
  const auto ends = range.list();
  if (!ends) return;
  if (ends->size() != 2) return range.fault("must be [from, to]");
  variation.from = readEnd((*ends)[0]);
  variation.to = readEnd((*ends)[1]);
  if (variation.from.size() != variation.to.size() || variation.from.empty()) {
    return range.fault("must have two ends of the same size");
  }
  for (std::size_t i = 0; i < variation.from.size(); ++i) {
    if (variation.from[i] > variation.to[i]) return range.fault("lower bound exceeds upper");
  }
}

Variation readVariation(const std::string& path, const YamlValue& value) {
  Variation variation;
  variation.path = path;
  auto map = value.map();
  if (!map) return variation;
  const YamlValue* range = map->find("range");
  const YamlValue* choices = map->find("choices");
  if ((range == nullptr) == (choices == nullptr)) {
    value.fault("must have either range or choices");
  } else if (range != nullptr) {
    readRange(*range, variation);
  } else {
    for (const YamlValue& choice : choices->list().value_or(std::vector<YamlValue>())) {
      variation.choices.push_back(choice.flowText());
    }
    if (variation.choices.empty()) choices->fault("must not be empty");
  }
  if (const YamlValue* facing = map->find("facing")) {
    const auto point = facing->numbers(kPlace);
    if (point && point->size() == 2 && variation.from.size() == 3 && path.ends_with(".rpy_deg")) {
      variation.facing = {(*point)[0], (*point)[1]};
    } else if (point) {
      facing->fault("must be [x, y], beside a range of rpy_deg");
    }
  }
  map->finish();
  return variation;
}

/// Reads every entry of a map of named things.
template <typename T, typename Read>
void readNamed(YamlMap& cell, const char* key, std::size_t most, std::vector<T>& out, Read read) {
  const YamlValue* value = cell.require(key);
  auto map = value == nullptr ? std::nullopt : value->map();
  if (!map) return;
  if (map->all().size() > most) {
    return value->fault("has " + std::to_string(map->all().size()) + " entries, more than " +
                        std::to_string(most));
  }
  for (const auto& [name, entry] : map->all()) {
    if (entry.checkName(name)) out.push_back(read(name, entry));
  }
}

}  // namespace

CellDescription readCell(const YamlNode& document, YamlReport& report) {
  CellDescription cell;
  auto map = YamlValue(document, "", report).map();
  if (!map) return cell;
  if (const YamlValue* version = map->require("version")) version->integer(1, 1);
  if (const YamlValue* name = map->require("name")) cell.name = name->name().value_or("");
  readNamed(*map, "robots", bounds::kRobots, cell.robots, readRobot);
  readNamed(*map, "objects", bounds::kObjects, cell.objects, readObject);
  readNamed(*map, "tasks", bounds::kCells, cell.tasks, readTask);
  if (const YamlValue* vary = map->find("vary")) {
    if (auto entries = vary->map()) {
      std::size_t values = 0;
      for (const auto& [path, value] : entries->all()) {
        cell.variations.push_back(readVariation(path, value));
        values += std::max<std::size_t>(cell.variations.back().choices.size(), 2);
      }
      if (values > kMaxVariations) {
        vary->fault("has more than " + std::to_string(kMaxVariations) + " ends and choices");
      }
    }
  }
  map->finish();
  return cell;
}

}  // namespace handover
