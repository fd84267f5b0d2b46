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
#include <utility>

namespace handover::verify::test {
namespace {

// Wrist of three joints after x, y, z; palm at the wrist's origin, approach along +x, the tool link
// 40 mm before it.
constexpr const char* kArm = R"(
  <link name="base"><collision><origin xyz="0 0 -0.5"/><geometry><box size="0.05 0.05 0.05"/></geometry></collision></link>
  <link name="x_link"/>
  <link name="y_link"/>
  <link name="z_link"><collision><origin xyz="-0.15 0 0"/><geometry><box size="0.05 0.05 0.05"/></geometry></collision></link>
  <link name="wrist_1"/>
  <link name="wrist_2"/>
  <link name="wrist_3"/>
  <link name="palm"><collision><origin xyz="-0.02 0 0"/><geometry><box size="0.04 0.12 0.02"/></geometry></collision></link>
  <link name="tool"/>
  <joint name="x" type="prismatic"><parent link="base"/><child link="x_link"/><axis xyz="1 0 0"/><limit lower="-0.5" upper="1.5" velocity="0.5" effort="1"/></joint>
  <joint name="y" type="prismatic"><parent link="x_link"/><child link="y_link"/><axis xyz="0 1 0"/><limit lower="-0.5" upper="0.5" velocity="0.5" effort="1"/></joint>
  <joint name="z" type="prismatic"><parent link="y_link"/><child link="z_link"/><axis xyz="0 0 1"/><limit lower="-0.5" upper="1.5" velocity="0.5" effort="1"/></joint>
  <joint name="yaw" type="revolute"><parent link="z_link"/><child link="wrist_1"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
  <joint name="pitch" type="revolute"><parent link="wrist_1"/><child link="wrist_2"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
  <joint name="roll" type="revolute"><parent link="wrist_2"/><child link="wrist_3"/><axis xyz="1 0 0"/><limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
  <joint name="palm_joint" type="fixed"><parent link="wrist_3"/><child link="palm"/></joint>
  <joint name="tool_joint" type="fixed"><parent link="palm"/><child link="tool"/><origin xyz="0.04 0 0"/></joint>
)";

// They close along y; the right one mimics.
constexpr const char* kFingers = R"(
  <link name="left_finger"><collision><origin xyz="0.03 0.005 0"/><geometry><box size="0.06 0.01 0.02"/></geometry></collision></link>
  <link name="right_finger"><collision><origin xyz="0.03 -0.005 0"/><geometry><box size="0.06 0.01 0.02"/></geometry></collision></link>
  <joint name="left" type="prismatic"><parent link="palm"/><child link="left_finger"/><axis xyz="0 1 0"/><limit lower="0" upper="0.045" velocity="0.1" effort="1"/></joint>
  <joint name="right" type="prismatic"><parent link="palm"/><child link="right_finger"/><axis xyz="0 -1 0"/><limit lower="0" upper="0.045" velocity="0.1" effort="1"/><mimic joint="left" multiplier="1" offset="0"/></joint>
)";

// From the palm to the tool link.
constexpr const char* kCup = R"(
  <link name="cup"><collision><geometry><box size="0.04 0.02 0.02"/></geometry></collision></link>
  <joint name="cup_joint" type="fixed"><parent link="palm"/><child link="cup"/><origin xyz="0.02 0 0"/></joint>
)";

std::string urdf(bool suction) {
  return std::string("<?xml version=\"1.0\"?>\n<robot name=\"gantry\">") + kArm +
         (suction ? kCup : kFingers) + "</robot>\n";
}

constexpr const char* kSrdf = R"(<?xml version="1.0"?>
<robot name="gantry">
  <group name="arm"><chain base_link="base" tip_link="tool"/></group>
</robot>
)";

std::string yaml(bool suction) {
  std::string text =
      "version: 1\nacceleration: 1\narms:\n"
      "  arm: {tool_link: tool, hand: hand, acceleration: 1}\n";
  text += suction
              ? "hands:\n  hand: {suction: {cup_link: cup, axis: [1, 0, 0], radius: 0.01}}\n"
              : "hands:\n  hand: {palm_link: palm, fingers: [[left]], acceleration: 1, jerk: 20}\n";
  return text;
}

using Vector = std::vector<double>;

