// SPDX-License-Identifier: Apache-2.0
#include "gantry_plan.hpp"

#include "verify/sha256.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <stdexcept>

namespace handover::verify::test {
namespace {

// Palm at the wrist's origin, approach along +x, fingers close along y; the right one mimics.
constexpr const char* kUrdf = R"(<?xml version="1.0"?>
<robot name="gantry">
  <link name="base"><collision><origin xyz="0 0 -0.5"/><geometry><box size="0.05 0.05 0.05"/></geometry></collision></link>
  <link name="x_link"/>
  <link name="y_link"/>
  <link name="z_link"><collision><origin xyz="-0.15 0 0"/><geometry><box size="0.05 0.05 0.05"/></geometry></collision></link>
  <link name="wrist_1"/>
  <link name="wrist_2"/>
  <link name="wrist_3"/>
  <link name="palm"><collision><origin xyz="-0.02 0 0"/><geometry><box size="0.04 0.12 0.02"/></geometry></collision></link>
  <link name="tool"/>
  <link name="left_finger"><collision><origin xyz="0.03 0.005 0"/><geometry><box size="0.06 0.01 0.02"/></geometry></collision></link>
  <link name="right_finger"><collision><origin xyz="0.03 -0.005 0"/><geometry><box size="0.06 0.01 0.02"/></geometry></collision></link>
  <joint name="x" type="prismatic"><parent link="base"/><child link="x_link"/><axis xyz="1 0 0"/><limit lower="-0.5" upper="1.5" velocity="0.5" effort="1"/></joint>
  <joint name="y" type="prismatic"><parent link="x_link"/><child link="y_link"/><axis xyz="0 1 0"/><limit lower="-0.5" upper="0.5" velocity="0.5" effort="1"/></joint>
  <joint name="z" type="prismatic"><parent link="y_link"/><child link="z_link"/><axis xyz="0 0 1"/><limit lower="-0.5" upper="1.5" velocity="0.5" effort="1"/></joint>
  <joint name="yaw" type="revolute"><parent link="z_link"/><child link="wrist_1"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
  <joint name="pitch" type="revolute"><parent link="wrist_1"/><child link="wrist_2"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
  <joint name="roll" type="revolute"><parent link="wrist_2"/><child link="wrist_3"/><axis xyz="1 0 0"/><limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
  <joint name="palm_joint" type="fixed"><parent link="wrist_3"/><child link="palm"/></joint>
  <joint name="tool_joint" type="fixed"><parent link="palm"/><child link="tool"/><origin xyz="0.04 0 0"/></joint>
  <joint name="left" type="prismatic"><parent link="palm"/><child link="left_finger"/><axis xyz="0 1 0"/><limit lower="0" upper="0.045" velocity="0.1" effort="1"/></joint>
  <joint name="right" type="prismatic"><parent link="palm"/><child link="right_finger"/><axis xyz="0 -1 0"/><limit lower="0" upper="0.045" velocity="0.1" effort="1"/><mimic joint="left" multiplier="1" offset="0"/></joint>
</robot>
)";

constexpr const char* kSrdf = R"(<?xml version="1.0"?>
<robot name="gantry">
  <group name="arm"><chain base_link="base" tip_link="tool"/></group>
</robot>
)";

using Vector = std::vector<double>;

constexpr double kOpen = 0.04;
constexpr double kClosed = 0.0205;  // half a millimetre from the box of 40 mm

const std::vector<std::string> kArm = {"x", "y", "z", "yaw", "pitch", "roll"};

Json pose(const Vector& xyz, const Vector& quat = {1, 0, 0, 0}) {
  return {{"xyz", xyz}, {"quat_wxyz", quat}};
}

/// Gantry positions that put the tool at a place in the world.
Vector armAt(bool giver, const Vector& tool) {
  return giver ? Vector{tool[0] + 0.8 - 0.04, tool[1], tool[2], 0, 0, 0}
               : Vector{0.8 - tool[0] - 0.04, -tool[1], tool[2], 0, 0, 0};
}

