// SPDX-License-Identifier: Apache-2.0
#include "kdl_robot.hpp"

#include <kdl/chainfksolverpos_recursive.hpp>
#include <tinyxml2.h>

#include <array>
#include <set>
#include <sstream>
#include <stdexcept>

namespace handover::testing {
namespace {

using tinyxml2::XMLElement;

std::array<double, 3> triple(const XMLElement* element, const char* attribute,
                             std::array<double, 3> values) {
  const char* text = element ? element->Attribute(attribute) : nullptr;
  if (text) std::istringstream(text) >> values[0] >> values[1] >> values[2];
  return values;
}

KDL::Vector vectorOf(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

/// The segment that carries a joint's child link.
KDL::Segment segmentOf(const XMLElement& joint, const std::string& child) {
  const XMLElement* origin = joint.FirstChildElement("origin");
  const auto rpy = triple(origin, "rpy", {0, 0, 0});
  const KDL::Frame X_PJ(KDL::Rotation::RPY(rpy[0], rpy[1], rpy[2]),
                        vectorOf(triple(origin, "xyz", {0, 0, 0})));
  const std::string name = joint.Attribute("name");
  if (std::string(joint.Attribute("type")) == "fixed") {
    return KDL::Segment(child, KDL::Joint(name, KDL::Joint::Fixed), X_PJ);
  }
  const auto axis = vectorOf(triple(joint.FirstChildElement("axis"), "xyz", {1, 0, 0}));
  return KDL::Segment(child, KDL::Joint(name, X_PJ.p, X_PJ.M * axis, KDL::Joint::RotAxis), X_PJ);
}

}  // namespace

KdlRobot::KdlRobot(const std::filesystem::path& urdf) {
  tinyxml2::XMLDocument document;
  if (document.LoadFile(urdf.c_str()) != tinyxml2::XML_SUCCESS) {
    throw std::runtime_error("cannot read " + urdf.string());
  }
  std::multimap<std::string, const XMLElement*> children;
  std::set<std::string> roots;
  const XMLElement* robot = document.FirstChildElement("robot");
  for (auto link = robot->FirstChildElement("link"); link;
       link = link->NextSiblingElement("link")) {
    roots.insert(link->Attribute("name"));
  }
  for (auto joint = robot->FirstChildElement("joint"); joint;
       joint = joint->NextSiblingElement("joint")) {
    children.emplace(joint->FirstChildElement("parent")->Attribute("link"), joint);
    roots.erase(joint->FirstChildElement("child")->Attribute("link"));
    if (const XMLElement* mimic = joint->FirstChildElement("mimic")) {
      mimics_[joint->Attribute("name")] = {mimic->Attribute("joint"),
                                           mimic->DoubleAttribute("multiplier", 1),
                                           mimic->DoubleAttribute("offset", 0)};
    }
  }
  if (roots.size() != 1) throw std::runtime_error("not one root in " + urdf.string());
  root_ = *roots.begin();
  tree_ = KDL::Tree(root_);
  std::vector<std::string> open{root_};
  while (!open.empty()) {
    const std::string parent = open.back();
    open.pop_back();
    const auto [first, last] = children.equal_range(parent);
    for (auto i = first; i != last; ++i) {
      const std::string child = i->second->FirstChildElement("child")->Attribute("link");
      tree_.addSegment(segmentOf(*i->second, child), parent);
      open.push_back(child);
    }
  }
}

KDL::Chain KdlRobot::chain(const std::string& base, const std::string& tip) const {
  KDL::Chain chain;
  if (!tree_.getChain(base, tip, chain)) {
    throw std::runtime_error("no chain from " + base + " to " + tip);
  }
  return chain;
}

KDL::Frame KdlRobot::pose(const std::string& link, const std::map<std::string, double>& q) const {
  const KDL::Chain chain = this->chain(root_, link);
  KDL::JntArray positions(chain.getNrOfJoints());
  unsigned int index = 0;
  for (const KDL::Segment& segment : chain.segments) {
    if (segment.getJoint().getType() == KDL::Joint::Fixed) continue;
    const std::string& joint = segment.getJoint().getName();
    const auto mimic = mimics_.find(joint);
    positions(index++) =
        mimic == mimics_.end()
            ? q.at(joint)
            : mimic->second.multiplier * q.at(mimic->second.master) + mimic->second.offset;
  }
  KDL::Frame pose;
  KDL::ChainFkSolverPos_recursive solver(chain);
  if (solver.JntToCart(positions, pose) < 0) throw std::runtime_error("KDL fails at " + link);
  return pose;
}

}  // namespace handover::testing
