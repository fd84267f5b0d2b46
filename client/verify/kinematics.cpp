// SPDX-License-Identifier: Apache-2.0
#include "verify/kinematics.hpp"

#include <Eigen/LU>
#include <kdl/chain.hpp>
#include <kdl/chainjnttojacsolver.hpp>
#include <kdl/frames.hpp>
#include <kdl/jacobian.hpp>
#include <kdl/jntarray.hpp>
#include <kdl/segment.hpp>
#include <kdl/tree.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace handover::verify {
namespace {

KDL::Frame toKdl(const Pose& X) {
  KDL::Frame frame;
  for (int row = 0; row < 3; ++row) {
    frame.p(row) = X.translation()(row);
    for (int column = 0; column < 3; ++column) frame.M(row, column) = X.linear()(row, column);
  }
  return frame;
}

Pose toPose(const KDL::Frame& frame) {
  Pose X = Pose::Identity();
  for (int row = 0; row < 3; ++row) {
    X.translation()(row) = frame.p(row);
    for (int column = 0; column < 3; ++column) X.linear()(row, column) = frame.M(row, column);
  }
  return X;
}

KDL::Joint toKdl(const Joint& joint) {
  if (!joint.movable()) return KDL::Joint(joint.name, KDL::Joint::Fixed);
  const KDL::Frame X_PJ = toKdl(joint.X_PJ);
  const KDL::Vector axis = X_PJ.M * KDL::Vector(joint.axis.x(), joint.axis.y(), joint.axis.z());
  return {joint.name, X_PJ.p, axis,
          joint.type == JointType::kPrismatic ? KDL::Joint::TransAxis : KDL::Joint::RotAxis};
}

}  // namespace

struct Kinematics::Data {
  Robot robot;
  KDL::Frame X_WB;
  KDL::Tree tree;
  std::vector<KDL::Segment> segments;  ///< of robot.joints, in the same order
};

Kinematics::Kinematics(const Robot& robot, const Pose& X_WB) {
  auto data = std::make_unique<Data>();
  data->robot = robot;
  data->X_WB = toKdl(X_WB);
  data->tree = KDL::Tree(robot.links.front().name);
  for (const Joint& joint : robot.joints) {
    const Link& child = robot.links[static_cast<std::size_t>(joint.child)];
    const Link& parent = robot.links[static_cast<std::size_t>(joint.parent)];
    data->segments.emplace_back(child.name, toKdl(joint), toKdl(joint.X_PJ));
    data->tree.addSegment(data->segments.back(), parent.name);
  }
  data_ = std::move(data);
}

Kinematics::~Kinematics() = default;
Kinematics::Kinematics(Kinematics&&) noexcept = default;

void Kinematics::linkPoses(const std::vector<double>& q, std::vector<Pose>& X_WL) const {
  const Robot& robot = data_->robot;
  std::vector<KDL::Frame> frames(robot.links.size());
  frames.front() = data_->X_WB;
  X_WL.resize(robot.links.size());
  X_WL.front() = toPose(frames.front());
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const auto child = static_cast<std::size_t>(robot.joints[j].child);
    frames[child] =
        frames[static_cast<std::size_t>(robot.joints[j].parent)] * data_->segments[j].pose(q[j]);
    X_WL[child] = toPose(frames[child]);
  }
}

Pose Kinematics::linkPose(int link, const std::vector<double>& q) const {
  const Robot& robot = data_->robot;
  KDL::Frame X_AL = KDL::Frame::Identity();  // A: the link that has been climbed to
  for (int above = robot.links[static_cast<std::size_t>(link)].parent_joint; above >= 0;
       above = robot.links[static_cast<std::size_t>(link)].parent_joint) {
    const auto j = static_cast<std::size_t>(above);
    X_AL = data_->segments[j].pose(q[j]) * X_AL;
    link = robot.joints[j].parent;
  }
  return toPose(data_->X_WB * X_AL);
}

double Kinematics::manipulability(int link, const std::vector<int>& joints,
                                  const std::vector<double>& q) const {
  const Robot& robot = data_->robot;
  const std::vector<int> above = robot.jointsAbove(link);
  Eigen::MatrixXd wanted = Eigen::MatrixXd::Zero(6, static_cast<Eigen::Index>(joints.size()));
  if (!above.empty()) {
    KDL::Chain chain;
    if (!data_->tree.getChain(robot.links.front().name,
                              robot.links[static_cast<std::size_t>(link)].name, chain)) {
      throw std::logic_error("no chain from the root to the link");
    }
    KDL::JntArray positions(chain.getNrOfJoints());
    for (std::size_t i = 0; i < above.size(); ++i) {
      positions(static_cast<unsigned>(i)) = q[static_cast<std::size_t>(above[i])];
    }
    KDL::Jacobian jacobian(chain.getNrOfJoints());
    KDL::ChainJntToJacSolver(chain).JntToJac(positions, jacobian);
    for (std::size_t i = 0; i < above.size(); ++i) {
      const Law law = robot.lawOf(static_cast<std::size_t>(above[i]));
      const auto named = std::find(joints.begin(), joints.end(), static_cast<int>(law.master));
      if (named == joints.end()) continue;
      wanted.col(named - joints.begin()) +=
          law.multiplier * jacobian.data.col(static_cast<Eigen::Index>(i));
    }
  }
  if (joints.size() < 6) return 0;
  return std::sqrt(std::max(0.0, (wanted * wanted.transpose()).determinant()));
}

}  // namespace handover::verify
