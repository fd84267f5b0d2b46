// SPDX-License-Identifier: Apache-2.0
#include "verify/plan_file.hpp"

#include "verify/find_by_name.hpp"
#include "verify/input_file.hpp"
#include "verify/unreadable.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>

namespace handover::verify {
namespace {

using Json = nlohmann::json;

// Bounds far above any plan of ours: they keep a hostile file from taking the machine's memory.
constexpr std::uint64_t kMaxFileBytes = 256u << 20;
constexpr std::size_t kMaxNameLength = 256;
constexpr std::size_t kMaxRobots = 16;
constexpr std::size_t kMaxObjects = 1000;
constexpr std::size_t kMaxJoints = 256;
constexpr std::size_t kMaxStages = 64;
constexpr std::size_t kMaxSamples = 200'000;
constexpr std::size_t kMaxPairs = 10'000;
constexpr std::size_t kMaxParts = 4096;
constexpr int kMaxCompoundDepth = 4;
constexpr double kMaxCoordinate = 1e6;  // [m], [rad] or [s]
constexpr double kUnitQuaternionTolerance = 1e-3;

/// A value together with its place in the file.
class Field {
 public:
  Field(const Json& value, std::string pointer) : value_(value), pointer_(std::move(pointer)) {}

  const std::string& pointer() const { return pointer_; }

  const Json& value() const { return value_; }

  [[noreturn]] void fail(const std::string& what) const { throw Unreadable(pointer_, what); }

  Field at(const char* key) const {
    object();
    const auto found = value_.find(key);
    if (found == value_.end()) throw Unreadable(pointer_ + "/" + key, "missing");
    return {*found, pointer_ + "/" + key};
  }

  const Json& object() const {
    if (!value_.is_object()) fail("expected an object");
    return value_;
  }

  std::vector<Field> array(std::size_t most) const {
    if (!value_.is_array()) fail("expected an array");
    if (value_.size() > most) fail("more than " + std::to_string(most) + " entries");
    std::vector<Field> entries;
    entries.reserve(value_.size());
    for (std::size_t i = 0; i < value_.size(); ++i) {
      entries.emplace_back(value_[i], pointer_ + "/" + std::to_string(i));
    }
    return entries;
  }

  std::string text(std::size_t longest = kMaxNameLength) const {
    if (!value_.is_string()) fail("expected a string");
    auto result = value_.get<std::string>();
    if (result.size() > longest) fail("longer than " + std::to_string(longest) + " characters");
    return result;
  }

  std::string name() const {
    auto result = text();
    if (result.empty()) fail("empty name");
    return result;
  }

  double number() const {
    if (!value_.is_number()) fail("expected a number");
    const double result = value_.get<double>();
    if (!std::isfinite(result)) fail("not finite");
    if (std::abs(result) > kMaxCoordinate) fail("out of any sensible range");
    return result;
  }

  double positive() const {
    const double result = number();
    if (result <= 0) fail("must be positive");
    return result;
  }

