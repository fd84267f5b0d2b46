// SPDX-License-Identifier: Apache-2.0
#include "sample_plan.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <vector>

namespace handover::view::test {
namespace {

using Vector = std::vector<double>;

// Every arm is a gantry: its tool's place in the base frame is what its x, y and z joints say.
// Fingers close along y: the right one mimics.
std::string gantry(const std::string& side) {
  const auto slide = [&](const std::string& axis, const std::string& parent,
                         const std::string& xyz) {
    return "<link name=\"" + side + axis + "_link\"/><joint name=\"" + side + axis +
           "\" type=\"prismatic\"><parent link=\"" + parent + "\"/><child link=\"" + side + axis +
           "_link\"/><axis xyz=\"" + xyz +
           "\"/><limit lower=\"-1\" upper=\"1\" velocity=\"0.5\" effort=\"1\"/></joint>\n";
  };
  return slide("x", "base", "1 0 0") + slide("y", side + "x_link", "0 1 0") +
         slide("z", side + "y_link", "0 0 1");
}

std::string box(const std::string& size, const std::string& xyz) {
  return "<collision><origin xyz=\"" + xyz + "\"/><geometry><box size=\"" + size +
         "\"/></geometry></collision>";
}

std::string joint(const std::string& name, const std::string& type, const std::string& parent,
                  const std::string& child, const std::string& more = "") {
  return "<joint name=\"" + name + "\" type=\"" + type + "\"><parent link=\"" + parent +
         "\"/><child link=\"" + child + "\"/>" + more + "</joint>\n";
}

std::string hand(const std::string& side, const std::string& rpy) {
  const std::string limit = R"(<limit lower="0" upper="0.05" velocity="0.1" effort="1"/>)";
  const std::string palm = side + "palm", left = side + "left_finger",
                    right = side + "right_finger";
  return "<link name=\"" + palm + "\">" + box("0.3 0.03 0.03", "-0.21 0 0") +
         R"(<collision><origin xyz="-0.05 0 0"/><geometry><mesh filename="meshes/palm.obj" scale="0.02 0.12 0.02"/></geometry></collision></link>)" +
         "<link name=\"" + side + "tool\"/><link name=\"" + left + "\">" +
         box("0.06 0.01 0.02", "-0.01 0.005 0") + "</link><link name=\"" + right + "\">" +
         box("0.06 0.01 0.02", "-0.01 -0.005 0") + "</link>\n" +
         joint(side + "palm_joint", "fixed", side + "z_link", palm,
               "<origin rpy=\"" + rpy + "\"/>") +
         joint(side + "tool_joint", "fixed", palm, side + "tool") +
         joint(side + "left", "prismatic", palm, left, "<axis xyz=\"0 1 0\"/>" + limit) +
         joint(side + "right", "prismatic", palm, right,
               "<axis xyz=\"0 -1 0\"/>" + limit + "<mimic joint=\"" + side + "left\"/>");
}

// A picture in a file that is not there: the page shows the shapes instead.
std::string duo() {
  return R"(<?xml version="1.0"?><robot name="duo"><link name="base">)" +
         box("0.1 0.1 0.9", "-0.85 0 0.35") +
         R"(<visual><geometry><mesh filename="meshes/none.dae"/></geometry></visual></link>)" +
         gantry("l_") + hand("l_", "0 0 0") + gantry("r_") + hand("r_", "0 0 3.141592653589793") +
         "</robot>\n";
}

std::string crane() {
  return R"(<?xml version="1.0"?><robot name="crane"><link name="base">)" +
         box("0.1 0.1 0.9", "-0.45 0 0.35") + "</link>\n" + gantry("") +
         R"(<link name="cup"><visual><origin xyz="0 0 0.01"/><geometry><cylinder radius="0.025" length="0.02"/></geometry></visual>)" +
         R"(<collision><origin xyz="0 0 0.17"/><geometry><cylinder radius="0.015" length="0.3"/></geometry></collision></link>)" +
         joint("turn", "continuous", "z_link", "cup", R"(<axis xyz="0 0 1"/>)") + "</robot>\n";
}

// A cube of edge 1.
constexpr const char* kCube = R"(v -0.5 -0.5 -0.5
v 0.5 -0.5 -0.5
v 0.5 0.5 -0.5
v -0.5 0.5 -0.5
v -0.5 -0.5 0.5
v 0.5 -0.5 0.5
v 0.5 0.5 0.5
v -0.5 0.5 0.5
f 4 3 2 1
f 5 6 7 8
f 1 2 6 5
f 2 3 7 6
f 3 4 8 7
f 4 1 5 8
)";

Json pose(const Vector& xyz, const Vector& quat = {1, 0, 0, 0}) {
  return {{"xyz", xyz}, {"quat_wxyz", quat}};
}

constexpr double kHalf = 0.7071067811865476;  // of a quarter turn's quaternion
constexpr double kOpen = 0.04, kClosed = 0.02;
const Vector kStart{-0.4, 0, 0.06}, kFirst{-0.1, 0, 0.4}, kSecond{0.1, 0, 0.4};
const Vector kGoal{0.4, 0.2, 0.06};

/// From rest to rest: 10 s^3 - 15 s^4 + 6 s^5, of which a quintic Hermite curve misses nothing.
void fillMotion(Json& stage, const Vector& from, const Vector& to, double duration) {
  constexpr int kLegs = 4;
  for (const char* key : {"t", "q", "qd", "qdd"}) stage[key] = Json::array();
  for (int k = 0; k <= kLegs; ++k) {
    const double s = static_cast<double>(k) / kLegs;
    Vector q, qd, qdd;
    for (std::size_t j = 0; j < from.size(); ++j) {
      const double d = to[j] - from[j];
      const bool ends = k == 0 || k == kLegs;
      q.push_back(k == kLegs ? to[j] : from[j] + d * s * s * s * (10 + s * (-15 + 6 * s)));
      qd.push_back(ends ? 0 : d * 30 * s * s * (1 - s) * (1 - s) / duration);
      qdd.push_back(ends ? 0 : d * 60 * s * (1 - s) * (1 - 2 * s) / (duration * duration));
    }
    stage["t"].push_back(duration * s);
    stage["q"].push_back(q);
    stage["qd"].push_back(qd);
    stage["qdd"].push_back(qdd);
  }
}

struct Arm {
  std::string robot, group, tool_link, prefix;
  Json hand;
  Json X_OT, X_TO;
};

const std::array<Arm, 3> kArms{{
    {"duo",
     "left",
     "l_tool",
     "l_",
     {{"palm", "l_palm"}, {"fingers", {"l_left_finger", "l_right_finger"}}},
     pose({0, 0, -0.02}),
     pose({0, 0, 0.02})},
    {"duo",
     "right",
     "r_tool",
     "r_",
     {{"palm", "r_palm"}, {"fingers", {"r_left_finger", "r_right_finger"}}},
     pose({0, 0, 0.02}, {0, 0, 0, 1}),
     pose({0, 0, -0.02}, {0, 0, 0, 1})},
    {"crane",
     "arm",
     "cup",
     "",
     {{"cup_link", "cup"}, {"axis", {0, 0, -1}}, {"radius", 0.025}},
     pose({0, 0, 0.06}, {kHalf, 0, 0, -kHalf}),
     pose({0, 0, -0.06}, {kHalf, 0, 0, kHalf})},
}};

/// Joints that put the tool where the object at a place has it, and `back` away from there.
Vector jointsAt(std::size_t holder, const Vector& p, double turn = 0,
                const Vector& back = {0, 0, 0}) {
  const Vector w{p[0] + back[0], p[1] + back[1], p[2] + back[2]};
  if (holder == 0) return {w[0], w[1], w[2] - 0.02};
  if (holder == 1) return {w[0], w[1], w[2] + 0.02};
  return {0.8 - w[1], w[0] - 0.3, w[2] + 0.06, turn};  // base at (0.3, 0.8), looking along -y
}

const std::array<Vector, 3> kHome{{{-0.5, 0.3, 0.5}, {0.35, 0.3, 0.6}, {0.1, 0.3, 0.7, 0}}};
/// From the grasp back to where the approach begins.
const std::array<Vector, 3> kBack{{{-0.12, 0, 0}, {0.12, 0, 0}, {0, 0, 0.1}}};

/// Stages in the order of their indices.
class PlanMaker {
 public:
  Json make() {
    take(0, kStart, 0);
    arm(0, "lift", jointsAt(0, kStart), jointsAt(0, kStart, 0, {0, 0, 0.05}), 0.6);
    const double carrying = now_;
    arm(0, "carry", jointsAt(0, kStart, 0, {0, 0, 0.05}), jointsAt(0, kFirst), 1.6);
    pass(1, kFirst, carrying);
    carry(1, kFirst, kSecond, 1.2);
    pass(2, kSecond, now_ - 1.2);
    const double quarter = 1.5707963267948966;
    const Vector above = jointsAt(2, kGoal, quarter, {0, 0, 0.1});
    arm(2, "carry", jointsAt(2, kSecond), above, 2.0);
    arm(2, "place", above, jointsAt(2, kGoal, quarter), 0.8);
    release(2);
    leave(2, kGoal, quarter);
    return stages_;
  }

