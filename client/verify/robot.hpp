// SPDX-License-Identifier: Apache-2.0
// A robot as its URDF and SRDF tell it: the verifier's own reading, in topological order.
#pragma once

#include "verify/geometry.hpp"
#include "verify/pose.hpp"

#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace handover::verify {

enum class JointType { kFixed, kRevolute, kContinuous, kPrismatic };

struct Joint {
  std::string name;
  JointType type = JointType::kFixed;
  int parent = -1, child = -1;                      ///< links
  Pose X_PJ = Pose::Identity();                     ///< joint frame in the parent link
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  ///< unit, in the joint frame
  double lower = 0, upper = 0;                      ///< not for fixed and continuous joints
  double velocity = 0;                              ///< 0: the URDF says none
  int mimic = -1;                                   ///< joint that it follows, or -1
  double multiplier = 1, offset = 0;

  bool movable() const { return type != JointType::kFixed; }

  bool independent() const { return movable() && mimic < 0; }
};

struct Link {
  std::string name;
  int parent_joint = -1;  ///< -1: the root
  std::vector<PlacedGeometry> collision;
};

/// A group of the SRDF: the joints that it names, by chains, joints, links and subgroups.
struct Group {
  std::string name;
  std::vector<int> joints;  ///< independent movable ones, root first
};

struct Law {
  std::size_t master = 0;
  double multiplier = 1, offset = 0;
};

struct Robot {
  std::string name;  ///< of the URDF's robot element
  std::filesystem::path urdf;
  std::vector<Link> links;    ///< parents come first; links[0] is the root
  std::vector<Joint> joints;  ///< parents come first
  std::vector<Group> groups;
  std::set<std::pair<int, int>> touching;  ///< SRDF pairs, whatever the reason, both ways round

  int findLink(std::string_view link) const;
  int findJoint(std::string_view joint) const;
  /// Links of one rigid group (joined by fixed joints) share a number.
  std::vector<int> rigidGroups() const;
  /// Links below (and with) `link`.
  std::vector<int> subtree(int link) const;
  /// Movable joints from the root to the link, root first.
  std::vector<int> jointsAbove(int link) const;
  /// Position of every joint from those of the independent ones: mimic joints follow their law.
  void followMimics(std::vector<double>& q) const;
  /// How a joint follows: q = multiplier * q[master] + offset; an independent joint follows itself.
  Law lawOf(std::size_t joint) const;
  /// Whether `link` is `above` or hangs from it.
  bool hangsFrom(int link, int above) const;
};

/// @throws Unreadable naming file and line.
Robot readRobot(const std::filesystem::path& urdf, const std::filesystem::path& srdf);

}  // namespace handover::verify
