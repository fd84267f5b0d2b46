// SPDX-License-Identifier: Apache-2.0
#include "verify/plan_file.hpp"

#include "verify/find_by_name.hpp"
#include "verify/input_file.hpp"
#include "verify/unreadable.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
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
constexpr std::size_t kMaxStages = 128;
constexpr std::size_t kMaxHolders = 16;
constexpr std::size_t kMaxSamples = 200'000;
constexpr std::size_t kMaxPairs = 10'000;
constexpr std::size_t kMaxParts = 4096;
constexpr int kMaxCompoundDepth = 4;
constexpr double kMaxCoordinate = 1e9;  // [m], [rad] or [s]: slow arms take weeks
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

std::string bodyName(const Field& field) {
  auto result = field.name();
  if (result.find('/') != std::string::npos) field.fail("must not hold a slash");
  return result;
}

ClaimedLimits limitsOf(const Field& entry) {
  const auto v = entry.array(5);
  if (v.size() != 5) entry.fail("expected [lower, upper, velocity, acceleration, jerk]");
  ClaimedLimits result;
  if (!v[0].value().is_null()) result.lower = v[0].number();
  if (!v[1].value().is_null()) result.upper = v[1].number();
  if (result.lower && result.upper && *result.lower > *result.upper) {
    entry.fail("lower above upper");
  }
  result.velocity = v[2].number();
  result.acceleration = v[3].number();
  result.jerk = v[4].number();
  if (result.velocity < 0 || result.acceleration < 0 || result.jerk < 0) {
    entry.fail("negative limit");
  }
  return result;
}

PlanRobot robot(const Field& field) {
  PlanRobot result;
  result.name = bodyName(field.at("name"));
  result.urdf = relativePath(field.at("urdf"));
  result.urdf_sha256 = hexDigits(field.at("urdf_sha256"), 64);
  result.srdf = relativePath(field.at("srdf"));
  result.yaml = relativePath(field.at("yaml"));
  result.yaml_sha256 = hexDigits(field.at("yaml_sha256"), 64);
  result.X_WB = pose(field.at("X_WB"));
  const Field q_start = field.at("q_start");
  if (q_start.object().size() > kMaxJoints) q_start.fail("too many joints");
  for (const auto& [joint, value] : q_start.object().items()) {
    result.q_start[joint] = Field(value, q_start.pointer() + "/" + joint).number();
  }
  const Field limits = field.at("limits");
  if (limits.object().size() > kMaxJoints) limits.fail("too many joints");
  for (const auto& [joint, value] : limits.object().items()) {
    result.limits[joint] = limitsOf(Field(value, limits.pointer() + "/" + joint));
  }
  result.resting = namePairs(field.at("resting"));
  return result;
}