 private:
  static std::vector<std::string> namesOf(std::size_t holder) {
    const std::string& p = kArms[holder].prefix;
    if (holder == 2) return {"x", "y", "z", "turn"};
    return {p + "x", p + "y", p + "z"};
  }

  void add(std::size_t holder, const std::string& action, Json stage, double seconds) {
    stage["index"] = stages_.size();
    stage["holder"] = holder;
    stage["action"] = action;
    stage["robot"] = kArms[holder].robot;
    stage["start"] = now_;
    stage["holding"] = holding_;
    stage["may_touch"] = Json::array();
    stage["after"] = Json::array();
    stages_.push_back(stage);
    now_ += seconds;
  }

  void arm(std::size_t holder, const std::string& action, const Vector& from, const Vector& to,
           double seconds) {
    Json stage = {{"joints", namesOf(holder)}};
    fillMotion(stage, from, to, seconds);
    add(holder, action, stage, seconds);
  }

  /// A suction cup has no joints; its stage says how long it takes.
  void grip(std::size_t holder, const std::string& action, double from, double to) {
    constexpr double kSeconds = 0.5;
    const bool cup = holder == 2;
    Json stage = {{"joints", Json::array()}};
    if (!cup) stage["joints"].push_back(kArms[holder].prefix + "left");
    fillMotion(stage, cup ? Vector{} : Vector{from}, cup ? Vector{} : Vector{to}, kSeconds);
    if (cup) stage["t"] = {0.0, kSeconds};
    if (cup) stage["q"] = stage["qd"] = stage["qdd"] = {Vector{}, Vector{}};
    add(holder, action, stage, kSeconds);
  }

