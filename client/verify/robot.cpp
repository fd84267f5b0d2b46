// SPDX-License-Identifier: Apache-2.0
#include "verify/robot.hpp"

#include "verify/find_by_name.hpp"
#include "verify/unreadable.hpp"

#include <tinyxml2.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>

namespace handover::verify {
namespace {

using Element = tinyxml2::XMLElement;

constexpr std::size_t kMaxLinks = 1000;

/// An XML file whose faults are named by line.
class XmlFile {
 public:
  explicit XmlFile(std::filesystem::path path) : path_(std::move(path)) {
    if (document_.LoadFile(path_.c_str()) != tinyxml2::XML_SUCCESS) {
      throw Unreadable(path_.string(), document_.ErrorStr());
    }
  }

  const Element& root(const char* name) const {
    const Element* element = document_.FirstChildElement(name);
    if (!element) throw Unreadable(path_.string(), std::string("no <") + name + "> element");
    return *element;
  }

  [[noreturn]] void fail(const Element& element, const std::string& what) const {
    throw Unreadable(path_.string() + ":" + std::to_string(element.GetLineNum()), what);
  }

  std::string attribute(const Element& element, const char* name) const {
    const char* text = element.Attribute(name);
    if (!text || !*text) fail(element, std::string("attribute ") + name + " is missing");
    return text;
  }

  /// `count` numbers of an attribute, whatever the locale; nullopt when it is not there.
  std::optional<std::vector<double>> numbers(const Element& element, const char* name,
                                             std::size_t count) const {
    const char* text = element.Attribute(name);
    if (!text) return std::nullopt;
    std::vector<double> result;
    const char* at = text;
    const char* const end = text + std::string_view(text).size();
    while (true) {
      while (at != end && (*at == ' ' || *at == '\t' || *at == '\n' || *at == '\r')) ++at;
      if (at == end) break;
      if (*at == '+') ++at;
      double value = 0;
      const auto [next, error] = std::from_chars(at, end, value);
      if (error != std::errc() || !std::isfinite(value)) {
        fail(element, std::string("attribute ") + name + " is not a number: " + text);
      }
      result.push_back(value);
      at = next;
    }
    if (result.size() != count) {
      fail(element,
           std::string("attribute ") + name + " needs " + std::to_string(count) + " number(s)");
    }
    return result;
  }

  double number(const Element& element, const char* name, std::optional<double> fallback) const {
    const auto value = numbers(element, name, 1);
    if (value) return value->front();
    if (!fallback) fail(element, std::string("attribute ") + name + " is missing");
    return *fallback;
  }

  Eigen::Vector3d vector3(const Element& element, const char* name,
                          const Eigen::Vector3d& fallback) const {
    const auto value = numbers(element, name, 3);
    return value ? Eigen::Vector3d((*value)[0], (*value)[1], (*value)[2]) : fallback;
  }

  /// <origin xyz rpy> below the element.
  Pose origin(const Element& element) const {
    Pose X = Pose::Identity();
    if (const Element* origin = element.FirstChildElement("origin")) {
      X.translation() = vector3(*origin, "xyz", Eigen::Vector3d::Zero());
      X.linear() = rotationFromRpy(vector3(*origin, "rpy", Eigen::Vector3d::Zero()));
    }
    return X;
  }