 private:
  const Json& value_;
  std::string pointer_;
};

std::vector<double> numbers(const Field& field, std::size_t most) {
  const Json& value = field.value();
  if (!value.is_array()) field.fail("expected an array");
  if (value.size() > most) field.fail("more than " + std::to_string(most) + " entries");
  std::vector<double> result;
  result.reserve(value.size());
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (!value[i].is_number_float() && !value[i].is_number_integer()) {
      Field(value[i], field.pointer() + "/" + std::to_string(i)).fail("expected a number");
    }
    const double number = value[i].get<double>();
    if (!(std::abs(number) <= kMaxCoordinate)) {
      Field(value[i], field.pointer() + "/" + std::to_string(i)).fail("out of any sensible range");
    }
    result.push_back(number);
  }
  return result;
}

Eigen::Vector3d vector3(const Field& field) {
  const auto entries = numbers(field, 3);
  if (entries.size() != 3) field.fail("expected three numbers");
  return {entries[0], entries[1], entries[2]};
}

Pose pose(const Field& field) {
  Pose X = Pose::Identity();
  X.translation() = vector3(field.at("xyz"));
  const Field quaternion = field.at("quat_wxyz");
  const auto w = numbers(quaternion, 4);
  if (w.size() != 4) quaternion.fail("expected four numbers");
  const Eigen::Quaterniond quat(w[0], w[1], w[2], w[3]);
  if (std::abs(quat.norm() - 1) > kUnitQuaternionTolerance)
    quaternion.fail("not a unit quaternion");
  X.linear() = quat.normalized().toRotationMatrix();
  return X;
}

std::vector<std::string> names(const Field& field, std::size_t most) {
  std::vector<std::string> result;
  for (const Field& entry : field.array(most)) result.push_back(entry.name());
  return result;
}

std::vector<NamePair> namePairs(const Field& field) {
  std::vector<NamePair> result;
  for (const Field& entry : field.array(kMaxPairs)) {
    const auto pair = names(entry, 2);
    if (pair.size() != 2) entry.fail("expected two names");
    result.emplace_back(pair[0], pair[1]);
  }
  return result;
}

/// Files are named below the root and never outside it.
std::string relativePath(const Field& field) {
  auto text = field.text(4096);
  const std::filesystem::path path(text);
  if (text.empty()) field.fail("empty path");
  if (path.is_absolute()) field.fail("must be relative to the root");
  for (const auto& part : path) {
    if (part == "..") field.fail("must not leave the root");
  }
  return text;
}

Geometry geometry(const Field& field, int depth, std::size_t& parts) {
  if (++parts > kMaxParts) field.fail("too many parts");
  const std::string type = field.at("type").text();
  if (type == "box") {
    const Eigen::Vector3d size = vector3(field.at("size"));
    if (size.minCoeff() <= 0) field.at("size").fail("must be positive");
    return Box{size};
  }
  if (type == "sphere") return Sphere{field.at("radius").positive()};
  if (type == "cylinder") {
    return Cylinder{field.at("radius").positive(), field.at("length").positive()};
  }
  if (type == "mesh") {
    const Eigen::Vector3d scale = vector3(field.at("scale"));
    if (scale.cwiseAbs().minCoeff() <= 0) field.at("scale").fail("must not be zero");
    return MeshFile{relativePath(field.at("path")), scale};
  }
  if (type == "compound") {
    if (depth >= kMaxCompoundDepth) field.fail("compounds nested too deeply");
    Compound compound;
    for (const Field& part : field.at("parts").array(kMaxParts)) {
      compound.parts.push_back(
          {pose(part.at("X_OS")), geometry(part.at("geometry"), depth + 1, parts)});
    }
    if (compound.parts.empty()) field.at("parts").fail("empty");
    return compound;
  }
  field.at("type").fail("unknown geometry \"" + type + "\"");
}

std::string hexDigits(const Field& field, std::size_t length) {
  auto text = field.text();
  const bool hex = std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
  });
  if (!hex || (length != 0 && text.size() != length)) {
    field.fail("expected " + (length ? std::to_string(length) + " " : std::string()) +
               "lower-case hex digits");
  }
  return text;
}

PlanRobot robot(const Field& field) {
  PlanRobot result;
  result.name = field.at("name").name();
  if (result.name.find('/') != std::string::npos) field.at("name").fail("must not hold a slash");
  result.urdf = relativePath(field.at("urdf"));
  result.urdf_sha256 = hexDigits(field.at("urdf_sha256"), 64);
  result.srdf = relativePath(field.at("srdf"));
  result.X_WB = pose(field.at("X_WB"));
  const Field q_start = field.at("q_start");
  if (q_start.object().size() > kMaxJoints) q_start.fail("too many joints");
  for (const auto& [joint, value] : q_start.object().items()) {
    result.q_start[joint] = Field(value, q_start.pointer() + "/" + joint).number();
  }
  const Field limits = field.at("limits");
  if (limits.object().size() > kMaxJoints) limits.fail("too many joints");
  for (const auto& [joint, value] : limits.object().items()) {
    const Field entry(value, limits.pointer() + "/" + joint);
    const auto v = numbers(entry, 4);
    if (v.size() != 4) entry.fail("expected [lower, upper, velocity, acceleration]");
    if (v[0] > v[1]) entry.fail("lower above upper");
    if (v[2] < 0 || v[3] < 0) entry.fail("negative limit");
    result.limits[joint] = {v[0], v[1], v[2], v[3]};
  }
  result.resting = namePairs(field.at("resting"));
  return result;
}

