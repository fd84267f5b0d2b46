// SPDX-License-Identifier: Apache-2.0
#include "core/kinematics/chain.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace handover::kinematics {
namespace {

/// The joints from the base link to the tool link, fixed ones included.
std::vector<JointId> jointsBetween(const RobotModel& model, const Arm& arm) {
  const auto known = [&](LinkId link) {
    return link.valid() && std::size_t{link} < model.links.size();
  };
  if (!known(arm.base_link) || !known(arm.tool_link)) {
    throw std::invalid_argument("arm " + arm.name + ": base or tool link out of range");
  }
  std::vector<JointId> chain;
  for (LinkId link = arm.tool_link; link != arm.base_link;) {
    const JointId joint = model.links[link].parent_joint;
    if (!joint.valid() || chain.size() > model.joints.size()) {
      throw std::invalid_argument("arm " + arm.name + ": its base link is no ancestor of its tool");
    }
    chain.push_back(joint);
    link = model.joints[joint].parent_link;
  }
  std::reverse(chain.begin(), chain.end());
  return chain;
}

void requireUsable(const Joint& joint, const Arm& arm) {
  if (joint.mimic) {
    throw std::invalid_argument("arm " + arm.name + ": joint " + joint.name +
                                " mimics another, so the arm is not a plain chain");
  }
  if (!std::isfinite(joint.lower) || !std::isfinite(joint.upper) || joint.lower > joint.upper) {
    throw std::invalid_argument("arm " + arm.name + ": joint " + joint.name +
                                " needs finite limits, lower <= upper");
  }
}

/// A rotation whose z axis is `axis`; the identity when it already is z.
Eigen::Matrix3d frameAlong(const Eigen::Vector3d& axis) {
  const Eigen::Vector3d z = axis.normalized();
  // The coordinate axis least along z: signed unit vectors then give signed permutations, exactly.
  int least = 0;
  z.cwiseAbs().minCoeff(&least);
  const Eigen::Vector3d helper = Eigen::Vector3d::Unit(least);
  const Eigen::Vector3d x = (helper - helper.dot(z) * z).normalized();
  Eigen::Matrix3d R;
  R << x, z.cross(x), z;
  return R;
}

/// R := R * Rz(angle).
inline void turnZ(Eigen::Matrix3d& R, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  const Eigen::Vector3d x = R.col(0), y = R.col(1);
  R.col(0) = c * x + s * y;
  R.col(1) = c * y - s * x;
}

}  // namespace

Chain::Chain(const RobotModel& model, const Arm& arm) {
  const std::vector<JointId> joints = jointsBetween(model, arm);
  std::vector<JointId> moving;
  for (const JointId j : joints) {
    if (model.joints[j].type != JointType::kFixed) moving.push_back(j);
  }
  if (moving.empty() || moving.size() > kMaxJoints) {
    throw std::invalid_argument("arm " + arm.name + ": has " + std::to_string(moving.size()) +
                                " joints; 1 to 8 can be handled");
  }
  if (moving != arm.joints) {
    throw std::invalid_argument("arm " + arm.name +
                                ": its joints are not those between its base and its tool link");
  }

  dofs_ = static_cast<int>(moving.size());
  for (ArmVector* limits : {&lower, &upper, &velocity, &acceleration}) limits->resize(dofs_);
  Pose X = Pose::Identity();  // from the last moved frame
  int i = 0;
  for (const JointId j : joints) {
    const Joint& joint = model.joints[j];
    X = X * joint.X_PJ;
    if (joint.type == JointType::kFixed) continue;
    requireUsable(joint, arm);
    const Eigen::Matrix3d R_JZ = frameAlong(joint.axis);
    steps_[i] = {X.linear() * R_JZ, X.translation()};
    X = Pose::Identity();
    X.linear() = R_JZ.transpose();
    prismatic_[i] = joint.type == JointType::kPrismatic;
    lower[i] = joint.lower;
    upper[i] = joint.upper;
    velocity[i] = joint.velocity;
    acceleration[i] = joint.acceleration;
    ++i;
  }
  steps_[dofs_] = {X.linear(), X.translation()};
}

