// SPDX-License-Identifier: Apache-2.0
#include "plan_file/plan_json.hpp"

#include <handover/client/plan_file.hpp>
#include <handover/common/check.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

namespace handover::client {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::uintmax_t kMaxBytes = 256u << 20;

/// A value of the file and where it stands.
class Node {
 public:
  Node(const Json& json, std::string where) : json_(json), where_(std::move(where)) {}

  [[noreturn]] void fail(const std::string& what) const { throw PlanFileError(where_, what); }

  bool null() const { return json_.is_null(); }

  bool isText() const { return json_.is_string(); }

  /// Null where it is missing too.
  Node member(const std::string& key) const {
    static const Json kNothing;
    if (!json_.is_object()) fail("must be an object");
    const auto found = json_.find(key);
    return {found == json_.end() ? kNothing : *found, where_ + "/" + key};
  }

  Node operator[](const std::string& key) const {
    if (json_.is_object() && !json_.contains(key)) {
      throw PlanFileError(where_ + "/" + key, "is missing");
    }
    return member(key);
  }

  std::string text() const {
    if (!json_.is_string()) fail("must be a text");
    return json_.get<std::string>();
  }

  double number() const {
    if (!json_.is_number()) fail("must be a number");
    return json_.get<double>();
  }

  bool truth() const {
    if (!json_.is_boolean()) fail("must be true or false");
    return json_.get<bool>();
  }

  template <typename Whole>
  Whole whole() const {
    if (!json_.is_number_unsigned() ||
        json_.get<std::uint64_t>() > std::numeric_limits<Whole>::max()) {
      fail("must be a whole number, 0 or more");
    }
    return json_.get<Whole>();
  }

  template <typename Enum>
  Enum enumerator() const {
    const auto value = fromString<Enum>(text());
    if (!value) fail("unknown name '" + text() + "'");
    return *value;
  }

  template <typename Each>
  auto list(Each each) const {
    if (!json_.is_array()) fail("must be a list");
    std::vector<decltype(each(*this))> all;
    all.reserve(json_.size());
    for (std::size_t i = 0; i < json_.size(); ++i) {
      all.push_back(each(Node(json_[i], where_ + "/" + std::to_string(i))));
    }
    return all;
  }

  /// Values by key, in the file's order.
  template <typename Each>
  auto entries(Each each) const {
    if (!json_.is_object()) fail("must be an object");
    std::vector<std::pair<std::string, decltype(each(*this))>> all;
    for (auto it = json_.begin(); it != json_.end(); ++it) {
      all.emplace_back(it.key(), each(Node(*it, where_ + "/" + it.key())));
    }
    return all;
  }

  /// A list of `size` entries.
  std::vector<Node> tuple(std::size_t size) const {
    auto all = list([](const Node& node) { return node; });
    if (all.size() != size) fail("must have " + std::to_string(size) + " entries");
    return all;
  }

  template <std::size_t kSize>
  std::array<double, kSize> numbers() const {
    std::array<double, kSize> values{};
    const auto nodes = tuple(kSize);
    for (std::size_t i = 0; i < kSize; ++i) values[i] = nodes[i].number();
    return values;
  }

  /// Rows of a million numbers: no text for each. A number too large for a double is infinite.
  std::vector<double> row() const {
    if (!json_.is_array()) fail("must be a list");
    std::vector<double> values;
    values.reserve(json_.size());
    for (const Json& item : json_) {
      if (!item.is_number() || !std::isfinite(item.get<double>())) {
        fail("must be a list of finite numbers");
      }
      values.push_back(item.get<double>());
    }
    return values;
  }