constexpr double kOpen = 0.04;
constexpr double kHalf = 0.02;  // of the box
constexpr double kGrip = 0.03;  // above or below the box's middle
constexpr double kPi = 3.14159265358979323846;

const std::vector<std::string> kJoints = {"x", "y", "z", "yaw", "pitch", "roll"};

struct Station {
  const char* robot;
  Vector base;  ///< x, y
  double yaw;   ///< of the base: where the arm approaches to
  double grip;  ///< of the tool above the box's middle
  Vector rest;  ///< tool at the start
};

const std::vector<Station>& stations() {
  static const std::vector<Station> kStations = {
      {"g", {-0.8, 0}, 0, -kGrip, {-0.6, 0, 0.2}},
      {"r", {0.8, 0}, kPi, kGrip, {0.6, 0, 0.2}},
      {"t", {0.2, -1.2}, kPi / 2, -kGrip, {0.2, -0.6, 0.2}}};
  return kStations;
}

/// Gantry positions that put the tool at a place in the world.
Vector armAt(const Station& station, const Vector& tool) {
  const double dx = tool[0] - station.base[0], dy = tool[1] - station.base[1];
  const double c = std::cos(station.yaw), s = std::sin(station.yaw);
  return {c * dx + s * dy - 0.04, -s * dx + c * dy, tool[2], 0, 0, 0};
}

Vector quatOfYaw(double yaw) { return {std::cos(yaw / 2), 0, 0, std::sin(yaw / 2)}; }

struct Knot {
  Vector q, qd;  ///< qdd is 0 at every knot
};

/// Through the knots; each leg is one quintic, given by several samples.
void fillMotion(Json& stage, const std::vector<Knot>& knots, double velocity, double acceleration,
                double jerk) {
  constexpr int kSamples = 10;
  const std::size_t joints = knots.front().q.size();
  Json t = {0.0}, q = {knots.front().q}, qd = {knots.front().qd}, qdd = {Vector(joints, 0.0)};
  double now = 0;
  for (std::size_t leg = 0; leg + 1 < knots.size(); ++leg) {
    const Knot& from = knots[leg];
    const Knot& to = knots[leg + 1];
    double distance = 0;
    for (std::size_t j = 0; j < joints; ++j) {
      distance = std::max(distance, std::abs(to.q[j] - from.q[j]));
    }
    const double duration =
        1.01 * std::max({1.875 * distance / velocity, std::sqrt(5.7736 * distance / acceleration),
                         std::cbrt(60 * distance / jerk)});
    for (int k = 1; k <= kSamples; ++k) {
      const double u = static_cast<double>(k) / kSamples;
      Vector row, rate, change;
      for (std::size_t j = 0; j < joints; ++j) {
        const double d = to.q[j] - from.q[j];
        const double v0 = from.qd[j] * duration, v1 = to.qd[j] * duration;
        const double c3 = 10 * d - 6 * v0 - 4 * v1, c4 = -15 * d + 8 * v0 + 7 * v1,
                     c5 = 6 * d - 3 * v0 - 3 * v1;
        const bool end = k == kSamples;
        row.push_back(end ? to.q[j] : from.q[j] + u * (v0 + u * u * (c3 + u * (c4 + u * c5))));
        rate.push_back(end ? to.qd[j]
                           : (v0 + u * u * (3 * c3 + u * (4 * c4 + u * 5 * c5))) / duration);
        change.push_back(end ? 0
                             : u * (6 * c3 + u * (12 * c4 + u * 20 * c5)) / duration / duration);
      }
      t.push_back(now + duration * u);
      q.push_back(row);
      qd.push_back(rate);
      qdd.push_back(change);
    }
    now += duration;
  }
  stage["t"] = t;
  stage["q"] = q;
  stage["qd"] = qd;
  stage["qdd"] = qdd;
}

class PlanMaker {
 public:
  explicit PlanMaker(const PlanOptions& options) : options_(options) {
    // Where the box is: at the start, at each handover, at the goal.
    places_ = {{-0.3, 0, 0.06}};
    if (options.held_at_start) {
      const Vector& rest = stations()[0].rest;
      places_[0] = {rest[0] + (options.suction ? kHalf + 0.0005 : 0), rest[1], rest[2] + kGrip};
    }
    if (options.holders > 1) places_.push_back({0, 0, 0.4});
    if (options.holders > 2) places_.push_back({0.2, -0.1, 0.4});
    const std::vector<Vector> goals = {{-0.2, 0.1, 0.06}, {0.3, 0, 0.06}, {0.2, -0.2, 0.06}};
    const std::vector<Vector> kept = {{-0.2, 0.1, 0.3}, {0.3, 0, 0.3}, {0.2, -0.2, 0.3}};
    places_.push_back(
        (options.ends_held ? kept : goals)[static_cast<std::size_t>(options.holders - 1)]);
    scene();
    holders();
  }

