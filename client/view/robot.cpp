// SPDX-License-Identifier: Apache-2.0
#include "view/robot.hpp"

#include <handover/client/plan_file.hpp>

#include <tinyxml2.h>

#include <algorithm>
#include <array>
#include <set>
#include <sstream>

namespace handover::view {
namespace {

using client::PlanFileError;
using Element = tinyxml2::XMLElement;

/// Reads elements of one URDF; faults name its line.
class Reader {
 public:
  explicit Reader(const std::string& where) : where_(where) {}

  [[noreturn]] void fail(const Element& element, const std::string& what) const {
    throw PlanFileError(where_ + ":" + std::to_string(element.GetLineNum()), what);
  }

  std::string word(const Element& element, const char* name) const {
    const char* value = element.Attribute(name);
    if (value == nullptr) fail(element, std::string("attribute ") + name + " is missing");
    return value;
  }

  double number(const Element& element, const char* name) const {
    double value = 0;
    if (element.QueryDoubleAttribute(name, &value) != tinyxml2::XML_SUCCESS) {
      fail(element, std::string("attribute ") + name + " is no number");
    }
    return value;
  }

  std::array<double, 3> three(const Element& element, const char* name,
                              std::array<double, 3> value) const {
    const char* text = element.Attribute(name);
    if (text == nullptr) return value;
    std::istringstream stream(text);
    if (!(stream >> value[0] >> value[1] >> value[2])) {
      fail(element, std::string("attribute ") + name + " is not three numbers");
    }
    return value;
  }

  Pose origin(const Element& element) const {
    Pose X = Pose::Identity();
    const Element* origin = element.FirstChildElement("origin");
    if (origin == nullptr) return X;
    const auto [roll, pitch, yaw] = three(*origin, "rpy", {});
    X.translation() = Eigen::Vector3d(three(*origin, "xyz", {}).data());
    X.linear() = rotationFromRpy(roll, pitch, yaw);
    return X;
  }

  Geometry geometry(const Element& collision) const {
    const Element* geometry = collision.FirstChildElement("geometry");
    const Element* shape = geometry == nullptr ? nullptr : geometry->FirstChildElement();
    if (shape == nullptr) fail(collision, "collision without geometry");
    const std::string kind = shape->Name();
    if (kind == "box") return BoxGeometry{three(*shape, "size", {})};
    if (kind == "sphere") return SphereGeometry{number(*shape, "radius")};
    if (kind == "cylinder") {
      return CylinderGeometry{number(*shape, "radius"), number(*shape, "length")};
    }
    if (kind == "mesh") {
      return MeshGeometry{word(*shape, "filename"), three(*shape, "scale", {1, 1, 1})};
    }
    fail(*shape, "unknown geometry " + kind);
  }

  Link link(const Element& element) const {
    Link link{word(element, "name"), {}};
    for (auto* collision = element.FirstChildElement("collision"); collision != nullptr;
         collision = collision->NextSiblingElement("collision")) {
      link.collision.push_back({origin(*collision), geometry(*collision)});
    }
    return link;
  }

  Joint joint(const Element& element, const std::map<std::string, std::size_t>& links) const {
    Joint joint;
    joint.name = word(element, "name");
    const std::string type = word(element, "type");
    if (type == "revolute" || type == "continuous") joint.motion = Joint::Motion::kTurn;
    if (type == "prismatic") joint.motion = Joint::Motion::kSlide;
    joint.parent = linkOf(element, "parent", links);
    joint.child = linkOf(element, "child", links);
    joint.X_PJ = origin(element);
    if (const Element* axis = element.FirstChildElement("axis")) {
      joint.axis = Eigen::Vector3d(three(*axis, "xyz", {1, 0, 0}).data()).normalized();
    }
    if (const Element* mimic = element.FirstChildElement("mimic")) {
      joint.mimic = Mimic{word(*mimic, "joint"), mimic->DoubleAttribute("multiplier", 1),
                          mimic->DoubleAttribute("offset", 0)};
    }
    return joint;
  }

 private:
  std::size_t linkOf(const Element& joint, const char* end,
                     const std::map<std::string, std::size_t>& links) const {
    const Element* element = joint.FirstChildElement(end);
    if (element == nullptr) fail(joint, std::string("joint without ") + end);
    const auto found = links.find(word(*element, "link"));
    if (found == links.end()) fail(*element, "no such link");
    return found->second;
  }

  const std::string& where_;
};

/// Parents first. @return fewer than given where joints hang on none of the roots.
std::vector<Joint> inTreeOrder(std::vector<Joint> joints, std::size_t links) {
  std::vector<bool> is_child(links, false);
  for (const Joint& joint : joints) is_child[joint.child] = true;
  std::vector<std::size_t> open;
  for (std::size_t link = 0; link < links; ++link) {
    if (!is_child[link]) open.push_back(link);
  }
  std::vector<Joint> ordered;
  for (std::size_t next = 0; next < open.size() && ordered.size() <= joints.size(); ++next) {
    for (const Joint& joint : joints) {
      if (joint.parent != open[next]) continue;
      ordered.push_back(joint);
      open.push_back(joint.child);
    }
  }
  return ordered;
}

Pose moved(const Joint& joint, double position) {
  Pose X = joint.X_PJ;
  if (joint.motion == Joint::Motion::kTurn) X.rotate(Eigen::AngleAxisd(position, joint.axis));
  if (joint.motion == Joint::Motion::kSlide) X.translate(position * joint.axis);
  return X;
}

}  // namespace

Robot::Robot(const std::string& urdf, const std::string& where) {
  tinyxml2::XMLDocument document;
  if (document.Parse(urdf.data(), urdf.size()) != tinyxml2::XML_SUCCESS) {
    throw PlanFileError(where, document.ErrorStr());
  }
  const Element* robot = document.FirstChildElement("robot");
  if (robot == nullptr) throw PlanFileError(where, "no <robot> element");
  const Reader reader(where);
  for (auto* link = robot->FirstChildElement("link"); link != nullptr;
       link = link->NextSiblingElement("link")) {
    links_.push_back(reader.link(*link));
    index_.emplace(links_.back().name, links_.size() - 1);
  }
  std::vector<Joint> joints;
  for (auto* joint = robot->FirstChildElement("joint"); joint != nullptr;
       joint = joint->NextSiblingElement("joint")) {
    joints.push_back(reader.joint(*joint, index_));
  }
  joints_ = inTreeOrder(joints, links_.size());
  if (joints_.size() != joints.size()) throw PlanFileError(where, "its links form no tree");
}

std::optional<std::size_t> Robot::findLink(const std::string& name) const {
  const auto found = index_.find(name);
  return found == index_.end() ? std::nullopt : std::optional(found->second);
}

double Robot::positionOf(const Joint& joint, const Positions& q) const {
  const auto found = q.find(joint.mimic ? joint.mimic->joint : joint.name);
  const double position = found == q.end() ? 0 : found->second;
  return joint.mimic ? joint.mimic->multiplier * position + joint.mimic->offset : position;
}

std::vector<Pose> Robot::linkPoses(const Pose& X_WB, const Positions& q) const {
  std::vector<Pose> X_WL(links_.size(), X_WB);
  for (const Joint& joint : joints_) {
    X_WL[joint.child] = X_WL[joint.parent] * moved(joint, positionOf(joint, q));
  }
  return X_WL;
}

}  // namespace handover::view