/// From rest to rest through the waypoints; each leg is one cubic, given by several samples.
void fillMotion(Json& stage, const std::vector<Vector>& waypoints, double velocity,
                double acceleration) {
  constexpr int kSamples = 10;
  const std::size_t joints = waypoints.front().size();
  Json t = {0.0}, q = {waypoints.front()}, qd = {Vector(joints, 0.0)};
  double now = 0;
  for (std::size_t leg = 0; leg + 1 < waypoints.size(); ++leg) {
    const Vector& from = waypoints[leg];
    const Vector& to = waypoints[leg + 1];
    double distance = 0;
    for (std::size_t j = 0; j < joints; ++j)
      distance = std::max(distance, std::abs(to[j] - from[j]));
    const double duration =
        1.01 * std::max(1.5 * distance / velocity, std::sqrt(6 * distance / acceleration));
    for (int k = 1; k <= kSamples; ++k) {
      const double s = static_cast<double>(k) / kSamples;
      Vector row, rate;
      for (std::size_t j = 0; j < joints; ++j) {
        row.push_back(k == kSamples ? to[j] : from[j] + (to[j] - from[j]) * s * s * (3 - 2 * s));
        rate.push_back(k == kSamples ? 0 : (to[j] - from[j]) * 6 * s * (1 - s) / duration);
      }
      t.push_back(now + duration * s);
      q.push_back(row);
      qd.push_back(rate);
    }
    now += duration;
  }
  stage["t"] = t;
  stage["q"] = q;
  stage["qd"] = qd;
}

class PlanMaker {
 public:
  explicit PlanMaker(const std::string& hash) {
    file_ = {{"format", "handover-plan/1"}, {"complete", true},       {"timing", Json::object()},
             {"funnel", Json::object()},    {"explanation", nullptr}, {"plan", Json::object()}};
    Json& plan = file_["plan"];
    plan = {{"cell", "gantries"},
            {"task", "give"},
            {"seed", 1},
            {"scene_hash", "0af3"},
            {"object", "box"},
            {"giver", "g"},
            {"receiver", "r"},
            {"giver_arm", "arm"},
            {"receiver_arm", "arm"},
            {"giver_tool_link", "tool"},
            {"receiver_tool_link", "tool"}};
    plan["robots"] = {
        robotEntry("g", hash, pose({-0.8, 0, 0}), armAt(true, {-0.6, 0, 0.2})),
        robotEntry("r", hash, pose({0.8, 0, 0}, {0, 0, 0, 1}), armAt(false, {0.6, 0, 0.2}))};
    Json box = boxObject("box", {0.04, 0.04, 0.12}, {-0.3, 0, 0.06});
    box["resting"] = {"table"};
    // A sign on the receiver's arm: attached, so held in every stage.
    Json sign = boxObject("sign", {}, {0.75, 0, 0.25});
    sign["geometry"] = {{"type", "cylinder"}, {"radius", 0.01}, {"length", 0.05}};
    sign["X_WO"] = pose({0.79, 0, 0.25}, {0, 0, 0, 1});
    sign["attached_to"] = {{"robot", "r"},
                           {"link", "z_link"},
                           {"X_LO", pose({-0.15, 0, 0.05})},
                           {"touch_links", Json::array()}};
    plan["objects"] = {box, boxObject("table", {0.4, 0.4, 0.02}, {-0.3, 0, -0.01}),
                       boxObject("shelf", {0.4, 0.4, 0.02}, {0.3, 0, -0.01}),
                       boxObject("post", {0.1, 0.1, 0.8}, {0, 0.5, 0.4}), sign};
    plan["X_WO_start"] = pose({-0.3, 0, 0.06});
    plan["X_WO_goal"] = pose({0.3, 0, 0.06});
    plan["X_WO_handover"] = pose({0, 0, 0.4});
    plan["X_OT_giver"] = pose({0, 0, -0.03});
    plan["X_OT_receiver"] = pose({0, 0, 0.03}, {0, 0, 0, 1});
    // xyz axes and a wrist at its zero: J is the identity but for lever arms, so det(J J^T) = 1.
    plan["dexterity"] = {
        {"receiver_place", 1}, {"receiver_handover", 1}, {"giver_pick", 1}, {"giver_handover", 1}};
    plan["stages"] = Json::array();
  }

