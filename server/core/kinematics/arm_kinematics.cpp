// SPDX-License-Identifier: Apache-2.0
#include "core/kinematics/arm_kinematics.hpp"

#include "core/kinematics/chain.hpp"
#include "core/kinematics/damped_least_squares.hpp"
#include "core/kinematics/iterative_solver.hpp"
#include "core/kinematics/srs_solver.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace handover {

using kinematics::Chain;
using kinematics::IterativeSolver;
using kinematics::SrsSolver;

namespace {

const Arm& armOf(const RobotModel& model, ArmId arm) {
  if (!arm.valid() || std::size_t{arm} >= model.arms.size()) {
    throw std::invalid_argument("robot " + model.name + " has no arm " +
                                std::to_string(arm.value()));
  }
  return model.arms[arm];
}

Eigen::Vector3d shoulderOf(const Chain& chain, const Arm& arm) {
  // Arms whose shoulder axes pass each other this closely still have one shoulder [m].
  constexpr double kNear = 0.01;
  if (arm.p_AShoulder) return *arm.p_AShoulder;
  const auto axes = chain.axesAtZero();
  for (const int count : {3, 2}) {
    bool turning = chain.dofs() >= count;
    for (int i = 0; i < count && turning; ++i) turning = !chain.prismatic(i);
    if (!turning) continue;
    const auto meeting = kinematics::meetingPoint(axes.data(), count);
    if (meeting && meeting->distance < kNear) return meeting->point;
  }
  return axes[0].point;
}

}  // namespace

struct ArmKinematics::Data {
  Chain chain;
  std::optional<SrsSolver> srs;
  std::optional<WristReach> wrist_reach;
  std::optional<IterativeSolver> iterative;  ///< where there is no closed form
  ArmVector middle;
  Eigen::Vector3d p_AShoulder;

  Data(const RobotModel& model, const Arm& arm)
      : chain(model, arm),
        srs(SrsSolver::find(chain)),
        middle(0.5 * (chain.lower + chain.upper)),
        p_AShoulder(shoulderOf(chain, arm)) {
    if (srs) wrist_reach = srs->wristReach();
    if (!srs) iterative.emplace(chain);
  }

  void requireSize(const ArmVector& q) const {
    if (q.size() == chain.dofs()) return;
    throw std::invalid_argument("an arm of " + std::to_string(chain.dofs()) + " joints was given " +
                                std::to_string(q.size()) + " positions");
  }
};

ArmKinematics::ArmKinematics(const RobotModel& model, ArmId arm)
    : data_(std::make_unique<const Data>(model, armOf(model, arm))) {}

ArmKinematics::~ArmKinematics() = default;
ArmKinematics::ArmKinematics(ArmKinematics&&) noexcept = default;
ArmKinematics& ArmKinematics::operator=(ArmKinematics&&) noexcept = default;

int ArmKinematics::dofs() const { return data_->chain.dofs(); }

const ArmVector& ArmKinematics::lower() const { return data_->chain.lower; }

const ArmVector& ArmKinematics::upper() const { return data_->chain.upper; }

const ArmVector& ArmKinematics::velocity() const { return data_->chain.velocity; }

const ArmVector& ArmKinematics::acceleration() const { return data_->chain.acceleration; }

const std::optional<WristReach>& ArmKinematics::wristReach() const { return data_->wrist_reach; }

double ArmKinematics::reach() const { return data_->chain.reach(); }

Eigen::Vector3d ArmKinematics::shoulder() const { return data_->p_AShoulder; }

bool ArmKinematics::closedForm() const { return data_->srs.has_value(); }

Pose ArmKinematics::toolPose(const ArmVector& q) const {
  data_->requireSize(q);
  return data_->chain.toolPose(q);
}

Pose ArmKinematics::toolPose(const ArmVector& q, ArmJacobian& J) const {
  data_->requireSize(q);
  return data_->chain.toolPose(q, J);
}

ArmJacobian ArmKinematics::jacobian(const ArmVector& q) const {
  ArmJacobian J;
  toolPose(q, J);
  return J;
}

double ArmKinematics::manipulability(const ArmVector& q) const {
  return handover::manipulability(jacobian(q));
}

bool ArmKinematics::withinLimits(const ArmVector& q, double tolerance) const {
  if (q.size() != dofs()) return false;
  for (int i = 0; i < dofs(); ++i) {
    if (!(q[i] >= lower()[i] - tolerance && q[i] <= upper()[i] + tolerance)) return false;
  }
  return true;
}

IkCounts ArmKinematics::solve(const Pose& X_AT, const IkQuery& query,
                              std::vector<ArmVector>& out) const {
  return visit(X_AT, query, [&](const ArmVector& q) {
    out.push_back(q);
    return true;
  });
}

IkCounts ArmKinematics::visit(const Pose& X_AT, const IkQuery& query, const Take& take) const {
  if (query.q_near.size() > 0) data_->requireSize(query.q_near);
  const ArmVector& q_near =
      query.q_near.size() > 0 && query.q_near.allFinite() ? query.q_near : data_->middle;
  if (!kinematics::isRigid(X_AT) || !std::isfinite(query.swivel_offset)) {
    IkCounts counts;
    counts.no_ik = 1;
    return counts;
  }
  return data_->srs ? data_->srs->visit(data_->chain, X_AT, query, q_near, take)
                    : data_->iterative->visit(data_->chain, X_AT, query, q_near, take);
}

bool ArmKinematics::trackPose(const Pose& X_AT, const ArmVector& q_near, double max_step,
                              ArmVector& q) const {
  data_->requireSize(q_near);
  if (!kinematics::isRigid(X_AT) || !q_near.allFinite()) return false;
  ArmVector found;
  if (!kinematics::track(data_->chain, X_AT, q_near, found)) return false;
  if (!((found - q_near).cwiseAbs().maxCoeff() <= max_step)) return false;
  q = found;
  return true;
}

double manipulability(const ArmJacobian& J) {
  // The smaller of the two Gram matrices, factored by hand: sqrt(det) is the product of the
  // Cholesky factor's diagonal.
  const int n = static_cast<int>(std::min<Eigen::Index>(J.cols(), 6));
  Eigen::Matrix<double, 6, 6> G;
  if (J.cols() >= 6) {
    G.noalias() = J * J.transpose();
  } else {
    G.topLeftCorner(n, n) = J.transpose() * J;
  }
  double product = 1;
  for (int i = 0; i < n; ++i) {
    double pivot = G(i, i);
    for (int k = 0; k < i; ++k) pivot -= G(i, k) * G(i, k);
    if (!(pivot > 0)) return 0;
    const double root = std::sqrt(pivot);
    product *= root;
    for (int j = i + 1; j < n; ++j) {
      double sum = G(j, i);
      for (int k = 0; k < i; ++k) sum -= G(j, k) * G(i, k);
      G(j, i) = sum / root;
    }
  }
  return product;
}

}  // namespace handover
