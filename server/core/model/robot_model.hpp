// SPDX-License-Identifier: Apache-2.0
// A robot as fixed arrays in topological order: immutable after loading and shared by all workers.
#pragma once

#include "core/model/body_shapes.hpp"
#include "core/model/id.hpp"

#include <handover/common/pose.hpp>

#include <Eigen/Core>

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace handover {

using LinkId = Id<struct LinkTag>;    ///< index in RobotModel::links
using JointId = Id<struct JointTag>;  ///< index in RobotModel::joints
using DofId = Id<struct DofTag>;      ///< index in RobotVector: an independent joint
using ArmId = Id<struct ArmTag>;      ///< index in RobotModel::arms
using HandId = Id<struct HandTag>;    ///< index in RobotModel::hands

/// Joint positions of a robot: one entry per independent non-fixed joint (mimic joints have none),
/// in the model's order [rad or m].
using RobotVector = Eigen::VectorXd;

/// Joint positions of one arm, base to tool; at most 8 joints, no heap.
using ArmVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 8, 1>;

enum class JointType { kFixed, kRevolute, kPrismatic };

struct Joint {
  std::string name;
  JointType type = JointType::kFixed;
  LinkId parent_link, child_link;
  Pose X_PJ = Pose::Identity();  ///< of the joint frame in the parent link, at q = 0
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit, in the joint frame
  /// Continuous joints: -pi, pi. A master's limits (and speed) are narrowed to those that keep its
  /// mimic joints within theirs.
  double lower = 0, upper = 0;
  bool continuous = false;  ///< it turns without end; planned within lower and upper all the same
  double velocity = 0, acceleration = 0;
  double jerk = 0;     ///< [rad/s^3]
  DofId dof;           ///< none of a fixed joint; of the master for a mimic joint
  bool mimic = false;  ///< position = multiplier * q[dof] + offset; a
                       ///< mimic of a mimic is resolved to the master
  double mimic_multiplier = 1, mimic_offset = 0;
};

struct Link {
  std::string name;
  JointId parent_joint;  ///< none for the root
  std::vector<Shape> collision;
  std::shared_ptr<const DividedBodies> divided = {};  ///< of `collision`; null: none
};

/// A suction gripper: a cup without joints.
struct Suction {
  LinkId cup_link;                                  ///< rigid with the tool link
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit, in the cup link, towards the object
  double radius = 0;                                ///< of the seal [m]
  double engage_s = 0;                              ///< until the vacuum holds, or is gone [s]
};

/// A hand: its finger joints, and where they start to close and to where they may.
struct Hand {
  std::string name;
  LinkId palm_link;
  std::vector<LinkId> finger_links;  ///< links that may count as finger contacts
  std::vector<DofId> dofs;           ///< independent finger joints, in model order
  /// Per finger, its dofs from the palm outwards: the order in which they are closed until contact.
  std::vector<std::vector<DofId>> fingers;
  Eigen::VectorXd open, closed;  ///< per dofs entry [rad]
  std::vector<LinkId> links;     ///< palm, fingers and everything fixed to them
  /// A hand without fingers; palm_link is the cup link, dofs are empty.
  std::optional<Suction> suction;
};

struct Arm {
  std::string name;
  LinkId base_link;             ///< parent link of the first joint: frame A
  LinkId tool_link;             ///< frame T
  std::vector<DofId> dofs;      ///< base to tool
  std::vector<JointId> joints;  ///< the same
  Eigen::Vector3d approach_axis = Eigen::Vector3d::UnitZ();  ///< unit, in T, towards the object
  std::optional<Eigen::Vector3d> p_AShoulder;  ///< override of the first three axes' meeting point
  HandId hand;                                 ///< none: no gripper
};

struct RobotModel {
  std::string name;
  std::string urdf_path, srdf_path, yaml_path;  ///< as given to the loader, relative to the root
  std::string urdf_sha256, yaml_sha256;
  std::string content_hash;         ///< of everything here but the paths, see modelHash()
  std::vector<Link> links;          ///< links[0] is the root; parents come first
  std::vector<Joint> joints;        ///< joints[i].child_link rises with i
  std::vector<JointId> dof_joints;  ///< by dof
  std::vector<Arm> arms;
  std::vector<Hand> hands;
  std::map<std::string, RobotVector>
      named_states;  ///< SRDF group states, others at 0 within limits
  /// SRDF disable_collisions: link pair (lower index first) -> reason.
  std::map<std::pair<LinkId, LinkId>, std::string> disabled_pairs;

  int dofs() const { return static_cast<int>(dof_joints.size()); }

  /// By name; none if there is none.
  LinkId findLink(std::string_view link) const;
  JointId findJoint(std::string_view joint) const;
  ArmId findArm(std::string_view arm) const;
  HandId findHand(std::string_view hand) const;
  /// Position of a joint (mimic ones follow their law; 0 for fixed ones).
  double jointPosition(JointId joint, const RobotVector& q) const;
  /// Links that move when any of these dofs moves, ascending.
  std::vector<LinkId> linksMovedBy(const std::vector<DofId>& dofs) const;
  /// True if the links are never tested for contact: they move as one (fixed joints between them),
  /// or one movable joint joins the rigid groups that they belong to.
  bool adjacent(LinkId link_a, LinkId link_b) const;
};

/// Poses of every link when the root link is at `X_WB`: fills `X_WL`, size = links.size(). No
/// allocation when X_WL has the size already.
/// @pre q.size() == model.dofs().
void linkPoses(const RobotModel& model, const Pose& X_WB, const RobotVector& q,
               std::vector<Pose>& X_WL);

/// The same for some links only, ascending (RobotModel::linksMovedBy): the others, filled before,
/// stay. No allocation.
void linkPosesOf(const RobotModel& model, const RobotVector& q, const std::vector<LinkId>& links,
                 std::vector<Pose>& X_WL);

/// Hash (32 hex digits) of the model's content: structure, limits, shapes, arms, hands, named
/// states.
std::string modelHash(const RobotModel& model);

}  // namespace handover
