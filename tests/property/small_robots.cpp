// SPDX-License-Identifier: Apache-2.0
#include "small_robots.hpp"

#include "core/collision/arm_self_collision.hpp"
#include "core/model_io/robot_loader.hpp"

#include <cmath>
#include <sstream>
#include <stdexcept>

namespace handover::test {
namespace {

std::string text(const Eigen::Vector3d& v) {
  std::ostringstream out;
  out.precision(17);
  out << v.x() << ' ' << v.y() << ' ' << v.z();
  return out.str();
}

/// Writes a chain of links with a gripper at its end.
class UrdfWriter {
 public:
  explicit UrdfWriter(const std::string& name) {
    out_.precision(17);
    out_ << "<?xml version=\"1.0\"?>\n<robot name=\"" << name << "\">\n";
    link("base", {-0.02, 0, -0.16}, {0.08, 0.08, 0.08});
  }

  /// A joint at `xyz` of the last link and the link beyond it, with a box (none if its size is 0).
  UrdfWriter& joint(const std::string& type, const Eigen::Vector3d& xyz,
                    const Eigen::Vector3d& axis, double lower, double upper,
                    const Eigen::Vector3d& box_middle = Eigen::Vector3d::Zero(),
                    const Eigen::Vector3d& box_size = Eigen::Vector3d::Zero()) {
    const std::string parent = last_;
    last_ = "l" + std::to_string(++joints_);
    link(last_, box_middle, box_size);
    out_ << "<joint name=\"j" << joints_ << "\" type=\"" << type << "\"><parent link=\"" << parent
         << "\"/><child link=\"" << last_ << "\"/><origin xyz=\"" << text(xyz) << "\"/><axis xyz=\""
         << text(axis) << "\"/><limit lower=\"" << lower << "\" upper=\"" << upper
         << "\" velocity=\"1\" effort=\"1\"/></joint>\n";
    return *this;
  }

  /// The gripper with its palm at `xyz` of the last link.
  std::string finish(const Eigen::Vector3d& xyz) {
    link("palm", {-0.02, 0, 0}, {0.04, 0.12, 0.02});
    link("tool", Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero());
    link("left_finger", {0.03, 0.005, 0}, {0.06, 0.01, 0.02});
    link("right_finger", {0.03, -0.005, 0}, {0.06, 0.01, 0.02});
    out_
        << "<joint name=\"palm_joint\" type=\"fixed\"><parent link=\"" << last_
        << "\"/><child link=\"palm\"/><origin xyz=\"" << text(xyz) << "\"/></joint>\n"
        << R"(<joint name="tool_joint" type="fixed"><parent link="palm"/><child link="tool"/><origin xyz="0.04 0 0"/></joint>
<joint name="left" type="prismatic"><parent link="palm"/><child link="left_finger"/><axis xyz="0 1 0"/><limit lower="0" upper="0.045" velocity="0.1" effort="1"/></joint>
<joint name="right" type="prismatic"><parent link="palm"/><child link="right_finger"/><axis xyz="0 -1 0"/><limit lower="0" upper="0.045" velocity="0.1" effort="1"/><mimic joint="left" multiplier="1" offset="0"/></joint>
</robot>
)";
    return out_.str();
  }

 private:
  void link(const std::string& name, const Eigen::Vector3d& middle, const Eigen::Vector3d& size) {
    out_ << "<link name=\"" << name << "\">";
    if (!size.isZero()) {
      out_ << "<collision><origin xyz=\"" << text(middle) << "\"/><geometry><box size=\""
           << text(size) << "\"/></geometry></collision>";
    }
    out_ << "</link>\n";
  }

  std::ostringstream out_;
  std::string last_ = "base";
  int joints_ = 0;
};

const Eigen::Vector3d kX(1, 0, 0), kY(0, 1, 0), kZ(0, 0, 1), kNone(0, 0, 0);

/// A box along x that leaves `gap` free at both ends of a link of that length.
struct Along {
  Along(double length, double gap)
      : middle(0.5 * length, 0, 0), size(length - 2 * gap, 0.04, 0.04) {}