  Json make() {
    for (int k = 0; k < options_.holders; ++k) {
      if (k > 0 || !options_.held_at_start) {
        take(k);
      }
      if (k > 0) leave(k - 1);
      carry(k);
    }
    if (!options_.ends_held) {
      const int last = options_.holders - 1;
      arm(last, "place", {at(last, above(places_.back())), at(last, places_.back())});
      leave(last);
    }
    startEarly(file_);
    describeStages();
    return file_;
  }

 private:
  // ---- scene -------------------------------------------------------------------------------

  void scene() {
    file_ = {{"format", "handover-plan/2"},
             {"complete", true},
             {"timing", {{"scene_revision", 1}}},
             {"funnel", Json::object()},
             {"explanation", nullptr},
             {"quality", nullptr},
             {"scene", Json::object()},
             {"plan", Json::object()}};
    Json& scene = file_["scene"];
    scene = {{"cell", "gantries"},   {"task", "give"},  {"seed", 1},
             {"scene_hash", "0af3"}, {"object", "box"}, {"upright", nullptr}};
    scene["robots"] = Json::array();
    for (int k = 0; k < std::max(2, options_.holders); ++k) {
      scene["robots"].push_back(robotEntry(k));
    }
    // A sign on the second arm: attached, so held in every stage.
    Json sign = boxObject("sign", {}, {0.79, 0, 0.25});
    sign["geometry"] = {{"type", "cylinder"}, {"radius", 0.01}, {"length", 0.05}};
    sign["X_WO"] = pose({0.79, 0, 0.25}, {0, 0, 0, 1});
    sign["attached_to"] = {{"robot", "r"},
                           {"link", "z_link"},
                           {"X_LO", pose({-0.15, 0, 0.05})},
                           {"touch_links", Json::array()}};
    scene["objects"] = {boxObject("box", {2 * kHalf, 2 * kHalf, 0.12}, places_.front()),
                        boxObject("table", {0.4, 0.4, 0.02}, {-0.3, 0, -0.01}),
                        boxObject("shelf", {0.4, 0.6, 0.02}, {0.3, 0, -0.01}),
                        boxObject("post", {0.1, 0.1, 0.8}, {0, 0.5, 0.4}), sign};
    scene["start"] = {{"X_WO", pose(places_.front())}, {"held_by", nullptr}, {"rest", {"table"}}};
    if (options_.held_at_start) {
      scene["start"]["held_by"] = "g/arm";
      scene["start"]["rest"] = Json::array();
    }
    scene["goal"] = {{"X_WO", pose(places_.back())},
                     {"end", options_.ends_held ? "hold" : "release"},
                     {"rest", {options_.holders == 1 ? "table" : "shelf"}}};
    if (options_.ends_held) scene["goal"]["rest"] = Json::array();
    if (options_.upright) scene["upright"] = {{"axis", {0, 0, 1}}, {"within_deg", 10}};
  }

  Json robotEntry(int k) const {
    const Station& station = stations()[static_cast<std::size_t>(k)];
    const std::string file = options_.suction ? "robots/cup/cup" : "robots/gantry/gantry";
    const Vector start = armAt(station, station.rest);
    Json q_start, limits;
    for (std::size_t j = 0; j < kJoints.size(); ++j) q_start[kJoints[j]] = start[j];
    limits["x"] = limits["z"] = {-0.5, 1.5, 0.5, 1, 10};
    limits["y"] = {-0.5, 0.5, 0.5, 1, 10};
    limits["yaw"] = limits["roll"] = {-3, 3, 1, 1, 10};
    limits["pitch"] = {-1, 1, 1, 1, 10};
    if (!options_.suction) {
      q_start["left"] = q_start["right"] =
          k == 0 && options_.held_at_start ? options_.closed : kOpen;
      limits["left"] = limits["right"] = {0, 0.045, 0.1, 1, 20};
    }
    return {{"name", station.robot},
            {"urdf", file + ".urdf"},
            {"urdf_sha256", sha256(urdf(options_.suction))},
            {"srdf", file + ".srdf"},
            {"yaml", file + ".yaml"},
            {"yaml_sha256", sha256(yaml(options_.suction))},
            {"X_WB", pose({station.base[0], station.base[1], 0}, quatOfYaw(station.yaw))},
            {"q_start", q_start},
            {"limits", limits},
            {"resting", Json::array()}};
  }