  Json make() {
    hold_ = {};
    arm("giver_reach", {{-0.6, 0, 0.2}, {-0.45, 0, 0.03}});
    arm("giver_approach", {{-0.45, 0, 0.03}, {-0.3, 0, 0.03}});
    hand("giver_grasp", kOpen, kClosed, touches("g", {"table"}));
    hold_ = {giverHold()};
    arm("giver_lift", {{-0.3, 0, 0.03}, {-0.3, 0, 0.08}}, touches("g", {"table"}));
    // The receiver comes while the giver carries.
    const double carrying = now_;
    arm("giver_transfer", {{-0.3, 0, 0.08}, {0, 0, 0.37}}, touches("g", {}));
    const double carried = now_;
    now_ = carrying;
    arm("receiver_reach", {{0.6, 0, 0.2}, {0.15, 0, 0.43}}, touches("g", {}));
    arm("receiver_approach", {{0.15, 0, 0.43}, {0, 0, 0.43}}, touches("g", {}));
    now_ = std::max(now_, carried);
    hand("receiver_grasp", kOpen, kClosed, both());
    hold_ = {giverHold(), receiverHold()};
    hand("giver_release", kClosed, kOpen, both());
    hold_ = {receiverHold()};
    const double released = now_;
    Json back = touches("r", {});
    for (const Json& pair : touches("g", {})) back.push_back(pair);
    arm("giver_retreat", {{0, 0, 0.37}, {-0.15, 0, 0.37}, {-0.6, 0, 0.2}}, back);
    const double retreated = now_;
    now_ = released;
    arm("receiver_transfer", {{0, 0, 0.43}, {0.3, 0, 0.15}}, touches("r", {}));
    arm("receiver_place", {{0.3, 0, 0.15}, {0.3, 0, 0.09}}, touches("r", {"shelf"}));
    now_ = std::max(now_, retreated);
    hold_ = {};
    hand("receiver_release", kClosed, kOpen, touches("r", {}));
    arm("receiver_retreat", {{0.3, 0, 0.09}, {0.45, 0, 0.09}, {0.6, 0, 0.2}}, touches("r", {}));
    return file_;
  }

 private:
  static Json robotEntry(const std::string& name, const std::string& hash, const Json& X_WB,
                         const Vector& arm) {
    Json q_start, limits;
    for (std::size_t j = 0; j < kArm.size(); ++j) q_start[kArm[j]] = arm[j];
    q_start["left"] = q_start["right"] = kOpen;
    limits["x"] = limits["z"] = {-0.5, 1.5, 0.5, 1};
    limits["y"] = {-0.5, 0.5, 0.5, 1};
    limits["yaw"] = limits["roll"] = {-3, 3, 1, 1};
    limits["pitch"] = {-1, 1, 1, 1};
    limits["left"] = limits["right"] = {0, 0.045, 0.1, 1};
    return {{"name", name},        {"urdf", "robots/gantry/gantry.urdf"},
            {"urdf_sha256", hash}, {"srdf", "robots/gantry/gantry.srdf"},
            {"X_WB", X_WB},        {"q_start", q_start},
            {"limits", limits},    {"resting", Json::array()}};
  }

  static Json giverHold() {
    return {{"object", "box"}, {"robot", "g"}, {"link", "tool"}, {"X_LO", pose({0, 0, 0.03})}};
  }

  static Json receiverHold() {
    return {{"object", "box"},
            {"robot", "r"},
            {"link", "palm"},
            {"X_LO", pose({0.04, 0, -0.03}, {0, 0, 0, 1})}};
  }

  static Json touches(const std::string& robot, const std::vector<std::string>& rests) {
    Json pairs = Json::array();
    for (const char* link : {"palm", "left_finger", "right_finger"}) {
      pairs.push_back({robot + "/" + link, "box"});
    }
    for (const std::string& rest : rests) pairs.push_back({"box", rest});
    return pairs;
  }