  Eigen::Vector3d middle, size;
};

std::string planarUrdf(const std::string& name, const std::vector<double>& lengths, bool slide) {
  UrdfWriter urdf(name);
  if (slide) urdf.joint("prismatic", kNone, kZ, -0.25, 0.25);
  const Along upper(lengths[0], 0.04), fore(lengths[1], 0.04);
  return urdf.joint("revolute", kNone, kY, -2.9, 2.9, upper.middle, upper.size)
      .joint("revolute", {lengths[0], 0, 0}, kY, -2.6, 2.6, fore.middle, fore.size)
      .joint("revolute", {lengths[1], 0, 0}, kY, -2.2, 2.2)
      .finish({lengths[2] - Gripper::kPalmToTool, 0, 0});
}

std::string gantryUrdf(const std::string& name, const std::vector<double>& lengths) {
  return UrdfWriter(name)
      .joint("prismatic", kNone, kX, -0.2, lengths[0])
      .joint("prismatic", kNone, kY, -lengths[1], lengths[1])
      .joint("prismatic", kNone, kZ, -lengths[1], lengths[0], {-0.15, 0, 0}, {0.05, 0.05, 0.05})
      .joint("revolute", kNone, kZ, -3, 3)
      .joint("revolute", kNone, kY, -1.3, 1.3)
      .joint("revolute", kNone, kX, -3.1, 3.1)
      .finish(kNone);
}

std::string sevenAxisUrdf(const std::string& name, const std::vector<double>& lengths) {
  const Along upper(lengths[0], 0.05), fore(lengths[1], 0.05);
  return UrdfWriter(name)
      .joint("revolute", kNone, kZ, -3, 3)
      .joint("revolute", kNone, kY, -2, 2)
      .joint("revolute", kNone, kX, -3, 3, upper.middle, upper.size)
      .joint("revolute", {lengths[0], 0, 0}, kY, -2.3, 2.3)
      .joint("revolute", kNone, kX, -3, 3, fore.middle, fore.size)
      .joint("revolute", {lengths[1], 0, 0}, kY, -1.9, 1.9)
      .joint("revolute", kNone, kX, -3, 3)
      .finish({lengths[2] - Gripper::kPalmToTool, 0, 0});
}

constexpr const char* kSrdf = R"(<?xml version="1.0"?>
<robot name="NAME">
  <group name="arm"><chain base_link="base" tip_link="tool"/></group>
</robot>
)";

/// What follows for the verifier, in the words of a robot's file.
constexpr const char* kYaml = R"(version: 1
name: NAME
urdf: NAME.urdf
srdf: NAME.srdf
acceleration: 1
arms:
  arm: {tool_link: tool, approach_axis: [1, 0, 0], hand: gripper, acceleration: 1}
hands:
  gripper:
    palm_link: palm
    fingers: [[left]]
    finger_links: [left_finger, right_finger]
    open: {left: 0.045}
    closed: {left: 0}
    acceleration: 5
)";

std::string named(std::string text, const std::string& name) {
  for (auto at = text.find("NAME"); at != std::string::npos; at = text.find("NAME")) {
    text.replace(at, 4, name);
  }
  return text;
}

/// Turns of 2 pi added so that the angle is within the limits, if one is.
bool intoLimits(double& angle, double lower, double upper) {
  angle = std::remainder(angle, 2 * M_PI);
  for (const double turn : {0.0, 2 * M_PI, -2 * M_PI}) {
    if (angle + turn >= lower && angle + turn <= upper) {
      angle += turn;
      return true;
    }
  }
  return false;
}