  /// Reach, opening the hand on the way, approach, grasp.
  void take(std::size_t holder, const Vector& at, double begin) {
    const double earliest = now_;
    now_ = begin;
    Json stage = {{"joints", namesOf(holder)}};
    Vector from = kHome[holder], to = jointsAt(holder, at, 0, kBack[holder]);
    if (holder != 2) {
      stage["joints"].push_back(kArms[holder].prefix + "left");
      from.push_back(0.01);
      to.push_back(kOpen);
    }
    fillMotion(stage, from, to, 1.0);
    add(holder, "reach", stage, 1.0);
    arm(holder, "approach", jointsAt(holder, at, 0, kBack[holder]), jointsAt(holder, at), 0.5);
    now_ = std::max(now_, earliest);
    grip(holder, "grasp", kOpen, kClosed);
    holding_.push_back({{"object", "box"},
                        {"robot", kArms[holder].robot},
                        {"link", kArms[holder].tool_link},
                        {"X_LO", kArms[holder].X_TO}});
  }

  void release(std::size_t holder) {
    grip(holder, "release", kClosed, kOpen);
    holding_.erase(1);  // the first one is a sign's
  }

  void leave(std::size_t holder, const Vector& at, double turn = 0) {
    const Vector back = jointsAt(holder, at, turn, kBack[holder]);
    arm(holder, "retreat", jointsAt(holder, at, turn), back, 0.5);
    Json stage = {{"joints", namesOf(holder)}};
    Vector from = back, to = kHome[holder];
    if (holder != 2) {
      stage["joints"].push_back(kArms[holder].prefix + "left");
      from.push_back(kOpen);
      to.push_back(0.01);
    }
    fillMotion(stage, from, to, 1.2);
    add(holder, "home", stage, 1.2);
  }