  /// Of the tool in the box.
  Vector gripOf(int k) const {
    const Station& station = stations()[static_cast<std::size_t>(k)];
    const double back = options_.suction ? kHalf + 0.0005 : 0;
    return {-back * std::cos(station.yaw), -back * std::sin(station.yaw), station.grip};
  }

  void holders() {
    Json& plan = file_["plan"];
    plan = {{"holders", Json::array()},
            {"handovers", Json::array()},
            {"stages", Json::array()},
            {"slack_s", options_.slack}};
    for (int k = 0; k < options_.holders; ++k) {
      const Station& station = stations()[static_cast<std::size_t>(k)];
      Json hand = {{"palm", "palm"}, {"fingers", {"left_finger", "right_finger"}}};
      if (options_.suction) hand = {{"cup_link", "cup"}, {"axis", {1, 0, 0}}, {"radius", 0.01}};
      // J is the identity but for lever arms, so det(J J^T) = 1.
      plan["holders"].push_back({{"robot", station.robot},
                                 {"arm", "arm"},
                                 {"tool_link", "tool"},
                                 {"gripper", options_.suction ? "suction" : "fingers"},
                                 {"hand", hand},
                                 {"X_OT", pose(gripOf(k), quatOfYaw(station.yaw))},
                                 {"dexterity", {{"take", 1}, {"give", 1}}}});
      if (k > 0) plan["handovers"].push_back(pose(places_[static_cast<std::size_t>(k)]));
    }
  }

  // ---- stages ------------------------------------------------------------------------------

  /// The arm's joints when the tool has the box there.
  Vector at(int k, const Vector& box) const {
    const Vector grip = gripOf(k);
    return armAt(stations()[static_cast<std::size_t>(k)],
                 {box[0] + grip[0], box[1] + grip[1], box[2] + grip[2]});
  }

  static Vector above(Vector box) {
    box[2] += 0.06;
    return box;
  }

  /// Backwards, against the direction of approach.
  static Vector behind(Vector q, double by) {
    q[0] -= by;
    return q;
  }

  Vector home(int k) const {
    const Station& station = stations()[static_cast<std::size_t>(k)];
    return armAt(station, station.rest);
  }

  void take(int k) {
    const Vector there = at(k, places_[static_cast<std::size_t>(k)]);
    arm(k, "reach", {home(k), behind(there, 0.15)});
    arm(k, "approach", {behind(there, 0.15), there});
    if (k > 0) after(indexOf(k - 1, "carry"));
    hand(k, "grasp", kOpen, options_.closed);
    if (k > 0) after(indexOf(k - 1, "carry"));
    if (k > 0) return;
    Vector lifted = there;
    lifted[2] += 0.05;
    if (options_.joined) {
      Vector up(there.size(), 0.0);
      up[2] = 0.1;
      arm(k, "lift", {there, lifted}, {}, up);
    } else {
      arm(k, "lift", {there, lifted});
    }
  }

  void carry(int k) {
    const auto place = static_cast<std::size_t>(k);
    Vector from = at(k, places_[place]);
    if (k == 0 && !options_.held_at_start) from[2] += 0.05;
    const bool last = k == options_.holders - 1;
    const Vector to = last && !options_.ends_held ? above(places_[place + 1]) : places_[place + 1];
    Vector speed;
    if (k == 0 && !options_.held_at_start && options_.joined) {
      speed.assign(from.size(), 0.0);
      speed[2] = 0.1;
    }
    arm(k, "carry", {from, at(k, to)}, speed, {});
    if (k == 0) return;
    after(indexOf(k - 1, "release"));
    const int retreat = indexOf(k - 1, "retreat");
    file_["plan"]["stages"].back()["after"].push_back({retreat, leavingTime(retreat)});
  }

