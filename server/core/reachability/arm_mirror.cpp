// SPDX-License-Identifier: Apache-2.0
#include "core/reachability/arm_mirror.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>

namespace handover {
namespace {

constexpr double kTolerance = 1e-6;  // m, rad

LinkId parentOf(const RobotModel& model, LinkId link) {
  const JointId joint = model.links[link].parent_joint;
  return joint.valid() ? model.joints[joint].parent_link : LinkId();
}

/// The last link that both hang from. Parents have lower indices.
LinkId commonLink(const RobotModel& model, LinkId a, LinkId b) {
  while (a != b) {
    LinkId& later = a > b ? a : b;
    later = parentOf(model, later);
  }
  return a;
}

/// What a map depends on, seen from the common link C with the arm's joints at 0.
struct Chain {
  struct Axis {
    JointType type = JointType::kFixed;
    Eigen::Vector3d point, direction;
    double lower = 0, upper = 0;
    std::string name;
  };

  Pose X_CA = Pose::Identity();
  std::vector<Axis> axes;
  Eigen::Vector3d tool, approach;
};

Chain chainOf(const RobotModel& model, const Arm& arm, LinkId common, RobotVector q) {
  for (const DofId dof : arm.dofs) q[dof.value()] = 0;
  std::vector<Pose> X_WL;
  linkPoses(model, Pose::Identity(), q, X_WL);
  const Pose X_CW = X_WL[common].inverse();
  const auto pose = [&](LinkId link) { return X_CW * X_WL[link]; };
  Chain chain;
  chain.X_CA = pose(arm.base_link);
  for (const JointId index : arm.joints) {
    const Joint& joint = model.joints[index];
    const Pose X_CJ = pose(joint.parent_link) * joint.X_PJ;
    chain.axes.push_back({joint.type, X_CJ.translation(), X_CJ.linear() * joint.axis, joint.lower,
                          joint.upper, joint.name});
  }
  const Pose X_CT = pose(arm.tool_link);
  chain.tool = X_CT.translation();
  chain.approach = X_CT.linear() * arm.approach_axis;
  return chain;
}

/// 1 or -1: how the joint moves whose axis is `image` when the reflection M of `axis` does; nullopt
/// when they are not on one line (or not parallel, for sliding ones).
std::optional<double> signOf(const Eigen::Matrix3d& M, const Chain::Axis& axis,
                             const Chain::Axis& image) {
  if (axis.type != image.type) return std::nullopt;
  // A reflection turns rotations round: M R(a, t) M = R(-M a, t).
  const bool turns = axis.type == JointType::kRevolute;
  const Eigen::Vector3d reflected = turns ? (-M * axis.direction).eval() : M * axis.direction;
  const double sign = reflected.dot(image.direction) < 0 ? -1 : 1;
  if ((sign * reflected - image.direction).norm() > kTolerance) return std::nullopt;
  const Eigen::Vector3d between = image.point - M * axis.point;
  if (turns && between.cross(image.direction).norm() > kTolerance) return std::nullopt;
  return sign;
}

/// What the comparison in one plane came to: the mirror, or the first difference.
struct Comparison {
  std::optional<ArmMirror> mirror;
  std::string difference;
  std::size_t agreeing = 0;  ///< parts that were compared before
};

Comparison differs(std::size_t agreeing, std::string difference) {
  return {std::nullopt, std::move(difference), agreeing};
}

Comparison compareIn(const Eigen::Matrix3d& M, const Chain& from, const Chain& to) {
  if (from.axes.size() != to.axes.size()) return differs(0, "the numbers of joints");
  ArmMirror mirror;
  mirror.sign.resize(static_cast<Eigen::Index>(from.axes.size()));
  std::size_t agreeing = 0;
  for (; agreeing < from.axes.size(); ++agreeing) {
    const Chain::Axis &axis = from.axes[agreeing], &image = to.axes[agreeing];
    const auto sign = signOf(M, axis, image);
    if (!sign) return differs(agreeing, "the axes of " + axis.name + " and " + image.name);
    const double lower = *sign > 0 ? axis.lower : -axis.upper;
    const double upper = *sign > 0 ? axis.upper : -axis.lower;
    if (std::abs(lower - image.lower) > kTolerance || std::abs(upper - image.upper) > kTolerance) {
      return differs(agreeing, "the limits of " + axis.name + " and " + image.name);
    }
    mirror.sign[static_cast<Eigen::Index>(agreeing)] = *sign;
  }
  if ((M * from.tool - to.tool).norm() > kTolerance) return differs(agreeing, "the tool positions");
  if ((M * from.approach - to.approach).norm() > kTolerance) {
    return differs(agreeing + 1, "the approach directions");
  }
  const Eigen::Matrix3d S = to.X_CA.linear().transpose() * M * from.X_CA.linear();
  const Eigen::Vector3d shift = M * from.X_CA.translation() - to.X_CA.translation();
  mirror.S_ToFrom = S.array().round().matrix();
  if (shift.norm() > kTolerance || (mirror.S_ToFrom - S).norm() > kTolerance ||
      std::abs(mirror.S_ToFrom(2, 2)) != 1) {
    return differs(agreeing + 2, "the base frames, whose voxels do not fall on each other");
  }
  return {mirror, "", agreeing + 3};
}

}  // namespace

Result<ArmMirror> findArmMirror(const RobotModel& model, ArmId from, ArmId to,
                                const RobotVector& q) {
  const Arm& first = model.arms.at(from);
  const Arm& second = model.arms.at(to);
  const LinkId common = commonLink(model, first.base_link, second.base_link);
  const Chain a = chainOf(model, first, common, q), b = chainOf(model, second, common, q);
  Comparison nearest;
  for (int axis = 1; axis < 4; ++axis) {  // y first: robots look along x
    Eigen::Matrix3d M = Eigen::Matrix3d::Identity();
    M(axis % 3, axis % 3) = -1;
    Comparison comparison = compareIn(M, a, b);
    if (comparison.mirror) return *comparison.mirror;
    if (axis == 1 || comparison.agreeing > nearest.agreeing) nearest = std::move(comparison);
  }
  return Error{ErrorCode::kNotFound, nearest.difference + " are not mirror images"};
}

}  // namespace handover