PlanObject object(const Field& field) {
  PlanObject result;
  result.name = field.at("name").name();
  if (result.name.find('/') != std::string::npos) field.at("name").fail("must not hold a slash");
  std::size_t parts = 0;
  result.geometry = geometry(field.at("geometry"), 0, parts);
  result.X_WO = pose(field.at("X_WO"));
  const Field attached = field.at("attached_to");
  if (!attached.value().is_null()) {
    result.attached_to =
        Attachment{attached.at("robot").name(), attached.at("link").name(),
                   pose(attached.at("X_LO")), names(attached.at("touch_links"), kMaxPairs)};
  }
  result.resting = names(field.at("resting"), kMaxObjects);
  return result;
}

int wholeNumber(const Field& field) {
  if (!field.value().is_number_integer() || field.value() > static_cast<std::int64_t>(1'000'000) ||
      field.value() < 0) {
    field.fail("expected a whole number from 0");
  }
  return field.value().get<int>();
}

std::vector<std::vector<double>> rows(const Field& field, std::size_t samples, std::size_t joints) {
  std::vector<std::vector<double>> result;
  const auto entries = field.array(kMaxSamples);
  if (entries.size() != samples) {
    field.fail(std::to_string(entries.size()) + " rows for " + std::to_string(samples) +
               " samples");
  }
  for (const Field& entry : entries) {
    result.push_back(numbers(entry, kMaxJoints));
    if (result.back().size() != joints) {
      entry.fail(std::to_string(result.back().size()) + " values for " + std::to_string(joints) +
                 " joints");
    }
  }
  return result;
}

PlanEvent stage(const Field& field) {
  PlanEvent result;
  result.index = wholeNumber(field.at("index"));
  result.kind = field.at("kind").name();
  result.robot = field.at("robot").name();
  result.joints = names(field.at("joints"), kMaxJoints);
  std::set<std::string> seen;
  for (const std::string& joint : result.joints) {
    if (!seen.insert(joint).second) field.at("joints").fail("\"" + joint + "\" named twice");
  }
  if (result.joints.empty()) field.at("joints").fail("empty");
  result.start = field.at("start").number();
  result.t = numbers(field.at("t"), kMaxSamples);
  if (result.t.empty()) field.at("t").fail("empty");
  result.q = rows(field.at("q"), result.t.size(), result.joints.size());
  result.qd = rows(field.at("qd"), result.t.size(), result.joints.size());
  for (const Field& hold : field.at("holding").array(kMaxObjects)) {
    result.holding.push_back({hold.at("object").name(), hold.at("robot").name(),
                              hold.at("link").name(), pose(hold.at("X_LO"))});
  }
  result.may_touch = namePairs(field.at("may_touch"));
  return result;
}

void requireRobot(const Plan& plan, const std::string& name, const std::string& pointer) {
  if (plan.findRobot(name) < 0) throw Unreadable(pointer, "unknown robot \"" + name + "\"");
}

void requireObject(const Plan& plan, const std::string& name, const std::string& pointer) {
  if (plan.findObject(name) < 0) throw Unreadable(pointer, "unknown object \"" + name + "\"");
}

/// Names of robots and objects must be ones that the file defines; links and joints are looked up
/// when the URDF is there.
void checkNames(const Plan& plan) {
  const std::string root = "/plan";
  std::set<std::string> robots, objects;
  for (std::size_t i = 0; i < plan.robots.size(); ++i) {
    const std::string at = root + "/robots/" + std::to_string(i);
    if (!robots.insert(plan.robots[i].name).second) throw Unreadable(at + "/name", "used twice");
    for (const auto& [link, name] : plan.robots[i].resting) {
      requireObject(plan, name, at + "/resting");
    }
  }
  for (std::size_t i = 0; i < plan.objects.size(); ++i) {
    const PlanObject& entry = plan.objects[i];
    const std::string at = root + "/objects/" + std::to_string(i);
    if (!objects.insert(entry.name).second) throw Unreadable(at + "/name", "used twice");
    for (const std::string& name : entry.resting) requireObject(plan, name, at + "/resting");
    if (entry.attached_to) requireRobot(plan, entry.attached_to->robot, at + "/attached_to/robot");
  }
  requireObject(plan, plan.object, root + "/object");
  requireRobot(plan, plan.giver, root + "/giver");
  requireRobot(plan, plan.receiver, root + "/receiver");
  for (std::size_t i = 0; i < plan.stages.size(); ++i) {
    const std::string at = root + "/stages/" + std::to_string(i);
    requireRobot(plan, plan.stages[i].robot, at + "/robot");
    for (const Hold& hold : plan.stages[i].holding) {
      requireObject(plan, hold.object, at + "/holding");
      requireRobot(plan, hold.robot, at + "/holding");
    }
  }
}

