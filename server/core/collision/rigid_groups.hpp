// SPDX-License-Identifier: Apache-2.0
// The links of a robot that some of its joints move, those that move as one taken together: where
// they are, and how far they can get while the joints stray a little.
#pragma once

#include "core/collision/joint_motion.hpp"
#include "core/collision/pair_motion.hpp"
#include "core/model/robot_model.hpp"

#include <vector>

namespace handover {

/// A ball round something that moves with a group, in the frame of the group's first link.
struct Ball {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  double radius = -1;  ///< < 0: nothing
};

/// Parents come before children. -1 stands for all that no joint moves. No allocation but in the
/// constructor and at the first bounds. Set a posture, then place(), then boundTravel(): each needs
/// the ones before.
class RigidGroups {
 public:
  /// @param dofs  those that move, in the order of the states asked.
  RigidGroups(const RobotModel& model, const std::vector<DofId>& dofs);

  /// Puts another robot's groups behind these, and its dofs behind theirs. groupOf() goes on
  /// speaking of the first robot's links.
  void append(const RigidGroups& other);

  int size() const { return static_cast<int>(groups_.size()); }

  /// Size of the states asked.
  int dofs() const { return dofs_; }

  /// The group that a link moves with, or -1.
  int groupOf(LinkId link) const { return group_of_[link]; }

  /// The link that the group's joint moves: its frame is the group's.
  LinkId linkOf(int group) const { return at(group).link; }

  /// Takes the places of all that stands still from the poses of all links.
  void setPosture(const RobotModel& model, const std::vector<Pose>& X_WL);

  /// A ball that holds all of a group.
  void setBall(int group, const Ball& ball) {
    groups_[static_cast<std::size_t>(group)].ball = ball;
  }

  /// Moves the groups to a state of the dofs.
  void place(const Eigen::Ref<const Eigen::VectorXd>& q);

  const Pose& pose(int group) const { return at(group).X_WG; }

  /// Lets the dofs move along a stretch of a motion, from its middle, where they are placed.
  void boundTravel(const MotionInterval& stretch);

  /// The angle that what moves with the group, placed in the middle of a stretch of a motion, turns
  /// towards or away from a unit direction of the world along it [rad], at most.
  double turn(int group, const Eigen::Vector3d& direction_W, const MotionInterval& stretch) const;

  /// No point of the group's ball then gets farther than this in the world [m].
  double travel(int group) const { return group < 0 ? 0.0 : at(group).travel; }

  /// How what moves with two groups may then move, as seen from what both hang on. A group of -1
  /// stands still.
  PairMotion approach(int a, int b) const;

 private:
  struct Group {
    LinkId link;
    int parent = -1;
    int depth = 0;  ///< number of groups above
    int state_index = -1;
    bool prismatic = false;
    double multiplier = 1, offset = 0;
    Eigen::Vector3d axis;          ///< unit, in the group's frame as in the joint's
    Pose X_PJ = Pose::Identity();  ///< of the joint in the parent group, or in the world
    Pose X_WG = Pose::Identity();
    Eigen::Vector3d axis_W = Eigen::Vector3d::Zero();
    double along = 0, rest = 0;  ///< of the joint; along >= 0
    Twist twist;                 ///< in the world, along the stretch
    Ball ball;
    double travel = 0;
  };

  /// How far points of a group's ball get [m], at most.
  struct Travel {
    double most = 0;    ///< all in all
    double beyond = 0;  ///< from where its twist, times x, takes them
  };

  const Group& at(int group) const { return groups_[static_cast<std::size_t>(group)]; }

  /// As seen from the `level`-th group on the way down to this one; 0: in the world.
  Travel& seen(int group, int level) { return seen_[seenIndex(group, level)]; }

  const Travel& seen(int group, int level) const { return seen_[seenIndex(group, level)]; }

  std::size_t seenIndex(int group, int level) const {
    return static_cast<std::size_t>(group) * static_cast<std::size_t>(levels_) +
           static_cast<std::size_t>(level);
  }

  void boundTravel(int group);

  int dofs_ = 0;
  std::vector<int> group_of_;  ///< by link
  std::vector<Group> groups_;
  int levels_ = 2;
  std::vector<Travel> seen_;  ///< by group and level
};

}  // namespace handover