 private:
  const Json& json_;
  std::string where_;
};

std::string text(const Node& node) { return node.text(); }

double number(const Node& node) { return node.number(); }

PoseValue pose(const Node& node) {
  return {node["xyz"].numbers<3>(), node["quat_wxyz"].numbers<4>()};
}

NamePair pair(const Node& node) {
  const auto names = node.tuple(2);
  return {names[0].text(), names[1].text()};
}

/// The names of two bodies, or null.
NamePair pairOrNone(const Node& node) { return node.null() ? NamePair{} : pair(node); }

ArmName arm(const Node& node) {
  const auto name = holderOf(node.text());
  if (!name) node.fail("must be ROBOT/ARM");
  return *name;
}

Geometry primitive(const Node& node, const std::string& type) {
  if (type == "box") return BoxGeometry{node["size"].numbers<3>()};
  if (type == "sphere") return SphereGeometry{node["radius"].number()};
  if (type == "cylinder") return CylinderGeometry{node["radius"].number(), node["length"].number()};
  if (type == "mesh") return MeshGeometry{node["path"].text(), node["scale"].numbers<3>()};
  node.fail("unknown geometry '" + type + "'");
}

Geometry geometry(const Node& node) {
  const std::string type = node["type"].text();
  if (type != "compound") return primitive(node, type);
  return CompoundGeometry{node["parts"].list([](const Node& part) {
    const Node shape = part["geometry"];
    return GeometryPart{pose(part["X_OS"]), primitive(shape, shape["type"].text())};
  })};
}

JointLimits limits(const Node& node) {
  const auto values = node.tuple(5);
  JointLimits out;
  const auto bound = [](const Node& value) {
    return value.null() ? std::nullopt : std::optional(value.number());
  };
  out.lower = bound(values[0]);
  out.upper = bound(values[1]);
  out.velocity = values[2].number();
  out.acceleration = values[3].number();
  out.jerk = values[4].number();
  return out;
}

RobotSnapshot robot(const Node& node) {
  RobotSnapshot out;
  out.name = node["name"].text();
  out.urdf = node["urdf"].text();
  out.urdf_sha256 = node["urdf_sha256"].text();
  out.srdf = node["srdf"].text();
  out.yaml = node["yaml"].text();
  out.yaml_sha256 = node["yaml_sha256"].text();
  out.X_WB = pose(node["X_WB"]);
  out.q_start = node["q_start"].entries(number);
  out.limits = node["limits"].entries(limits);
  out.resting = node["resting"].list(pair);
  return out;
}

ObjectSnapshot object(const Node& node) {
  ObjectSnapshot out;
  out.name = node["name"].text();
  out.geometry = geometry(node["geometry"]);
  out.X_WO = pose(node["X_WO"]);
  if (const Node at = node["attached_to"]; !at.null()) {
    out.attached_to = AttachmentSnapshot{at["robot"].text(), at["link"].text(), pose(at["X_LO"]),
                                         at["touch_links"].list(text)};
  }
  out.resting = node["resting"].list(text);
  return out;
}

RestSnapshot rest(const Node& node) {
  if (!node.isText()) return {false, node.list(text)};
  if (node.text() != "none") node.fail("must be a list of objects or \"none\"");
  return {true, {}};
}

SceneSnapshot scene(const Node& node) {
  SceneSnapshot out;
  out.cell = node["cell"].text();
  out.task = node["task"].text();
  out.seed = node["seed"].whole<std::uint64_t>();
  out.scene_hash = node["scene_hash"].text();
  out.object = node["object"].text();
  out.robots = node["robots"].list(robot);
  out.objects = node["objects"].list(object);
  const Node start = node["start"], goal = node["goal"];
  out.start.X_WO = pose(start["X_WO"]);
  if (const Node held_by = start["held_by"]; !held_by.null()) out.start.held_by = arm(held_by);
  out.start.rest = rest(start["rest"]);
  out.goal.X_WO = pose(goal["X_WO"]);
  out.goal.end = goal["end"].enumerator<TransportEnd>();
  out.goal.rest = rest(goal["rest"]);
  if (const Node upright = node["upright"]; !upright.null()) {
    out.upright = UprightSnapshot{upright["axis"].numbers<3>(), upright["within_deg"].number()};
  }
  return out;
}

GripperSnapshot gripper(const Node& node) {
  const std::string kind = node["gripper"].text();
  const Node hand = node["hand"];
  if (kind == "fingers") return FingerGripper{hand["palm"].text(), hand["fingers"].list(text)};
  if (kind != "suction") node.fail("unknown gripper '" + kind + "'");
  return SuctionGripper{hand["cup_link"].text(), hand["axis"].numbers<3>(),
                        hand["radius"].number()};
}

Holder holder(const Node& node) {
  Holder out;
  out.arm = {node["robot"].text(), node["arm"].text()};
  out.tool_link = node["tool_link"].text();
  out.gripper = gripper(node);
  out.X_OT = pose(node["X_OT"]);
  out.dexterity = {node["dexterity"]["take"].number(), node["dexterity"]["give"].number()};
  return out;
}

Hold hold(const Node& node) {
  return {node["object"].text(), node["robot"].text(), node["link"].text(), pose(node["X_LO"])};
}

StageProgress progress(const Node& node) {
  const auto entries = node.tuple(2);
  return {entries[0].whole<std::uint32_t>(), entries[1].number()};
}

StageTrajectory stage(const Node& node) {
  const auto row = [](const Node& it) { return it.row(); };
  StageTrajectory out;
  out.index = node["index"].whole<std::uint32_t>();
  out.holder = node["holder"].whole<std::uint32_t>();
  out.action = node["action"].enumerator<StageAction>();
  out.robot = node["robot"].text();
  out.joints = node["joints"].list(text);
  out.start = node["start"].number();
  out.t = node["t"].row();
  out.q = node["q"].list(row);
  out.qd = node["qd"].list(row);
  out.qdd = node["qdd"].list(row);
  out.holding = node["holding"].list(hold);
  out.may_touch = node["may_touch"].list(pair);
  out.after = node["after"].list(progress);
  return out;
}

Quality quality(const Node& node) {
  Quality out;
  out.duration_s = node["duration_s"].number();
  out.bound_s = node["bound_s"].number();
  out.object_s = node["object_s"].number();
  out.idle_s = node["idle_s"].entries(number);
  out.clearance = node["clearance"].list([](const Node& it) {
    return ClearanceQuality{it["between"].text(), it["least_m"].number(),
                            it["stage"].whole<std::uint32_t>(), pairOrNone(it["pair"])};
  });
  out.tilt_deg = node["tilt_deg"].number();
  out.object_turn_deg = node["object_turn_deg"].numbers<2>();
  out.limit_margin = node["limit_margin"].number();
  out.grip = node["grip"].list([](const Node& it) {
    return GripQuality{it["holder"].whole<std::uint32_t>(), it["quality"].number(),
                       it["of_best"].number()};
  });
  out.jerk_share = node["jerk_share"].number();
  out.cost = node["cost"].number();
  out.terms = node["terms"].entries(number);
  return out;
}

StageRef stageRef(const Node& node) {
  return {node["holder"].whole<std::uint32_t>(), node["action"].enumerator<StageAction>()};
}

/// What the reason alone is known of stands as its own cause in the file: then there is none.
std::vector<CauseCount> causes(const Node& node, FailureReason reason) {
  std::vector<CauseCount> all;
  for (const Node& it : node.list([](const Node& entry) { return entry; })) {
    if (it["cause"].text() == toString(reason) && !fromString<Cause>(it["cause"].text())) continue;
    CauseCount cause{it["cause"].enumerator<Cause>(),
                     pairOrNone(it["pair"]),
                     {},
                     it["count"].whole<std::uint32_t>()};
    const Node about = it.member("about");
    if (!about.null() && about.text() != kOtherPairs) cause.pair.first = about.text();
    if (const Node at = it.member("stage"); !at.null()) cause.stage = stageRef(at);
    all.push_back(std::move(cause));
  }
  return all;
}

Failure failure(const Node& node) {
  Failure out{node["reason"].enumerator<FailureReason>(), {}};
  Explanation& why = out.explanation;
  why.filter = node["filter"].text();
  why.text = node["text"].text();
  why.exhaustive = node["exhaustive"].truth();
  why.causes = causes(node["causes"], out.reason);
  if (const Node fix = node["nearest_fix"]; !fix.null()) {
    why.nearest_fix = fix.list([](const Node& it) {
      return Override{it["path"].text(), it["value"].text()};
    });
  }
  why.fix_text = node["fix_text"].text();
  if (const Node farthest = node["farthest"]; !farthest.null()) {
    why.farthest =
        Farthest{pose(farthest["X_WO"]), farthest["tools"].list([](const Node& it) {
                   return FarthestTool{{it["robot"].text(), it["arm"].text()}, pose(it["X_WT"])};
                 }),
                 stageRef(farthest["stage"])};
  }
  return out;
}

/// The bounds of what travels hold for files too.
void require(const PlanEventPayload& payload, const std::string& where) {
  const auto faults = check(PlanEvent{{}, {1}, 0, 0, payload});
  if (!faults.empty()) throw PlanFileError(where, faults[0].field + " " + faults[0].message);
}

Plan plan(const Node& node, const Node& measured) {
  Plan out;
  out.solution.holders = node["holders"].list(holder);
  out.solution.X_WO_handovers = node["handovers"].list(pose);
  out.solution.slack_s = node["slack_s"].number();
  out.stages = node["stages"].list(stage);
  out.solution.stage_count = static_cast<std::uint32_t>(out.stages.size());
  if (!measured.null()) {
    out.solution.quality = quality(measured);
    out.solution.cost = out.solution.quality->cost;
  }
  require(out.solution, "/plan");
  for (std::size_t i = 0; i < out.stages.size(); ++i) {
    const std::string where = "/plan/stages/" + std::to_string(i);
    require(out.stages[i], where);
    if (out.stages[i].index != i) throw PlanFileError(where + "/index", "is out of order");
    if (out.stages[i].holder >= out.solution.holders.size()) {
      throw PlanFileError(where + "/holder", "is not in the plan");
    }
  }
  return out;
}

void requireRobots(const PlanFile& file) {
  for (std::size_t i = 0; file.scene && i < file.plan->stages.size(); ++i) {
    const auto named = [&](const RobotSnapshot& it) {
      return it.name == file.plan->stages[i].robot;
    };
    if (std::none_of(file.scene->robots.begin(), file.scene->robots.end(), named)) {
      throw PlanFileError("/plan/stages/" + std::to_string(i) + "/robot", "is not in the scene");
    }
  }
}

PlanFile parsed(const Json& json) {
  const Node root(json, "");
  if (root["format"].text() != "handover-plan/2") {
    root["format"].fail("is not handover-plan/2");
  }
  PlanFile file;
  if (const Node node = root["scene"]; !node.null()) {
    file.scene = scene(node);
    require(*file.scene, "/scene");
  }
  if (const Node node = root["plan"]; !node.null()) {
    file.plan = plan(node, root["quality"]);
    if (!file.scene) root["scene"].fail("is missing beside a plan");
    requireRobots(file);
  }
  if (const Node node = root["explanation"]; !node.null()) {
    file.failure = failure(node);
    require(*file.failure, "/explanation");
  }
  file.complete = root["complete"].truth();
  file.scene_revision = root["timing"]["scene_revision"].whole<std::uint64_t>();
  return file;
}

/// Line and column, from 1, of a byte of a text.
std::string placeOf(std::string_view text, std::size_t offset) {
  const std::string_view before = text.substr(0, offset);
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const std::size_t begin = before.rfind('\n');
  const std::size_t column = begin == before.npos ? offset + 1 : offset - begin;
  return "line " + std::to_string(line) + ", column " + std::to_string(column);
}

Json jsonOf(std::string_view text) {
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& error) {
    const std::size_t offset = std::max<std::size_t>(error.byte, 1) - 1;
    throw PlanFileError(placeOf(text, offset),
                        offset < text.size() ? "is not JSON from there on" : "the JSON ends there");
  } catch (const Json::out_of_range&) {
    throw PlanFileError("", "a number is beyond what a double holds");
  }
}

}  // namespace

PlanFile parsePlanFile(std::string_view text) { return parsed(jsonOf(text)); }

std::string readPlanText(const fs::path& file) {
  std::error_code error;
  if (!fs::exists(file, error)) throw PlanFileError(file.string(), "no such file");
  if (!fs::is_regular_file(file, error)) throw PlanFileError(file.string(), "is not a file");
  if (fs::file_size(file, error) > kMaxBytes || error) {
    throw PlanFileError(file.string(), "is larger than 256 MiB");
  }
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) throw PlanFileError(file.string(), "cannot be read");
  return std::move(text).str();
}

PlanFile readPlanFile(const fs::path& file) {
  const std::string text = readPlanText(file);
  try {
    return parsePlanFile(text);
  } catch (const PlanFileError& error) {
    throw PlanFileError(file.string(), error.what());
  }
}

}  // namespace handover::client
