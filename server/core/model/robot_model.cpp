// SPDX-License-Identifier: Apache-2.0
#include "core/model/robot_model.hpp"

#include "core/model/content_hash.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace handover {
namespace {

template <typename Items>
int indexOf(const Items& items, std::string_view name) {
  const auto found = std::find_if(items.begin(), items.end(),
                                  [name](const auto& item) { return item.name == name; });
  return found == items.end() ? -1 : static_cast<int>(found - items.begin());
}

/// Fills `rotation` with the turn by `angle` about a unit axis.
void setTurn(const Eigen::Vector3d& axis, double angle, Eigen::Matrix3d& rotation) {
  const double s = std::sin(angle), c = std::cos(angle);
  const Eigen::Vector3d v = (1.0 - c) * axis;
  rotation(0, 0) = v.x() * axis.x() + c;
  rotation(1, 1) = v.y() * axis.y() + c;
  rotation(2, 2) = v.z() * axis.z() + c;
  const double xy = v.x() * axis.y(), xz = v.x() * axis.z(), yz = v.y() * axis.z();
  rotation(0, 1) = xy - s * axis.z();
  rotation(1, 0) = xy + s * axis.z();
  rotation(0, 2) = xz + s * axis.y();
  rotation(2, 0) = xz - s * axis.y();
  rotation(1, 2) = yz - s * axis.x();
  rotation(2, 1) = yz + s * axis.x();
}

void setLinkPose(const RobotModel& model, const RobotVector& q, LinkId link,
                 std::vector<Pose>& X_WL) {
  const JointId joint_index = model.links[link].parent_joint;
  if (!joint_index.valid()) return;
  const Joint& joint = model.joints[static_cast<std::size_t>(joint_index)];
  const Pose& X_WP = X_WL[joint.parent_link];
  Pose& X_WC = X_WL[link];
  const Eigen::Matrix3d R_WJ = X_WP.linear() * joint.X_PJ.linear();
  X_WC.translation() = X_WP.linear() * joint.X_PJ.translation() + X_WP.translation();
  if (joint.type == JointType::kFixed) {
    X_WC.linear() = R_WJ;
    return;
  }
  const double position = model.jointPosition(joint_index, q);
  if (joint.type == JointType::kPrismatic) {
    X_WC.linear() = R_WJ;
    X_WC.translation() += R_WJ * (position * joint.axis);
    return;
  }
  Eigen::Matrix3d R_JC;
  setTurn(joint.axis, position, R_JC);
  X_WC.linear().noalias() = R_WJ * R_JC;
}

void requireSize(const RobotModel& model, const RobotVector& q) {
  if (q.size() == model.dofs()) return;
  throw std::invalid_argument("robot '" + model.name + "' has " + std::to_string(model.dofs()) +
                              " joint positions, not " + std::to_string(q.size()));
}

/// The topmost link that moves as one with this one.
LinkId rigidRoot(const RobotModel& model, LinkId link) {
  for (;;) {
    const JointId joint = model.links[link].parent_joint;
    if (!joint.valid()) return link;
    const Joint& above = model.joints[joint];
    if (above.type != JointType::kFixed) return link;
    link = above.parent_link;
  }
}

/// The rigid root of the group that a rigid root hangs on, if any.
LinkId groupAbove(const RobotModel& model, LinkId rigid_root) {
  const JointId joint = model.links[rigid_root].parent_joint;
  if (!joint.valid()) return {};
  return rigidRoot(model, model.joints[joint].parent_link);
}

void add(ContentHash& hash, const Joint& joint) {
  hash.add(joint.name).add(static_cast<int>(joint.type));
  hash.add(joint.parent_link).add(joint.child_link).add(joint.X_PJ).add(joint.axis);
  hash.add(joint.lower).add(joint.upper).add(joint.velocity);
  hash.add(joint.acceleration).add(joint.jerk);
  hash.add(joint.dof).add(joint.mimic ? 1 : 0);
  hash.add(joint.mimic_multiplier).add(joint.mimic_offset);
}

void add(ContentHash& hash, const Arm& arm) {
  hash.add(arm.name).add(arm.base_link).add(arm.tool_link).add(arm.dofs).add(arm.joints);
  hash.add(arm.approach_axis).add(arm.p_AShoulder ? 1 : 0);
  if (arm.p_AShoulder) hash.add(*arm.p_AShoulder);
  hash.add(arm.hand);
}

void add(ContentHash& hash, const Hand& hand) {
  hash.add(hand.name).add(hand.palm_link).add(hand.finger_links).add(hand.dofs);
  hash.add(hand.fingers.size());
  for (const auto& finger : hand.fingers) hash.add(finger);
  hash.add(hand.open).add(hand.closed).add(hand.links);
  if (!hand.suction) return;
  hash.add(hand.suction->cup_link).add(hand.suction->axis);
  hash.add(hand.suction->radius).add(hand.suction->engage_s);
}

}  // namespace