/// Keeps a candidate if it is within limits and really puts the tool there.
void keepIfGood(const SmallRobot& robot, const Pose& X_BT, ArmVector q,
                std::vector<ArmVector>& kept) {
  const Arm& arm = robot.model->arms.front();
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const Joint& joint =
        robot.model->joints[static_cast<std::size_t>(arm.joints[static_cast<std::size_t>(i)])];
    if (joint.type == JointType::kPrismatic) {
      if (q[i] < joint.lower || q[i] > joint.upper) return;
    } else if (!intoLimits(q[i], joint.lower, joint.upper)) {
      return;
    }
  }
  RobotVector all = RobotVector::Zero(robot.model->dofs());
  for (Eigen::Index i = 0; i < q.size(); ++i)
    all[arm.dofs[static_cast<std::size_t>(i)].value()] = q[i];
  std::vector<Pose> X_BL;
  linkPoses(*robot.model, Pose::Identity(), all, X_BL);
  const Pose& X = X_BL[arm.tool_link];
  if ((X.matrix() - X_BT.matrix()).cwiseAbs().maxCoeff() < 1e-6) kept.push_back(q);
}

/// Three turns about y in the x-z plane, perhaps on a slide along z.
void planarConfigurations(const SmallRobot& robot, const Pose& X_BT, int steps,
                          std::vector<ArmVector>& found) {
  if (std::abs(X_BT.translation().y()) > 1e-7 || (X_BT.linear().col(1) - kY).norm() > 1e-7) return;
  const bool slide = robot.kind == RobotKind::kSlidingPlanar;
  const double a = robot.lengths[0], b = robot.lengths[1], c = robot.lengths[2];
  // Turning about y takes x towards -z: angles count in the plane of x and -z.
  const double phi = std::atan2(-X_BT.linear()(2, 0), X_BT.linear()(0, 0));
  const double x = X_BT.translation().x() - c * std::cos(phi);
  const double down_tool = -X_BT.translation().z() - c * std::sin(phi);
  for (int step = 0; step < (slide ? steps : 1); ++step) {
    const double height = slide ? -0.25 + 0.5 * step / (steps - 1) : 0;
    const double down = down_tool + height;
    const double cosine = (x * x + down * down - a * a - b * b) / (2 * a * b);
    if (std::abs(cosine) > 1) continue;
    for (const double sign : {1.0, -1.0}) {
      const double elbow = sign * std::acos(cosine);
      const double shoulder =
          std::atan2(down, x) - std::atan2(b * std::sin(elbow), a + b * std::cos(elbow));
      ArmVector q(slide ? 4 : 3);
      if (slide) q[0] = height;
      q.tail(3) << shoulder, elbow, phi - shoulder - elbow;
      keepIfGood(robot, X_BT, q, found);
    }
  }
}

/// Three slides, then turns about z, y, x in one point 0.04 m behind the tool.
void gantryConfigurations(const SmallRobot& robot, const Pose& X_BT,
                          std::vector<ArmVector>& found) {
  const Eigen::Matrix3d R = X_BT.linear();
  const Eigen::Vector3d wrist = X_BT.translation() - Gripper::kPalmToTool * R.col(0);
  const double level = std::hypot(R(0, 0), R(1, 0));
  for (const double sign : {1.0, -1.0}) {
    const double yaw = level > 1e-9 ? std::atan2(sign * R(1, 0), sign * R(0, 0)) : 0.0;
    const double pitch = std::atan2(-R(2, 0), sign * level);
    const Eigen::Matrix3d rest =
        (Eigen::AngleAxisd(yaw, kZ) * Eigen::AngleAxisd(pitch, kY)).toRotationMatrix().transpose() *
        R;
    ArmVector q(6);
    q << wrist, yaw, pitch, std::atan2(rest(2, 1), rest(1, 1));
    keepIfGood(robot, X_BT, q, found);
  }
}

}  // namespace

std::vector<ArmVector> SmallRobot::configurations(const Pose& X_BT, int steps) const {
  std::vector<ArmVector> found;
  switch (kind) {
    case RobotKind::kPlanar:
    case RobotKind::kSlidingPlanar:
      planarConfigurations(*this, X_BT, steps, found);
      break;
    case RobotKind::kGantry:
      gantryConfigurations(*this, X_BT, found);
      break;
    case RobotKind::kSevenAxes:
      IkQuery query;
      query.swivel_samples = steps;
      kinematics->solve(X_BT, query, found);
      break;
  }
  return found;
}