  static Json both() {
    Json pairs = touches("g", {});
    for (const Json& pair : touches("r", {})) pairs.push_back(pair);
    return pairs;
  }

  void add(const std::string& kind, Json stage, const Json& may_touch) {
    Json& stages = file_["plan"]["stages"];
    stage["index"] = stages.size();
    stage["kind"] = kind;
    stage["robot"] = kind.rfind("giver", 0) == 0 ? "g" : "r";
    stage["start"] = now_;
    stage["holding"] = hold_;
    stage["holding"].push_back(
        {{"object", "sign"}, {"robot", "r"}, {"link", "z_link"}, {"X_LO", pose({-0.15, 0, 0.05})}});
    stage["may_touch"] = may_touch;
    now_ += stage["t"].back().get<double>();
    stages.push_back(stage);
  }

  void arm(const std::string& kind, const std::vector<Vector>& tools,
           const Json& may_touch = Json::array()) {
    std::vector<Vector> waypoints;
    for (const Vector& tool : tools) {
      waypoints.push_back(armAt(kind.rfind("giver", 0) == 0, tool));
    }
    Json stage = {{"joints", kArm}};
    fillMotion(stage, waypoints, 0.5, 1);
    add(kind, stage, may_touch);
  }

  void hand(const std::string& kind, double from, double to, const Json& may_touch) {
    Json stage = {{"joints", {"left"}}};
    fillMotion(stage, {{from}, {to}}, 0.1, 1);
    add(kind, stage, may_touch);
  }

  Json file_;
  Json hold_ = Json::array();
  double now_ = 0;
};

Json& named(Json& entries, const std::string& key, const std::string& name) {
  for (Json& entry : entries) {
    if (entry.at(key) == name) return entry;
  }
  throw std::out_of_range(name);
}

}  // namespace

GantryCell::GantryCell() {
  write("robots/gantry/gantry.urdf", kUrdf);
  write("robots/gantry/gantry.srdf", kSrdf);
}

void GantryCell::write(const std::string& file, const std::string& text) const {
  root_.write(file, text);
}

Json GantryCell::plan() const { return PlanMaker(sha256(kUrdf)).make(); }

Json& stage(Json& file, const std::string& kind) {
  return named(file["plan"]["stages"], "kind", kind);
}

Json& object(Json& file, const std::string& name) {
  return named(file["plan"]["objects"], "name", name);
}

Json& robot(Json& file, const std::string& name) {
  return named(file["plan"]["robots"], "name", name);
}

Json boxObject(const std::string& name, const Vector& size, const Vector& xyz) {
  return {{"name", name},
          {"geometry", {{"type", "box"}, {"size", size}}},
          {"X_WO", pose(xyz)},
          {"attached_to", nullptr},
          {"resting", Json::array()}};
}

ProgramResult run(const std::string& arguments) {
  ProgramResult result;
  const std::string command = std::string(HANDOVER_VERIFY) + " " + arguments + " 2>/dev/null";
  FILE* pipe = popen(command.c_str(), "r");
  if (!pipe) throw std::runtime_error("cannot run " + command);
  std::array<char, 4096> buffer{};
  std::size_t read = 0;
  while ((read = fread(buffer.data(), 1, buffer.size(), pipe)) > 0) {
    result.output.append(buffer.data(), read);
  }
  const int status = pclose(pipe);
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return result;
}

ProgramResult verifyText(const GantryCell& cell, const std::string& text) {
  cell.write("plan.json", text);
  ProgramResult result =
      run((cell.root() / "plan.json").string() + " --json --root " + cell.root().string());
  result.json = Json::parse(result.output, nullptr, false);
  if (result.json.is_object() && result.json.contains("violations")) {
    for (const Json& violation : result.json["violations"]) {
      result.kinds.push_back(violation["kind"]);
    }
  }
  return result;
}

ProgramResult verify(const GantryCell& cell, const Json& plan) {
  return verifyText(cell, plan.dump());
}

}  // namespace handover::verify::test
