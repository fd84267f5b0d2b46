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
  double lower = 0, upper = 0, velocity = 0;        ///< not for fixed joints; continuous: no range
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

struct ChainGroup {
  std::string name;
  int base_link = -1, tip_link = -1;
};

/// One arm with its hand, found from the tool link.
struct Arm {
  int base_link = -1, tool_link = -1;
  int palm_link = -1;
  std::vector<int> joints;        ///< the arm's movable joints, base to tool
  std::vector<int> hand_joints;   ///< independent joints beyond the palm
  std::vector<int> hand_links;    ///< palm, what is fixed to it outwards, and the finger links
  std::vector<int> finger_links;  ///< links beyond a movable joint of the hand
};

struct Robot {
  std::string name;  ///< of the URDF's robot element
  std::filesystem::path urdf;
  std::vector<Link> links;    ///< parents come first; links[0] is the root
  std::vector<Joint> joints;  ///< parents come first
  std::vector<ChainGroup> chains;
  std::set<std::pair<int, int>> touching;  ///< SRDF pairs with reason Adjacent or Always, both ways

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
  /// The arm whose tool is `tool_link`: the joints of the shortest SRDF chain that ends in the
  /// tool's rigid group (without one: all movable joints above it). The palm is the outermost link
  /// of the tool's rigid group, from the tool towards the arm, that has fingers below it.
  /// @throws Unreadable when there is no such link or no joint above it.
  Arm arm(std::string_view tool_link) const;
};

/// @throws Unreadable naming file and line.
Robot readRobot(const std::filesystem::path& urdf, const std::filesystem::path& srdf);

}  // namespace handover::verify