/// Parses, and refuses a key given twice: readers differ in which of the two they take.
Json parseJson(std::string_view text) {
  std::vector<std::set<std::string>> keys;
  const auto callback = [&keys](int, Json::parse_event_t event, Json& parsed) {
    if (event == Json::parse_event_t::object_start) keys.emplace_back();
    if (event == Json::parse_event_t::object_end) keys.pop_back();
    if (event == Json::parse_event_t::key) {
      const auto key = parsed.get<std::string>();
      if (!keys.back().insert(key).second) throw Unreadable("", "key \"" + key + "\" given twice");
    }
    return true;
  };
  try {
    return Json::parse(text.begin(), text.end(), callback);
  } catch (const Json::exception& error) {
    throw Unreadable("", std::string("not JSON: ") + error.what());
  }
}

}  // namespace

int Plan::findRobot(std::string_view name) const { return findByName(robots, name); }

int Plan::findObject(std::string_view name) const { return findByName(objects, name); }

Plan parsePlan(std::string_view text) {
  const Json json = parseJson(text);
  const Field file(json, "");
  const std::string format = file.at("format").text();
  if (format != "handover-plan/1") file.at("format").fail("unknown format \"" + format + "\"");
  if (!file.at("complete").value().is_boolean()) file.at("complete").fail("expected true or false");
  file.at("timing").object();
  file.at("funnel").object();
  if (const Field text_field = file.at("explanation"); !text_field.value().is_null()) {
    text_field.object();
  }

  const Field field = file.at("plan");
  Plan plan;
  plan.cell = field.at("cell").text();
  plan.task = field.at("task").text();
  if (!field.at("seed").value().is_number_unsigned()) {
    field.at("seed").fail("expected a whole number from 0");
  }
  hexDigits(field.at("scene_hash"), 0);
  plan.object = field.at("object").name();
  plan.giver = field.at("giver").name();
  plan.receiver = field.at("receiver").name();
  plan.giver_arm = field.at("giver_arm").name();
  plan.receiver_arm = field.at("receiver_arm").name();
  plan.giver_tool_link = field.at("giver_tool_link").name();
  plan.receiver_tool_link = field.at("receiver_tool_link").name();
  for (const Field& entry : field.at("robots").array(kMaxRobots)) {
    plan.robots.push_back(robot(entry));
  }
  for (const Field& entry : field.at("objects").array(kMaxObjects)) {
    plan.objects.push_back(object(entry));
  }
  plan.X_WO_start = pose(field.at("X_WO_start"));
  plan.X_WO_goal = pose(field.at("X_WO_goal"));
  plan.X_WO_handover = pose(field.at("X_WO_handover"));
  plan.X_OT_giver = pose(field.at("X_OT_giver"));
  plan.X_OT_receiver = pose(field.at("X_OT_receiver"));
  const Field dexterity = field.at("dexterity");
  plan.receiver_place = dexterity.at("receiver_place").number();
  plan.receiver_handover = dexterity.at("receiver_handover").number();
  plan.giver_pick = dexterity.at("giver_pick").number();
  plan.giver_handover = dexterity.at("giver_handover").number();
  for (const Field& entry : field.at("stages").array(kMaxStages)) {
    plan.stages.push_back(stage(entry));
  }
  checkNames(plan);
  return plan;
}

std::string readPlanText(const std::filesystem::path& file) {
  return readFile(file, kMaxFileBytes);
}

Plan readPlan(const std::filesystem::path& file) {
  const std::string text = readPlanText(file);
  try {
    return parsePlan(text);
  } catch (const Unreadable& fault) {
    throw Unreadable(file.string(), fault.what());
  }
}

}  // namespace handover::verify