  /// The next holder comes from `begin` on and takes; the one before releases and leaves while
  /// the next may go on.
  void pass(std::size_t taker, const Vector& at, double begin) {
    take(taker, at, begin);
    release(taker - 1);
    const double released = now_;
    leave(taker - 1, at);
    now_ = released + 0.2;
  }

  void carry(std::size_t holder, const Vector& from, const Vector& to, double seconds) {
    arm(holder, "carry", jointsAt(holder, from), jointsAt(holder, to), seconds);
  }

  Json stages_ = Json::array();
  Json holding_ = Json::array(
      {{{"object", "sign"}, {"robot", "duo"}, {"link", "base"}, {"X_LO", pose({-0.85, 0, 0.85})}}});
  double now_ = 0;
};

Json limitsOf(const std::vector<std::string>& names) {
  Json limits = Json::object();
  for (const std::string& name : names) {
    limits[name] = {-1.0, 1.0, 2.0, 10.0, 100.0};
    if (name == "turn") limits[name] = {nullptr, nullptr, 2.0, 10.0, 100.0};
  }
  return limits;
}

Json robotOf(const std::string& name, const Json& X_WB, const Json& q_start) {
  std::vector<std::string> joints;
  for (const auto& [joint, position] : q_start.items()) joints.push_back(joint);
  const std::string folder = "robots/" + name + "/" + name;
  return {{"name", name},
          {"urdf", folder + ".urdf"},
          {"urdf_sha256", std::string(64, '0')},
          {"srdf", folder + ".srdf"},
          {"yaml", folder + ".yaml"},
          {"yaml_sha256", std::string(64, '0')},
          {"X_WB", X_WB},
          {"q_start", q_start},
          {"limits", limitsOf(joints)},
          {"resting", Json::array()}};
}

Json boxOf(const std::string& name, const Vector& size, const Vector& xyz) {
  return {{"name", name},
          {"geometry", {{"type", "box"}, {"size", size}}},
          {"X_WO", pose(xyz)},
          {"attached_to", nullptr},
          {"resting", Json::array()}};
}

Json sceneJson() {
  Json duo_start, crane_start;
  const auto& [l, r, c] = kHome;
  duo_start = {{"l_x", l[0]}, {"l_y", l[1]}, {"l_z", l[2]}, {"l_left", 0.01}, {"l_right", 0.01},
               {"r_x", r[0]}, {"r_y", r[1]}, {"r_z", r[2]}, {"r_left", 0.01}, {"r_right", 0.01}};
  crane_start = {{"x", c[0]}, {"y", c[1]}, {"z", c[2]}, {"turn", c[3]}};
  Json sign = boxOf("sign", {0.2, 0.02, 0.1}, {-0.85, 0, 0.85});
  sign["attached_to"] = {{"robot", "duo"},
                         {"link", "base"},
                         {"X_LO", pose({-0.85, 0, 0.85})},
                         {"touch_links", Json::array()}};
  Json shelf = boxOf("shelf", {}, {0.4, 0.2, 0});
  shelf["geometry"] = {
      {"type", "compound"},
      {"parts",
       {{{"X_OS", pose({0, 0, -0.01})},
         {"geometry", {{"type", "box"}, {"size", {0.4, 0.4, 0.02}}}}},
        {{"X_OS", pose({0, 0, -0.06})},
         {"geometry", {{"type", "cylinder"}, {"radius", 0.05}, {"length", 0.08}}}}}}};
  Json ball = boxOf("ball", {}, {-0.4, 0.15, 0.05});
  ball["geometry"] = {{"type", "sphere"}, {"radius", 0.05}};
  return {{"cell", "sample"},
          {"task", "pass"},
          {"seed", 7},
          {"scene_hash", "0af3"},
          {"object", "box"},
          {"robots",
           {robotOf("duo", pose({0, 0, 0}), duo_start),
            robotOf("crane", pose({0.3, 0.8, 0}, {kHalf, 0, 0, -kHalf}), crane_start)}},
          {"objects",
           {boxOf("box", {0.04, 0.04, 0.12}, kStart),
            boxOf("table", {0.4, 0.5, 0.02}, {-0.4, 0, -0.01}), shelf, ball, sign}},
          {"start", {{"X_WO", pose(kStart)}, {"held_by", nullptr}, {"rest", {"table"}}}},
          {"goal",
           {{"X_WO", pose(kGoal, {kHalf, 0, 0, kHalf})}, {"end", "release"}, {"rest", {"shelf"}}}},
          {"upright", {{"axis", {0, 0, 1}}, {"within_deg", 10}}}};
}

Json holdersJson() {
  Json holders = Json::array();
  for (const Arm& arm : kArms) {
    holders.push_back({{"robot", arm.robot},
                       {"arm", arm.group},
                       {"tool_link", arm.tool_link},
                       {"gripper", arm.hand.contains("palm") ? "fingers" : "suction"},
                       {"hand", arm.hand},
                       {"X_OT", arm.X_OT},
                       {"dexterity", {{"take", 1.0}, {"give", 1.0}}}});
  }
  return holders;
}

Json qualityJson(double duration) {
  return {{"duration_s", duration},
          {"bound_s", 7.5},
          {"object_s", 6.25},
          {"idle_s", {{"duo", 0.5}, {"crane", 0.0}}},
          {"clearance",
           {{{"between", "furniture"}, {"least_m", 0.05}, {"stage", 0}, {"pair", nullptr}},
            {{"between", "robots"},
             {"least_m", 0.031},
             {"stage", 4},
             {"pair", {"duo/l_palm", "duo/r_palm"}}},
            {{"between", "object"}, {"least_m", 0.012}, {"stage", 5}, {"pair", {"box", "ball"}}}}},
          {"tilt_deg", 0.5},
          {"object_turn_deg", {90, 90}},
          {"limit_margin", 0.2},
          {"grip", Json::array()},
          {"jerk_share", 0.8},
          {"cost", 9.5},
          {"terms", {{"duration", 9.5}}}};
}

Json sliceOf(const std::string& robot, const std::string& arm, const std::string& tool_link,
             const Vector& first, int columns, const Vector& scores) {
  return {{"robot", robot}, {"arm", arm},         {"tool_link", tool_link},
          {"first", first}, {"columns", columns}, {"scores", scores}};
}

/// Both arms reach their rows of cells along x, and in common one cell of the lower row.
Json workspacesJson() {
  return {{"z", 0.4},
          {"edge", 0.05},
          {"slices",
           {sliceOf("duo", "left", "l_tool", {-0.175, -0.025}, 3, {0.1, 0.2, 0.4, 0.1, 0, 0}),
            sliceOf("crane", "arm", "cup", {-0.075, -0.025}, 2, {0.3, 0.3})}}};
}

Json funnelJson() {
  const auto score = [](const char* robot, const char* arm, int holder) {
    return Json{{"robot", robot}, {"arm", arm}, {"holder", holder}, {"manipulability", 0.1}};
  };
  Json out = score("duo", "right", 0);
  out["rejected"] = "not_in_map";
  const auto pruned = [](const char* arm, int holder, const char* place, int tested, int kept) {
    return Json{{"arm", arm},       {"holder", holder}, {"place", place},
                {"tested", tested}, {"kept", kept},     {"causes", Json::array()}};
  };
  const Json candidates = {
      {"handover", 0},        {"giver", "duo/left"}, {"receiver", "crane/arm"},
      {"lattice_points", 12}, {"poses_tried", 412},  {"poses", 0},
      {"receiver_grasps", 0}, {"tuples", 0},         {"causes", Json::array()}};
  return {{"arm_selected",
           {{{"holders", {"duo/left", "crane/arm"}},
             {"scores", {score("duo", "left", 0), out, score("crane", "arm", 1)}}}}},
          {"grasps_pruned",
           {pruned("duo/left", 0, "start", 40, 12), pruned("crane/arm", 1, "goal", 36, 9)}},
          {"handover_candidates", {candidates}},
          {"solutions", 0},
          {"grasps", Json::array()},
          {"notes", Json::array()},
          {"workspaces", workspacesJson()}};
}

}  // namespace