  void leave(int k) {
    const Vector there = at(k, places_[static_cast<std::size_t>(k) + 1]);
    hand(k, "release", options_.closed, kOpen);
    if (k + 1 < options_.holders) after(indexOf(k + 1, "grasp"));
    Vector speed;
    if (options_.joined) {
      speed.assign(there.size(), 0.0);
      speed[0] = -0.1;
    }
    const Vector back = behind(there, k + 1 < options_.holders ? 0.15 : options_.last_retreat);
    arm(k, "retreat", {there, back}, {}, speed);
    arm(k, "home", {back, home(k)}, speed, {});
  }

  int indexOf(int k, const std::string& action) {
    return stage(file_, k, action)["index"].get<int>();
  }

  void after(int earlier) {
    Json& stages = file_["plan"]["stages"];
    stages.back()["after"].push_back(
        {earlier, stages[static_cast<std::size_t>(earlier)]["t"].back()});
  }

  /// When the tool has gone back by 5 mm.
  double leavingTime(int retreat) {
    const Json& stage = file_["plan"]["stages"][static_cast<std::size_t>(retreat)];
    const Vector t = stage["t"], first = stage["q"][0];
    for (std::size_t k = 0; k + 1 < t.size(); ++k) {
      const double h = t[k + 1] - t[k];
      for (int part = 1; part <= 1000; ++part) {
        const double u = part / 1000.0;
        const double d = stage["q"][k + 1][0].get<double>() - stage["q"][k][0].get<double>();
        const double v0 = stage["qd"][k][0].get<double>() * h;
        const double v1 = stage["qd"][k + 1][0].get<double>() * h;
        const double a0 = stage["qdd"][k][0].get<double>() * h * h;
        const double a1 = stage["qdd"][k + 1][0].get<double>() * h * h;
        const double x = stage["q"][k][0].get<double>() + u * v0 + u * u * a0 / 2 +
                         u * u * u * (10 * d - 6 * v0 - 4 * v1 - 1.5 * a0 + a1 / 2) +
                         u * u * u * u * (-15 * d + 8 * v0 + 7 * v1 + 1.5 * a0 - a1) +
                         u * u * u * u * u * (6 * d - 3 * v0 - 3 * v1 - a0 / 2 + a1 / 2);
        if (first[0] - x >= 5e-3) return t[k] + u * h;
      }
    }
    return t.back();
  }

  void add(int k, const std::string& action, Json stage) {
    Json& stages = file_["plan"]["stages"];
    const char* robot = stations()[static_cast<std::size_t>(k)].robot;
    stage["index"] = stages.size();
    stage["holder"] = k;
    stage["action"] = action;
    stage["robot"] = robot;
    stage["start"] = 0;
    stage["after"] = Json::array();
    for (std::size_t s = stages.size(); s-- > 0;) {
      if (stages[s]["robot"] != robot) continue;
      stage["after"].push_back({s, stages[s]["t"].back()});
      break;
    }
    stages.push_back(std::move(stage));
  }

  void arm(int k, const std::string& action, const std::vector<Vector>& postures,
           const Vector& first_speed = {}, const Vector& last_speed = {}) {
    std::vector<Knot> knots;
    for (const Vector& q : postures) knots.push_back({q, Vector(q.size(), 0.0)});
    if (!first_speed.empty()) knots.front().qd = first_speed;
    if (!last_speed.empty()) knots.back().qd = last_speed;
    Json stage = {{"joints", kJoints}};
    fillMotion(stage, knots, 0.5, 1, 10);
    add(k, action, std::move(stage));
  }

  void hand(int k, const std::string& action, double from, double to) {
    Json stage = {{"joints", {"left"}}};
    if (options_.suction) {
      stage = {{"joints", Json::array()}, {"t", {0, 0.3}}};
      stage["q"] = stage["qd"] = stage["qdd"] = {Json::array(), Json::array()};
    } else {
      fillMotion(stage, {{{from}, {0}}, {{to}, {0}}}, 0.1, 1, 20);
    }
    add(k, action, std::move(stage));
  }

  // ---- what follows from the times ---------------------------------------------------------

  double startOf(const Json& stage) const { return stage["start"]; }

  double endOf(const Json& stage) const {
    return stage["start"].get<double>() + stage["t"].back().get<double>();
  }