LinkId RobotModel::findLink(std::string_view link) const { return LinkId(indexOf(links, link)); }

JointId RobotModel::findJoint(std::string_view joint) const {
  return JointId(indexOf(joints, joint));
}

ArmId RobotModel::findArm(std::string_view arm) const { return ArmId(indexOf(arms, arm)); }

HandId RobotModel::findHand(std::string_view hand) const { return HandId(indexOf(hands, hand)); }

double RobotModel::jointPosition(JointId joint, const RobotVector& q) const {
  const Joint& it = joints[joint];
  if (!it.dof.valid()) return 0.0;
  return it.mimic ? it.mimic_multiplier * q[it.dof.value()] + it.mimic_offset : q[it.dof.value()];
}

std::vector<LinkId> RobotModel::linksMovedBy(const std::vector<DofId>& dofs) const {
  std::vector<bool> moved(links.size(), false);
  std::vector<LinkId> result;
  for (const LinkId link : IdRange<LinkId>(links.size())) {
    if (!links[link].parent_joint.valid()) continue;
    const Joint& joint = joints[links[link].parent_joint];
    const bool driven =
        joint.dof.valid() && std::find(dofs.begin(), dofs.end(), joint.dof) != dofs.end();
    moved[link] = driven || moved[joint.parent_link];
    if (moved[link]) result.push_back(link);
  }
  return result;
}

bool RobotModel::adjacent(LinkId link_a, LinkId link_b) const {
  const LinkId root_a = rigidRoot(*this, link_a), root_b = rigidRoot(*this, link_b);
  return root_a == root_b || groupAbove(*this, root_a) == root_b ||
         groupAbove(*this, root_b) == root_a;
}

void linkPoses(const RobotModel& model, const Pose& X_WB, const RobotVector& q,
               std::vector<Pose>& X_WL) {
  requireSize(model, q);
  X_WL.resize(model.links.size(), Pose::Identity());
  X_WL[0] = X_WB;
  for (const LinkId link : IdRange<LinkId>(model.links.size())) setLinkPose(model, q, link, X_WL);
}

void linkPosesOf(const RobotModel& model, const RobotVector& q, const std::vector<LinkId>& links,
                 std::vector<Pose>& X_WL) {
  requireSize(model, q);
  for (const LinkId link : links) setLinkPose(model, q, link, X_WL);
}

std::string modelHash(const RobotModel& model) {
  ContentHash hash;
  hash.add(model.urdf_sha256).add(model.links.size());
  for (const Link& link : model.links) {
    hash.add(link.name).add(link.parent_joint).add(link.collision);
  }
  hash.add(model.joints.size());
  for (const Joint& joint : model.joints) add(hash, joint);
  hash.add(model.dof_joints);
  hash.add(model.arms.size());
  for (const Arm& arm : model.arms) add(hash, arm);
  hash.add(model.hands.size());
  for (const Hand& hand : model.hands) add(hash, hand);
  hash.add(model.named_states.size());
  for (const auto& [name, q] : model.named_states) hash.add(name).add(q);
  hash.add(model.disabled_pairs.size());
  for (const auto& [pair, reason] : model.disabled_pairs) {
    hash.add(pair.first).add(pair.second).add(reason);
  }
  return hash.hex();
}

}  // namespace handover