SampleCell::SampleCell() {
  write("robots/duo/duo.urdf", duo());
  write("robots/duo/meshes/palm.obj", kCube);
  write("robots/crane/crane.urdf", crane());
}

Json SampleCell::plan() const {
  const Json stages = PlanMaker().make();
  double duration = 0;
  for (const Json& stage : stages) duration = std::max(duration, endOf(stage));
  return {{"format", "handover-plan/2"},
          {"scene", sceneJson()},
          {"plan",
           {{"holders", holdersJson()},
            {"handovers", {pose(kFirst), pose(kSecond)}},
            {"stages", stages},
            {"slack_s", 0.25}}},
          {"quality", qualityJson(duration)},
          {"complete", true},
          {"timing", {{"total_s", 0.0105}, {"scene_revision", 1}}},
          {"funnel", Json::object()},
          {"explanation", nullptr}};
}

Json SampleCell::failure() const {
  return {{"format", "handover-plan/2"},
          {"scene", sceneJson()},
          {"plan", nullptr},
          {"quality", nullptr},
          {"complete", true},
          {"timing", {{"scene_revision", 1}}},
          {"funnel", funnelJson()},
          {"explanation",
           {{"reason", "no_handover_pose"},
            {"text", "At none of 412 poses can duo/left hold the box while crane/arm reaches it."},
            {"filter", "handover_poses"},
            {"exhaustive", true},
            {"causes",
             {{{"cause", "collision"}, {"pair", {"crane/cup", "table"}}, {"count", 311}},
              {{"cause", "self_collision"},
               {"pair", {"duo/l_left_finger", "duo/r_right_finger"}},
               {"count", 80}},
              {{"cause", "no_ik"}, {"pair", nullptr}, {"count", 21}}}},
            {"nearest_fix", {{{"path", "robots.crane.base.xyz"}, {"value", "[0.3, 0.7, 0]"}}}},
            {"fix_text", "With crane 10 cm nearer there is a plan."},
            {"farthest",
             {{"X_WO", pose(kFirst)},
              {"tools",
               {{{"robot", "duo"}, {"arm", "left"}, {"X_WT", pose({-0.1, 0, 0.38})}},
                {{"robot", "crane"}, {"arm", "arm"}, {"X_WT", pose({-0.1, 0, 0.46})}}}},
              {"stage", {{"holder", 1}, {"action", "approach"}}}}}}}};
}

const Json& stageOf(const Json& file, int holder, const std::string& action) {
  for (const Json& stage : file.at("plan").at("stages")) {
    if (stage.at("holder") == holder && stage.at("action") == action) return stage;
  }
  throw std::out_of_range(action);
}

double endOf(const Json& stage) {
  return stage.at("start").get<double>() + stage.at("t").back().get<double>();
}

}  // namespace handover::view::test