 private:
  std::filesystem::path path_;
  tinyxml2::XMLDocument document_;
};

Geometry readGeometry(const XmlFile& file, const Element& element) {
  const auto positive = [&](const Element& shape, const char* name) {
    const double value = file.number(shape, name, std::nullopt);
    if (value <= 0) file.fail(shape, std::string(name) + " must be positive");
    return value;
  };
  if (const Element* box = element.FirstChildElement("box")) {
    const Eigen::Vector3d size = file.vector3(*box, "size", Eigen::Vector3d::Zero());
    if (size.minCoeff() <= 0) file.fail(*box, "size must be positive");
    return Box{size};
  }
  if (const Element* sphere = element.FirstChildElement("sphere")) {
    return Sphere{positive(*sphere, "radius")};
  }
  if (const Element* cylinder = element.FirstChildElement("cylinder")) {
    return Cylinder{positive(*cylinder, "radius"), positive(*cylinder, "length")};
  }
  if (const Element* mesh = element.FirstChildElement("mesh")) {
    const Eigen::Vector3d scale = file.vector3(*mesh, "scale", Eigen::Vector3d::Ones());
    if (scale.cwiseAbs().minCoeff() <= 0) file.fail(*mesh, "scale must not be zero");
    return MeshFile{file.attribute(*mesh, "filename"), scale};
  }
  file.fail(element, "geometry without box, sphere, cylinder or mesh");
}

struct RawJoint {
  Joint joint;
  std::string parent, child, mimic;
  const Element* element = nullptr;
};

RawJoint readJoint(const XmlFile& file, const Element& element) {
  RawJoint raw;
  raw.element = &element;
  Joint& joint = raw.joint;
  joint.name = file.attribute(element, "name");
  const std::string type = file.attribute(element, "type");
  if (type == "fixed") {
    joint.type = JointType::kFixed;
  } else if (type == "revolute") {
    joint.type = JointType::kRevolute;
  } else if (type == "continuous") {
    joint.type = JointType::kContinuous;
  } else if (type == "prismatic") {
    joint.type = JointType::kPrismatic;
  } else {
    file.fail(element, "joint type " + type + " is not supported");
  }
  const Element* parent = element.FirstChildElement("parent");
  const Element* child = element.FirstChildElement("child");
  if (!parent || !child) file.fail(element, "joint without parent or child");
  raw.parent = file.attribute(*parent, "link");
  raw.child = file.attribute(*child, "link");
  joint.X_PJ = file.origin(element);
  if (!joint.movable()) return raw;

  if (const Element* axis = element.FirstChildElement("axis")) {
    joint.axis = file.vector3(*axis, "xyz", Eigen::Vector3d::UnitX());
    if (joint.axis.norm() < 1e-6) file.fail(*axis, "axis of no length");
    joint.axis.normalize();
  }
  const Element* limit = element.FirstChildElement("limit");
  if (!limit && joint.type != JointType::kContinuous) file.fail(element, "joint without limit");
  if (limit) joint.velocity = file.number(*limit, "velocity", 0);
  if (joint.type != JointType::kContinuous) {
    joint.lower = file.number(*limit, "lower", 0);
    joint.upper = file.number(*limit, "upper", 0);
    if (joint.lower > joint.upper) file.fail(*limit, "lower above upper");
  }
  if (const Element* mimic = element.FirstChildElement("mimic")) {
    raw.mimic = file.attribute(*mimic, "joint");
    joint.multiplier = file.number(*mimic, "multiplier", 1);
    joint.offset = file.number(*mimic, "offset", 0);
  }
  return raw;
}

/// Puts links and joints in topological order and resolves names.
void assemble(const XmlFile& file, const Element& root, std::map<std::string, Link> links,
              const std::vector<RawJoint>& raw, Robot& robot) {
  std::map<std::string, const RawJoint*> above;
  for (const RawJoint& joint : raw) {
    if (!links.count(joint.parent) || !links.count(joint.child)) {
      file.fail(*joint.element, "joint of an unknown link");
    }
    if (!above.emplace(joint.child, &joint).second) {
      file.fail(*joint.element, "link " + joint.child + " has two parents");
    }
  }
  std::vector<std::string> roots;
  for (const auto& [name, link] : links) {
    if (!above.count(name)) roots.push_back(name);
  }
  if (roots.size() != 1) {
    file.fail(root, std::to_string(roots.size()) + " root links instead of one");
  }
  robot.links.push_back(links.at(roots.front()));
  std::vector<const RawJoint*> order;
  for (std::size_t at = 0; at < robot.links.size(); ++at) {
    for (const RawJoint& joint : raw) {
      if (joint.parent != robot.links[at].name) continue;
      Joint placed = joint.joint;
      placed.parent = static_cast<int>(at);
      placed.child = static_cast<int>(robot.links.size());
      Link link = links.at(joint.child);
      link.parent_joint = static_cast<int>(robot.joints.size());
      robot.links.push_back(link);
      robot.joints.push_back(placed);
      order.push_back(&joint);
    }
  }
  if (robot.links.size() != links.size()) file.fail(root, "links that do not hang from the root");
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (order[i]->mimic.empty()) continue;
    const int master = robot.findJoint(order[i]->mimic);
    if (master < 0 || !robot.joints[static_cast<std::size_t>(master)].movable()) {
      file.fail(*order[i]->element, "mimics an unknown joint");
    }
    robot.joints[i].mimic = master;
  }
  for (std::size_t i = 0; i < order.size(); ++i) {
    std::size_t steps = 0;
    for (int j = static_cast<int>(i); j >= 0; j = robot.joints[static_cast<std::size_t>(j)].mimic) {
      if (++steps > order.size()) file.fail(*order[i]->element, "mimics itself");
    }
  }
}

void readUrdf(const std::filesystem::path& path, Robot& robot) {
  const XmlFile file(path);
  const Element& root = file.root("robot");
  robot.name = file.attribute(root, "name");
  robot.urdf = path;
  std::map<std::string, Link> links;
  for (const Element* e = root.FirstChildElement("link"); e; e = e->NextSiblingElement("link")) {
    Link link;
    link.name = file.attribute(*e, "name");
    for (const Element* c = e->FirstChildElement("collision"); c;
         c = c->NextSiblingElement("collision")) {
      const Element* geometry = c->FirstChildElement("geometry");
      if (!geometry) file.fail(*c, "collision without geometry");
      link.collision.push_back({file.origin(*c), readGeometry(file, *geometry)});
    }
    if (!links.emplace(link.name, link).second) file.fail(*e, "link " + link.name + " twice");
    if (links.size() > kMaxLinks) file.fail(*e, "too many links");
  }
  std::vector<RawJoint> joints;
  std::set<std::string> names;
  for (const Element* e = root.FirstChildElement("joint"); e; e = e->NextSiblingElement("joint")) {
    joints.push_back(readJoint(file, *e));
    if (!names.insert(joints.back().joint.name).second) {
      file.fail(*e, "joint " + joints.back().joint.name + " twice");
    }
  }
  assemble(file, root, std::move(links), joints, robot);
}

/// Joints of the SRDF's groups by name, as MoveIt reads them: what the URDF does not have is left
/// out.
class GroupReader {
 public:
  GroupReader(const XmlFile& file, const Element& root, const Robot& robot)
      : file_(file), robot_(robot) {
    for (const Element* e = root.FirstChildElement("group"); e;
         e = e->NextSiblingElement("group")) {
      elements_.emplace(file.attribute(*e, "name"), e);
    }
  }