PlanObject object(const Field& field) {
  PlanObject result;
  result.name = bodyName(field.at("name"));
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

Rest rest(const Field& field) {
  if (field.value().is_string()) {
    if (field.text() != "none") field.fail("expected object names or \"none\"");
    return std::nullopt;
  }
  return names(field, kMaxObjects);
}

PlanStart start(const Field& field) {
  PlanStart result;
  result.X_WO = pose(field.at("X_WO"));
  const Field held = field.at("held_by");
  if (!held.value().is_null()) {
    const std::string name = held.name();
    const auto slash = name.find('/');
    if (slash == std::string::npos) held.fail("expected robot/arm");
    result.held_by = NamePair(name.substr(0, slash), name.substr(slash + 1));
  }
  result.rest = rest(field.at("rest"));
  return result;
}

PlanGoal goal(const Field& field) {
  PlanGoal result;
  result.X_WO = pose(field.at("X_WO"));
  const std::string end = field.at("end").text();
  if (end != "release" && end != "hold") field.at("end").fail("expected release or hold");
  result.release = end == "release";
  result.rest = rest(field.at("rest"));
  return result;
}

Eigen::Vector3d direction(const Field& field) {
  const Eigen::Vector3d axis = vector3(field);
  if (axis.norm() < 1e-6) field.fail("axis of no length");
  return axis.normalized();
}

std::optional<UprightRule> upright(const Field& field) {
  if (field.value().is_null()) return std::nullopt;
  const UprightRule result{direction(field.at("axis")), field.at("within_deg").number()};
  if (result.within_deg < 0) field.at("within_deg").fail("must not be negative");
  return result;
}

PlanHolder holder(const Field& field) {
  PlanHolder result;
  result.robot = field.at("robot").name();
  result.arm = field.at("arm").name();
  result.tool_link = field.at("tool_link").name();
  const std::string gripper = field.at("gripper").text();
  const Field hand = field.at("hand");
  if (gripper == "fingers") {
    result.palm = hand.at("palm").name();
    result.fingers = names(hand.at("fingers"), kMaxJoints);
    if (result.fingers.empty()) hand.at("fingers").fail("empty");
  } else if (gripper == "suction") {
    result.suction = true;
    result.cup_link = hand.at("cup_link").name();
    result.axis = direction(hand.at("axis"));
    hand.at("radius").positive();
  } else {
    field.at("gripper").fail("expected fingers or suction");
  }
  result.X_OT = pose(field.at("X_OT"));
  result.take = field.at("dexterity").at("take").number();
  result.give = field.at("dexterity").at("give").number();
  return result;
}

int wholeNumber(const Field& field, std::size_t below) {
  if (!field.value().is_number_integer() || field.value() < 0) {
    field.fail("expected a whole number from 0");
  }
  if (field.value() >= below) field.fail("expected less than " + std::to_string(below));
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

PlanStage stage(const Field& field, std::size_t stages, std::size_t holders) {
  PlanStage result;
  result.index = wholeNumber(field.at("index"), 1'000'000);
  result.holder = wholeNumber(field.at("holder"), holders);
  result.action = field.at("action").name();
  result.robot = field.at("robot").name();
  result.joints = names(field.at("joints"), kMaxJoints);
  std::set<std::string> seen;
  for (const std::string& joint : result.joints) {
    if (!seen.insert(joint).second) field.at("joints").fail("\"" + joint + "\" named twice");
  }
  result.start = field.at("start").number();
  result.t = numbers(field.at("t"), kMaxSamples);
  result.q = rows(field.at("q"), result.t.size(), result.joints.size());
  result.qd = rows(field.at("qd"), result.t.size(), result.joints.size());
  result.qdd = rows(field.at("qdd"), result.t.size(), result.joints.size());
  for (const Field& hold : field.at("holding").array(kMaxObjects)) {
    result.holding.push_back({hold.at("object").name(), hold.at("robot").name(),
                              hold.at("link").name(), pose(hold.at("X_LO"))});
  }
  result.may_touch = namePairs(field.at("may_touch"));
  for (const Field& edge : field.at("after").array(kMaxPairs)) {
    const auto entries = edge.array(2);
    if (entries.size() != 2) edge.fail("expected [stage index, progress]");
    result.after.push_back({wholeNumber(entries[0], stages), entries[1].number()});
  }
  return result;
}

ClearanceClaim clearanceClaim(const Field& field) {
  ClearanceClaim result;
  result.between = field.at("between").text();
  if (result.between != "furniture" && result.between != "robots" && result.between != "object") {
    field.at("between").fail("expected furniture, robots or object");
  }
  result.least = field.at("least_m").number();
  const Field stage = field.at("stage");
  if (!stage.value().is_null()) result.stage = wholeNumber(stage, kMaxStages);
  const Field pair = field.at("pair");
  if (!pair.value().is_null()) {
    const auto both = names(pair, 2);
    if (both.size() != 2) pair.fail("expected two names");
    result.pair = NamePair(both[0], both[1]);
  }
  return result;
}

std::optional<QualityClaim> quality(const Field& field, std::size_t holders) {
  if (field.value().is_null()) return std::nullopt;
  QualityClaim result;
  result.duration = field.at("duration_s").number();
  result.bound = field.at("bound_s").number();
  result.object = field.at("object_s").number();
  const Field idle = field.at("idle_s");
  for (const auto& [robot, value] : idle.object().items()) {
    result.idle[robot] = Field(value, idle.pointer() + "/" + robot).number();
  }
  for (const Field& entry : field.at("clearance").array(kMaxStages)) {
    result.clearance.push_back(clearanceClaim(entry));
  }
  result.tilt_deg = field.at("tilt_deg").number();
  const auto turn = numbers(field.at("object_turn_deg"), 2);
  if (turn.size() != 2) field.at("object_turn_deg").fail("expected two numbers");
  result.turn_deg = turn[0];
  result.least_turn_deg = turn[1];
  const Field margin = field.at("limit_margin");
  if (!margin.value().is_null()) result.limit_margin = margin.number();
  for (const Field& grip : field.at("grip").array(kMaxHolders)) {
    wholeNumber(grip.at("holder"), holders);
    grip.at("quality").number();
    grip.at("of_best").number();
  }
  result.jerk_share = field.at("jerk_share").number();
  field.at("cost").number();
  const Field terms = field.at("terms");
  for (const auto& [name, value] : terms.object().items()) {
    Field(value, terms.pointer() + "/" + name).number();
  }
  return result;
}

void requireRobot(const Plan& plan, const std::string& name, const std::string& pointer) {
  if (plan.findRobot(name) < 0) throw Unreadable(pointer, "unknown robot \"" + name + "\"");
}

void requireObject(const Plan& plan, const std::string& name, const std::string& pointer) {
  if (plan.findObject(name) < 0) throw Unreadable(pointer, "unknown object \"" + name + "\"");
}

void requireRest(const Plan& plan, const Rest& rest, const std::string& pointer) {
  if (!rest) return;
  for (const std::string& name : *rest) requireObject(plan, name, pointer);
}

std::string entry(const std::string& list, std::size_t index) {
  return list + "/" + std::to_string(index);
}

void checkSceneNames(const Plan& plan) {
  std::set<std::string> robots, objects;
  for (std::size_t i = 0; i < plan.robots.size(); ++i) {
    const std::string at = entry("/scene/robots", i);
    if (!robots.insert(plan.robots[i].name).second) throw Unreadable(at + "/name", "used twice");
    for (const auto& [link, name] : plan.robots[i].resting) {
      requireObject(plan, name, at + "/resting");
    }
  }
  for (std::size_t i = 0; i < plan.objects.size(); ++i) {
    const PlanObject& object = plan.objects[i];
    const std::string at = entry("/scene/objects", i);
    if (!objects.insert(object.name).second) throw Unreadable(at + "/name", "used twice");
    for (const std::string& name : object.resting) requireObject(plan, name, at + "/resting");
    if (object.attached_to) {
      requireRobot(plan, object.attached_to->robot, at + "/attached_to/robot");
    }
  }
  requireObject(plan, plan.object, "/scene/object");
  if (plan.start.held_by) requireRobot(plan, plan.start.held_by->first, "/scene/start/held_by");
  requireRest(plan, plan.start.rest, "/scene/start/rest");
  requireRest(plan, plan.goal.rest, "/scene/goal/rest");
}

/// Names of robots and objects must be ones that the file defines; links and joints are looked up
/// when the URDF is there.
void checkNames(const Plan& plan) {
  checkSceneNames(plan);
  for (std::size_t i = 0; i < plan.holders.size(); ++i) {
    requireRobot(plan, plan.holders[i].robot, entry("/plan/holders", i) + "/robot");
  }
  for (std::size_t i = 0; i < plan.stages.size(); ++i) {
    const std::string at = entry("/plan/stages", i);
    requireRobot(plan, plan.stages[i].robot, at + "/robot");
    for (const Hold& hold : plan.stages[i].holding) {
      requireObject(plan, hold.object, at + "/holding");
      requireRobot(plan, hold.robot, at + "/holding");
    }
  }
  if (!plan.quality) return;
  for (const auto& [robot, seconds] : plan.quality->idle) {
    requireRobot(plan, robot, "/quality/idle_s");
  }
}

/// A byte of a text as editors count: from 1.
std::string placeOf(std::string_view text, std::size_t offset) {
  const std::string_view before = text.substr(0, offset);
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const std::size_t begin = before.rfind('\n');
  const std::size_t column = begin == before.npos ? offset + 1 : offset - begin;
  return "line " + std::to_string(line) + ", column " + std::to_string(column);
}

/// What may not stand at a byte of a text that is no JSON, in plain words.
std::string unexpectedAt(std::string_view text, std::size_t offset) {
  if (offset >= text.size()) return "the text ends there";
  const auto byte = static_cast<unsigned char>(text[offset]);
  if (byte > 0x20 && byte < 0x7f) return std::string("unexpected '") + text[offset] + "'";
  char hex[8];
  std::snprintf(hex, sizeof hex, "0x%02x", byte);
  return std::string("unexpected byte ") + hex;
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
  } catch (const Json::parse_error& error) {
    const std::size_t offset = std::max<std::size_t>(error.byte, 1) - 1;
    throw Unreadable(placeOf(text, offset), "not JSON: " + unexpectedAt(text, offset));
  } catch (const Json::out_of_range&) {
    throw Unreadable("", "not JSON: a number beyond what a double holds");
  }
}

void readScene(const Field& field, Plan& plan) {
  field.at("cell").text();
  field.at("task").text();
  if (!field.at("seed").value().is_number_unsigned()) {
    field.at("seed").fail("expected a whole number from 0");
  }
  field.at("scene_hash").name();
  plan.object = field.at("object").name();
  for (const Field& entry : field.at("robots").array(kMaxRobots)) {
    plan.robots.push_back(robot(entry));
  }
  for (const Field& entry : field.at("objects").array(kMaxObjects)) {
    plan.objects.push_back(object(entry));
  }
  plan.start = start(field.at("start"));
  plan.goal = goal(field.at("goal"));
  plan.upright = upright(field.at("upright"));
}

void readMotions(const Field& field, Plan& plan) {
  for (const Field& entry : field.at("holders").array(kMaxHolders)) {
    plan.holders.push_back(holder(entry));
  }
  if (plan.holders.empty()) field.at("holders").fail("empty");
  for (const Field& entry : field.at("handovers").array(kMaxHolders)) {
    plan.handovers.push_back(pose(entry));
  }
  const auto stages = field.at("stages").array(kMaxStages);
  for (const Field& entry : stages) {
    plan.stages.push_back(stage(entry, stages.size(), plan.holders.size()));
  }
  plan.slack = field.at("slack_s").number();
  if (plan.slack < 0) field.at("slack_s").fail("must not be negative");
}

}  // namespace

int Plan::findRobot(std::string_view name) const { return findByName(robots, name); }

int Plan::findObject(std::string_view name) const { return findByName(objects, name); }

Plan parsePlan(std::string_view text) {
  const Json json = parseJson(text);
  const Field file(json, "");
  const std::string format = file.at("format").text();
  if (format != "handover-plan/2") file.at("format").fail("unknown format \"" + format + "\"");
  if (!file.at("complete").value().is_boolean()) file.at("complete").fail("expected true or false");
  file.at("timing").object();
  file.at("funnel").object();
  if (const Field explanation = file.at("explanation"); !explanation.value().is_null()) {
    explanation.object();
  }
  Plan plan;
  readScene(file.at("scene"), plan);
  if (file.at("plan").value().is_null()) file.at("plan").fail("the file has no plan");
  readMotions(file.at("plan"), plan);
  plan.quality = quality(file.at("quality"), plan.holders.size());
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