Pose Chain::toolPose(const ArmVector& q) const {
  Eigen::Matrix3d R = steps_[0].R;
  Eigen::Vector3d p = steps_[0].p;
  for (int i = 0; i < dofs_; ++i) {
    if (prismatic_[i]) {
      p += q[i] * R.col(2);
    } else {
      turnZ(R, q[i]);
    }
    p += R * steps_[i + 1].p;
    R = (R * steps_[i + 1].R).eval();
  }
  Pose X = Pose::Identity();
  X.linear() = R;
  X.translation() = p;
  return X;
}

Pose Chain::toolPose(const ArmVector& q, ArmJacobian& J) const {
  J.resize(6, dofs_);
  std::array<Eigen::Vector3d, kMaxJoints> origins;
  Eigen::Matrix3d R = steps_[0].R;
  Eigen::Vector3d p = steps_[0].p;
  for (int i = 0; i < dofs_; ++i) {
    origins[i] = p;
    if (prismatic_[i]) {
      J.col(i).head<3>() = R.col(2);
      J.col(i).tail<3>().setZero();
      p += q[i] * R.col(2);
    } else {
      J.col(i).tail<3>() = R.col(2);
      turnZ(R, q[i]);
    }
    p += R * steps_[i + 1].p;
    R = (R * steps_[i + 1].R).eval();
  }
  for (int i = 0; i < dofs_; ++i) {
    if (prismatic_[i]) continue;
    const Eigen::Vector3d axis = J.col(i).tail<3>();
    J.col(i).head<3>() = axis.cross(p - origins[i]);
  }
  Pose X = Pose::Identity();
  X.linear() = R;
  X.translation() = p;
  return X;
}

std::array<Chain::Axis, kMaxJoints> Chain::axesAtZero() const {
  std::array<Axis, kMaxJoints> axes{};
  Eigen::Matrix3d R = steps_[0].R;
  Eigen::Vector3d p = steps_[0].p;
  for (int i = 0; i < dofs_; ++i) {
    axes[i] = {R.col(2), p};
    p += R * steps_[i + 1].p;
    R = (R * steps_[i + 1].R).eval();
  }
  return axes;
}

double Chain::reach() const {
  double reach = 0;
  for (int i = 0; i <= dofs_; ++i) {
    reach += steps_[i].p.norm();
    if (i < dofs_ && prismatic_[i]) reach += std::max(std::abs(lower[i]), std::abs(upper[i]));
  }
  return reach;
}

Vector6 poseError(const Pose& X_target, const Pose& X) {
  Vector6 error;
  error.head<3>() = X_target.translation() - X.translation();
  const Eigen::Matrix3d R = X_target.linear() * X.linear().transpose();
  const Eigen::Vector3d v =
      0.5 * Eigen::Vector3d(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  const double sine = v.norm(), cosine = 0.5 * (R.trace() - 1);
  if (cosine > 0) {
    // Below 1e-5 rad the sine is the angle to 1e-10 of its size.
    error.tail<3>() = sine < 1e-5 ? v : Eigen::Vector3d(v * (std::atan2(sine, cosine) / sine));
  } else if (sine > 1e-3) {
    error.tail<3>() = v * (std::atan2(sine, cosine) / sine);
  } else {
    // Near half a turn the skew part vanishes: the quaternion still knows the axis.
    const Eigen::AngleAxisd turn(R);
    error.tail<3>() = turn.angle() * turn.axis();
  }
  return error;
}

bool isRigid(const Pose& X) {
  const Eigen::Matrix3d R = X.linear();
  const Eigen::Matrix3d defect = R * R.transpose() - Eigen::Matrix3d::Identity();
  // NaN fails every comparison.
  return X.translation().allFinite() && defect.cwiseAbs().sum() < 1e-6 && R.determinant() > 0;
}

}  // namespace handover::kinematics