  std::vector<Group> read() const {
    std::vector<Group> groups;
    for (const auto& [name, element] : elements_) {
      std::set<int> joints;
      collect(*element, 0, joints);
      Group group{name, {}};
      for (const int j : joints) {
        if (robot_.joints[static_cast<std::size_t>(j)].independent()) group.joints.push_back(j);
      }
      groups.push_back(std::move(group));
    }
    return groups;
  }

 private:
  static constexpr int kMaxDepth = 16;

  void collect(const Element& group, int depth, std::set<int>& joints) const {
    if (depth > kMaxDepth) file_.fail(group, "groups nested too deeply");
    for (const Element* e = group.FirstChildElement(); e; e = e->NextSiblingElement()) {
      const std::string_view kind = e->Name();
      if (kind == "chain") {
        addChain(*e, joints);
      } else if (kind == "joint") {
        if (const int j = robot_.findJoint(file_.attribute(*e, "name")); j >= 0) joints.insert(j);
      } else if (kind == "link") {
        const int link = robot_.findLink(file_.attribute(*e, "name"));
        if (link > 0) joints.insert(robot_.links[static_cast<std::size_t>(link)].parent_joint);
      } else if (kind == "group") {
        const auto found = elements_.find(file_.attribute(*e, "name"));
        if (found != elements_.end()) collect(*found->second, depth + 1, joints);
      }
    }
  }

