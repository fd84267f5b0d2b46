// SPDX-License-Identifier: Apache-2.0
#include "core/collision/rigid_groups.hpp"

#include <algorithm>
#include <cmath>

namespace handover {
namespace {

/// Of the points of a ball, at most; 0 for none.
double speed(const Twist& twist, const Eigen::Vector3d& middle_W, double radius) {
  if (radius < 0) return 0;
  return (twist.v + twist.w.cross(middle_W)).norm() + radius * twist.w.norm();
}

}  // namespace

RigidGroups::RigidGroups(const RobotModel& model, const std::vector<DofId>& dofs)
    : dofs_(static_cast<int>(dofs.size())), group_of_(model.links.size(), -1) {
  for (const LinkId link : IdRange<LinkId>(model.links.size())) {
    if (!model.links[link].parent_joint.valid()) continue;
    const Joint& joint = model.joints[model.links[link].parent_joint];
    const int above = group_of_[joint.parent_link];
    const auto dof = std::find(dofs.begin(), dofs.end(), joint.dof);
    if (!joint.dof.valid() || dof == dofs.end()) {
      group_of_[link] = above;
      continue;
    }
    Group group;
    group.link = link;
    group.parent = above;
    group.depth = above < 0 ? 0 : at(above).depth + 1;
    levels_ = std::max(levels_, group.depth + 2);
    group.state_index = static_cast<int>(dof - dofs.begin());
    group.prismatic = joint.type == JointType::kPrismatic;
    if (joint.mimic) {
      group.multiplier = joint.mimic_multiplier;
      group.offset = joint.mimic_offset;
    }
    group.axis = joint.axis;
    group_of_[link] = size();
    groups_.push_back(group);
  }
}

void RigidGroups::append(const RigidGroups& other) {
  const int before = size();
  for (Group group : other.groups_) {
    if (group.parent >= 0) group.parent += before;
    group.state_index += dofs_;
    groups_.push_back(group);
  }
  dofs_ += other.dofs_;
  levels_ = std::max(levels_, other.levels_);
}

void RigidGroups::setPosture(const RobotModel& model, const std::vector<Pose>& X_WL) {
  for (Group& group : groups_) {
    const Joint& joint = model.joints[model.links[group.link].parent_joint];
    group.X_PJ = X_WL[joint.parent_link] * joint.X_PJ;
    if (group.parent < 0) continue;
    group.X_PJ = X_WL[at(group.parent).link].inverse() * group.X_PJ;
  }
}

void RigidGroups::place(const Eigen::Ref<const Eigen::VectorXd>& q) {
  for (Group& group : groups_) {
    const double position = group.multiplier * q[group.state_index] + group.offset;
    Pose& X_WG = group.X_WG;
    if (group.parent < 0) {
      X_WG = group.X_PJ;
    } else {
      const Pose& X_WP = at(group.parent).X_WG;
      X_WG.linear().noalias() = X_WP.linear() * group.X_PJ.linear();
      X_WG.translation().noalias() = X_WP.linear() * group.X_PJ.translation();
      X_WG.translation() += X_WP.translation();
    }
    group.axis_W.noalias() = X_WG.linear() * group.axis;
    if (group.prismatic) {
      X_WG.translation() += position * group.axis_W;
    } else {
      // Rodrigues: each column of the joint's frame turned about the axis.
      const double s = std::sin(position), c = std::cos(position);
      const Eigen::Matrix3d R = X_WG.linear();
      for (int i = 0; i < 3; ++i) {
        const Eigen::Vector3d column = R.col(i);
        X_WG.linear().col(i) =
            c * column + s * group.axis_W.cross(column) + ((1 - c) * group.axis[i]) * group.axis_W;
      }
    }
  }
}

void RigidGroups::boundTravel(const MotionInterval& stretch) {
  seen_.resize(groups_.size() * static_cast<std::size_t>(levels_));
  for (int i = 0; i < size(); ++i) {
    Group& group = groups_[static_cast<std::size_t>(i)];
    const double along = group.multiplier * stretch.along[group.state_index];
    group.along = std::abs(along);
    group.rest = std::abs(group.multiplier) * stretch.rest[group.state_index];
    group.twist = group.parent < 0 ? Twist{} : at(group.parent).twist;
    if (group.prismatic) {
      group.twist.v += along * group.axis_W;
    } else {
      group.twist.w += along * group.axis_W;
      group.twist.v += along * group.X_WG.translation().cross(group.axis_W);
    }
    boundTravel(i);
    const Travel& travel = seen(i, 0);
    group.travel = std::min(
        travel.most,
        speed(group.twist, group.X_WG * group.ball.middle, group.ball.radius) + travel.beyond);
  }
}

// The joints from the outermost inwards, each turning what the outer ones may have moved: travel :=
// travel + (distance of the ball from the axis, at most + travel) * angle; and with the speed and
// the acceleration that a point has in a turning frame.
void RigidGroups::boundTravel(int group) {
  const Ball& ball = at(group).ball;
  if (ball.radius < 0) {
    std::fill_n(&seen(group, 0), levels_, Travel{});
    return;
  }
  const Eigen::Vector3d middle = at(group).X_WG * ball.middle;
  double travel = 0, speed = 0, acceleration = 0, rest = 0;
  seen(group, at(group).depth + 1) = {};
  for (int i = group; i >= 0; i = at(i).parent) {
    const Group& joint = at(i);
    if (joint.prismatic) {
      travel += joint.along + joint.rest;
      speed += joint.along;
      rest += joint.rest;
    } else {
      const double lever = joint.axis_W.cross(middle - joint.X_WG.translation()).norm();
      const double arm = lever + ball.radius + travel;
      travel += arm * (joint.along + joint.rest);
      acceleration += (2 * speed + arm * joint.along) * joint.along;  // Coriolis, centripetal
      speed += arm * joint.along;
      rest += arm * joint.rest;
    }
    seen(group, joint.depth) = {travel, 0.5 * acceleration + rest};
  }
}

// Seen from the group, it is the direction that turns, by one joint after the other from the base
// outwards: each by no more than its own angle times the sine of the direction to its axis.
double RigidGroups::turn(int group, const Eigen::Vector3d& direction_W,
                         const MotionInterval& stretch) const {
  if (group < 0) return 0;
  const Group& joint = at(group);
  const double before = turn(joint.parent, direction_W, stretch);
  if (joint.prismatic) return before;
  const double angle = std::abs(joint.multiplier) * (std::abs(stretch.along[joint.state_index]) +
                                                     stretch.rest[joint.state_index]);
  return before + angle * std::min(1.0, joint.axis_W.cross(direction_W).norm() + before);
}

PairMotion RigidGroups::approach(int a, int b) const {
  // What is above the group that both hang on moves them as one.
  int i = a, j = b;
  while (i != j) {
    const int depth_i = i < 0 ? -1 : at(i).depth, depth_j = j < 0 ? -1 : at(j).depth;
    if (depth_i >= depth_j) i = at(i).parent;
    if (depth_j >= depth_i) j = at(j).parent;
  }
  const int level = i < 0 ? 0 : at(i).depth + 1;
  const Twist common = i < 0 ? Twist{} : at(i).twist;
  PairMotion motion;
  const auto add = [&](int group, Twist& twist) {
    if (group < 0) return;
    twist = {at(group).twist.w - common.w, at(group).twist.v - common.v};
    motion.most += i < 0 ? at(group).travel : seen(group, level).most;
    motion.beyond += seen(group, level).beyond;
  };
  add(a, motion.a);
  add(b, motion.b);
  return motion;
}

}  // namespace handover