  void describeStages() {
    for (Json& entry : file_["plan"]["stages"]) {
      const double from = startOf(entry), to = endOf(entry);
      entry["holding"] = Json::array();
      entry["may_touch"] = Json::array();
      for (int k = 0; k < options_.holders; ++k) describeHand(k, from, to, entry);
      entry["holding"].push_back({{"object", "sign"},
                                  {"robot", "r"},
                                  {"link", "z_link"},
                                  {"X_LO", pose({-0.15, 0, 0.05})}});
      if (!options_.held_at_start && from < endOf(stage(file_, 0, "lift"))) {
        entry["may_touch"].push_back({"box", "table"});
      }
      if (!options_.ends_held && to > startOf(stage(file_, options_.holders - 1, "place"))) {
        entry["may_touch"].push_back({"box", options_.holders == 1 ? "table" : "shelf"});
      }
    }
  }

  void describeHand(int k, double from, double to, Json& entry) {
    constexpr double kForever = 1e9;
    const bool starts = k == 0 && options_.held_at_start;
    const bool keeps = k == options_.holders - 1 && options_.ends_held;
    const double taken = starts ? -kForever : endOf(stage(file_, k, "grasp"));
    const double touched = starts ? -kForever : startOf(stage(file_, k, "grasp"));
    const double given = keeps ? kForever : endOf(stage(file_, k, "release"));
    const double left =
        keeps ? kForever : startOf(stage(file_, k, "retreat")) + leavingTime(indexOf(k, "retreat"));
    const Station& station = stations()[static_cast<std::size_t>(k)];
    if (taken <= from + 1e-9 && from < given - 1e-9) {
      // The inverse of X_OT, seen from the tool for the first, from the palm for others.
      const double back = options_.suction ? kHalf + 0.0005 : 0;
      const double ahead = back + (k == 0 ? 0 : 0.04);
      entry["holding"].push_back(
          {{"object", "box"},
           {"robot", station.robot},
           {"link", k == 0 ? "tool" : "palm"},
           {"X_LO", pose({ahead, 0, -station.grip}, quatOfYaw(-station.yaw))}});
    }
    if (std::min(to, left) - std::max(from, touched) > 1e-9) {
      const std::vector<const char*> links =
          options_.suction ? std::vector<const char*>{"cup"}
                           : std::vector<const char*>{"palm", "left_finger", "right_finger"};
      for (const char* link : links) {
        entry["may_touch"].push_back({std::string(station.robot) + "/" + link, "box"});
      }
    }
  }

  PlanOptions options_;
  Json file_;
  std::vector<Vector> places_;
};

Json& named(Json& entries, const std::string& name) {
  for (Json& entry : entries) {
    if (entry.at("name") == name) return entry;
  }
  throw std::out_of_range(name);
}

}  // namespace

GantryCell::GantryCell() {
  for (const bool suction : {false, true}) {
    const std::string file = suction ? "robots/cup/cup" : "robots/gantry/gantry";
    write(file + ".urdf", urdf(suction));
    write(file + ".srdf", kSrdf);
    write(file + ".yaml", yaml(suction));
  }
}

void GantryCell::write(const std::string& file, const std::string& text) const {
  root_.write(file, text);
}

Json GantryCell::plan(const PlanOptions& options) const { return PlanMaker(options).make(); }

Json& stage(Json& file, int holder, const std::string& action) {
  for (Json& entry : file["plan"]["stages"]) {
    if (entry["holder"] == holder && entry["action"] == action) return entry;
  }
  throw std::out_of_range(action);
}

Json& object(Json& file, const std::string& name) { return named(file["scene"]["objects"], name); }

Json& robot(Json& file, const std::string& name) { return named(file["scene"]["robots"], name); }

void startEarly(Json& file) {
  Json& stages = file["plan"]["stages"];
  for (Json& entry : stages) entry["start"] = 0.0;
  for (std::size_t round = 0; round < stages.size(); ++round) {
    for (Json& entry : stages) {
      for (const Json& edge : entry["after"]) {
        const double earliest =
            stages[edge[0].get<std::size_t>()]["start"].get<double>() + edge[1].get<double>();
        entry["start"] = std::max(entry["start"].get<double>(), earliest);
      }
    }
  }
}

Json pose(const std::vector<double>& xyz, const std::vector<double>& quat) {
  return {{"xyz", xyz}, {"quat_wxyz", quat}};
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