  void addChain(const Element& chain, std::set<int>& joints) const {
    const int base = robot_.findLink(file_.attribute(chain, "base_link"));
    int link = robot_.findLink(file_.attribute(chain, "tip_link"));
    if (base < 0 || link < 0) return;
    if (!robot_.hangsFrom(link, base)) file_.fail(chain, "no chain from base_link to tip_link");
    while (link != base) {
      const int above = robot_.links[static_cast<std::size_t>(link)].parent_joint;
      joints.insert(above);
      link = robot_.joints[static_cast<std::size_t>(above)].parent;
    }
  }

  const XmlFile& file_;
  const Robot& robot_;
  std::map<std::string, const Element*> elements_;
};

void readSrdf(const std::filesystem::path& path, Robot& robot) {
  const XmlFile file(path);
  const Element& root = file.root("robot");
  robot.groups = GroupReader(file, root, robot).read();
  for (const Element* e = root.FirstChildElement("disable_collisions"); e;
       e = e->NextSiblingElement("disable_collisions")) {
    const int a = robot.findLink(file.attribute(*e, "link1"));
    const int b = robot.findLink(file.attribute(*e, "link2"));
    if (a < 0 || b < 0) continue;
    robot.touching.insert({a, b});
    robot.touching.insert({b, a});
  }
}

}  // namespace

int Robot::findLink(std::string_view link) const { return findByName(links, link); }

int Robot::findJoint(std::string_view joint) const { return findByName(joints, joint); }

std::vector<int> Robot::rigidGroups() const {
  std::vector<int> rigid(links.size());
  for (std::size_t i = 0; i < links.size(); ++i) {
    const int above = links[i].parent_joint;
    const bool fixed = above >= 0 && !joints[static_cast<std::size_t>(above)].movable();
    rigid[i] = fixed
                   ? rigid[static_cast<std::size_t>(joints[static_cast<std::size_t>(above)].parent)]
                   : static_cast<int>(i);
  }
  return rigid;
}

std::vector<int> Robot::subtree(int link) const {
  std::vector<bool> below(links.size(), false);
  std::vector<int> result;
  for (std::size_t i = 0; i < links.size(); ++i) {
    const int above = links[i].parent_joint;
    below[i] = static_cast<int>(i) == link ||
               (above >= 0 &&
                below[static_cast<std::size_t>(joints[static_cast<std::size_t>(above)].parent)]);
    if (below[i]) result.push_back(static_cast<int>(i));
  }
  return result;
}

std::vector<int> Robot::jointsAbove(int link) const {
  std::vector<int> result;
  while (true) {
    const int above = links[static_cast<std::size_t>(link)].parent_joint;
    if (above < 0) break;
    const Joint& joint = joints[static_cast<std::size_t>(above)];
    if (joint.movable()) result.push_back(above);
    link = joint.parent;
  }
  std::reverse(result.begin(), result.end());
  return result;
}

Law Robot::lawOf(std::size_t joint) const {
  // A chain of followers is walked to its master, which need not come first in the file.
  Law law{joint};
  while (joints[law.master].mimic >= 0) {
    law.offset += law.multiplier * joints[law.master].offset;
    law.multiplier *= joints[law.master].multiplier;
    law.master = static_cast<std::size_t>(joints[law.master].mimic);
  }
  return law;
}

void Robot::followMimics(std::vector<double>& q) const {
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (joints[i].mimic < 0) continue;
    const Law law = lawOf(i);
    q[i] = law.multiplier * q[law.master] + law.offset;
  }
}

bool Robot::hangsFrom(int link, int above) const {
  while (link != above) {
    const int joint = links[static_cast<std::size_t>(link)].parent_joint;
    if (joint < 0) return false;
    link = joints[static_cast<std::size_t>(joint)].parent;
  }
  return true;
}

Robot readRobot(const std::filesystem::path& urdf, const std::filesystem::path& srdf) {
  Robot robot;
  readUrdf(urdf, robot);
  readSrdf(srdf, robot);
  return robot;
}

}  // namespace handover::verify