SmallRobots::SmallRobots() {
  for (int kind = 0; kind < kRobotKinds; ++kind) {
    for (int which = 0; which < kPerKind; ++which) {
      robots_.push_back(make(static_cast<RobotKind>(kind), which));
    }
  }
}

const SmallRobot& SmallRobots::get(RobotKind kind, int which) const {
  return robots_.at(static_cast<std::size_t>(static_cast<int>(kind) * kPerKind + which));
}

SmallRobot SmallRobots::make(RobotKind kind, int which) const {
  SmallRobot robot;
  robot.kind = kind;
  std::string name, urdf;
  std::uint64_t samples = 0;  // enough to fill the voxels that such an arm reaches
  switch (kind) {
    case RobotKind::kPlanar:
      name = "planar" + std::to_string(which);
      robot.lengths = which == 0 ? std::vector{0.35, 0.30, 0.14} : std::vector{0.45, 0.40, 0.12};
      urdf = planarUrdf(name, robot.lengths, false);
      samples = 60'000;
      break;
    case RobotKind::kSlidingPlanar:
      name = "sliding" + std::to_string(which);
      robot.lengths = which == 0 ? std::vector{0.30, 0.30, 0.12} : std::vector{0.40, 0.25, 0.16};
      urdf = planarUrdf(name, robot.lengths, true);
      samples = 60'000;
      break;
    case RobotKind::kGantry:
      name = "gantry" + std::to_string(which);
      robot.lengths = which == 0 ? std::vector{0.8, 0.4} : std::vector{0.6, 0.2};
      urdf = gantryUrdf(name, robot.lengths);
      samples = 300'000;
      break;
    case RobotKind::kSevenAxes:
      name = "seven" + std::to_string(which);
      robot.lengths = which == 0 ? std::vector{0.30, 0.30, 0.14} : std::vector{0.38, 0.34, 0.12};
      urdf = sevenAxisUrdf(name, robot.lengths);
      samples = 300'000;
      break;
  }
  folder_.write("robots/" + name + ".urdf", urdf);
  folder_.write("robots/" + name + ".srdf", named(kSrdf, name));
  folder_.write("robots/" + name + ".yaml", named(kYaml, name));

  RobotSettings settings;
  settings.name = name;
  settings.root = folder_.path();
  settings.urdf = "robots/" + name + ".urdf";
  settings.srdf = "robots/" + name + ".srdf";
  settings.yaml = "robots/" + name + ".yaml";
  settings.settings_file = name;
  ArmSettings arm;
  arm.name = "arm";
  arm.tool_link = "tool";
  arm.hand = "gripper";
  arm.approach_axis = kX;
  settings.arms = {arm};
  HandSettings hand;
  hand.name = "gripper";
  hand.palm_link = "palm";
  hand.fingers = {{"left"}};
  hand.finger_links = {"left_finger", "right_finger"};
  hand.open = {{"left", Gripper::kWidestOpening}};
  hand.closed = {{"left", 0.0}};
  settings.hands = {hand};
  robot.model = std::make_shared<const RobotModel>(loadRobot(settings));
  robot.kinematics = std::make_shared<const ArmKinematics>(*robot.model, ArmId(0));

  ReachabilityParams params;
  params.samples = samples;
  const RobotVector q = RobotVector::Zero(robot.model->dofs());
  const auto file = folder_ / (name + ".map");
  ArmSelfCollision self(*robot.model, ArmId(0), q);
  const auto built = ReachabilityMap::build(*robot.model, q, params,
                                            {[&](const ArmVector& at) { return self.touches(at); }},
                                            {file}, {}, Deadline());
  if (!built) throw std::runtime_error(built.error().detail);
  const auto map =
      ReachabilityMap::open(file, ReachabilityMap::hash(*robot.model, ArmId(0), q, params));
  if (!map) throw std::runtime_error(map.error().detail);
  robot.map = *map;
  return robot;
}

}  // namespace handover::test
