// SPDX-License-Identifier: Apache-2.0
#include "core/kinematics/srs_solver.hpp"

#include "core/kinematics/damped_least_squares.hpp"
#include "core/kinematics/joint_revolutions.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

namespace handover::kinematics {
namespace {

using Eigen::Vector3d;

// URDFs that write 1.57 for pi/2 miss the common points by less than 0.1 mm.
constexpr double kMeetingTolerance = 1e-4;
// How far Newton may have to carry such an arm's closed-form answer back into the limits [rad].
constexpr double kRoughSlack = 5e-3;
constexpr double kSlack = 1e-9;
// Axes that miss each other by less than this meet [m].
constexpr double kExact = 1e-11;

/// Rot(axis, angle) v.
inline Vector3d rotate(const Vector3d& axis, double cosine, double sine, const Vector3d& v) {
  return cosine * v + sine * axis.cross(v) + ((1 - cosine) * axis.dot(v)) * axis;
}

/// A unit vector across `v`.
Vector3d across(const Vector3d& v) {
  int least = 0;
  v.cwiseAbs().minCoeff(&least);
  return v.cross(Vector3d::Unit(least)).normalized();
}

/// k-th of n numbers 0 .. n-1 in bit-reversed order: every prefix is spread evenly. `bits` covers
/// n.
std::uint32_t reverseBits(std::uint32_t k, int bits) {
  std::uint32_t reversed = 0;
  for (int b = 0; b < bits; ++b) reversed |= ((k >> b) & 1u) << (bits - 1 - b);
  return reversed;
}

}  // namespace

std::optional<Meeting> meetingPoint(const Chain::Axis* axes, int count) {
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Vector3d b = Vector3d::Zero();
  for (int i = 0; i < count; ++i) {
    const Eigen::Matrix3d P =
        Eigen::Matrix3d::Identity() - axes[i].direction * axes[i].direction.transpose();
    A += P;
    b += P * axes[i].point;
  }
  if (A.determinant() < 1e-3) return std::nullopt;
  Meeting meeting{A.inverse() * b, 0};
  for (int i = 0; i < count; ++i) {
    const double distance = axes[i].direction.cross(meeting.point - axes[i].point).norm();
    meeting.distance = std::max(meeting.distance, distance);
  }
  return meeting;
}

ThreeAxes::ThreeAxes(const Vector3d& a, const Vector3d& b, const Vector3d& c)
    : a_(a), b_(b), c_(c), side_(across(c)) {
  c_cross_side_ = c_.cross(side_);
  c_along_b_ = b_.dot(c_) * b_;
  c_across_b_ = c_ - c_along_b_;
  b_cross_c_ = b_.cross(c_);
  // a . Rot(b, q2) c = offset + amplitude cos(q2 - phase).
  offset_ = a_.dot(c_along_b_);
  const double cosine = a_.dot(c_across_b_), sine = a_.dot(b_cross_c_);
  amplitude_ = std::hypot(cosine, sine);
  cos_phase_ = amplitude_ > 0 ? cosine / amplitude_ : 1;
  sin_phase_ = amplitude_ > 0 ? sine / amplitude_ : 0;
  phase_ = std::atan2(sine, cosine);
  right_angles_ = std::abs(a_.dot(b_)) < 1e-12 && std::abs(b_.dot(c_)) < 1e-12;
}

ThreeAxes::Bend ThreeAxes::bend(const Vector3d& R_c) const {
  // Rounding, and the 1e-3 rad of axes that were meant to be square, may ask for a little too much.
  constexpr double kOvershoot = 1e-5;
  double cosine = (a_.dot(R_c) - offset_) / amplitude_;
  if (!(std::abs(cosine) <= 1 + kOvershoot)) return {0, 0, 0};
  cosine = std::clamp(cosine, -1.0, 1.0);
  // The cross product keeps all digits of a small angle; the cosine loses half of them.
  const double sine = right_angles_ ? a_.cross(R_c).norm() : std::sqrt((1 - cosine) * (1 + cosine));
  return {sine < 1e-7 ? 1 : 2, cosine, sine};  // both answers may be one
}

template <typename Legal>
std::array<std::optional<ThreeAxes::Answer>, 2> ThreeAxes::solve(const Bend& bend,
                                                                 const Vector3d& R_c,
                                                                 const Vector3d& R_side,
                                                                 double q1_free,
                                                                 const Legal& legal) const {
  const auto& [count, cosine, sine] = bend;
  const double angle = std::atan2(sine, cosine);
  std::array<std::optional<Answer>, 2> answers;
  for (int i = 0; i < count; ++i) {
    const double sign = i == 0 ? 1.0 : -1.0;
    Answer answer;
    answer.q2 = phase_ + sign * angle;
    if (!legal(1, answer.q2)) continue;
    const double c2 = cosine * cos_phase_ - sign * sine * sin_phase_;
    const double s2 = sign * sine * cos_phase_ + cosine * sin_phase_;
    // q1 turns Rot(b, q2) c onto R c; where that lies on the first axis any q1 does.
    const Vector3d from = c_along_b_ + c2 * c_across_b_ + s2 * b_cross_c_;
    double c1 = from.dot(R_c) - a_.dot(from) * a_.dot(R_c);
    double s1 = a_.dot(from.cross(R_c));
    const double length = std::sqrt(c1 * c1 + s1 * s1);
    if (length < 1e-9) {
      answer.q1 = q1_free;
      c1 = std::cos(q1_free);
      s1 = std::sin(q1_free);
    } else {
      answer.q1 = std::atan2(s1, c1);
      c1 /= length;
      s1 /= length;
    }
    if (!legal(0, answer.q1)) continue;
    const Vector3d v = rotate(b_, c2, -s2, rotate(a_, c1, -s1, R_side));
    answer.q3 = std::atan2(v.dot(c_cross_side_), v.dot(side_));
    if (legal(2, answer.q3)) answers[i] = answer;
  }
  return answers;
}

std::optional<SrsSolver> SrsSolver::find(const Chain& chain) {
  if (chain.dofs() != 7) return std::nullopt;
  for (int i = 0; i < 7; ++i) {
    if (chain.prismatic(i)) return std::nullopt;
  }
  const auto axes = chain.axesAtZero();
  const std::optional<Meeting> S = meetingPoint(&axes[0], 3), W = meetingPoint(&axes[4], 3);
  if (!S || !W || S->distance > kMeetingTolerance || W->distance > kMeetingTolerance) {
    return std::nullopt;
  }
  SrsSolver solver(ThreeAxes(axes[0].direction, axes[1].direction, axes[2].direction),
                   ThreeAxes(axes[4].direction, axes[5].direction, axes[6].direction));
  if (!solver.shoulder_.usable() || !solver.wrist_.usable()) return std::nullopt;

  solver.S_ = S->point;
  solver.W_ = W->point;
  solver.mismatch_ = std::max(S->distance, W->distance);
  solver.u1_ = axes[0].direction;
  const Vector3d& u4 = solver.u4_ = axes[3].direction;
  const Vector3d& a = solver.axis_to_W_ = W->point - axes[3].point;
  const Vector3d& b = solver.S_to_axis_ = axes[3].point - S->point;
  // |b + Rot(u4, q4) a|^2 / 2 = offset + amplitude cos(q4 - phase).
  const double along = u4.dot(a) * u4.dot(b);
  const double cosine = a.dot(b) - along, sine = b.dot(u4.cross(a));
  solver.elbow_amplitude_ = std::hypot(cosine, sine);
  solver.elbow_phase_ = std::atan2(sine, cosine);
  solver.elbow_offset_ = 0.5 * (a.squaredNorm() + b.squaredNorm()) + along;
  if (solver.elbow_amplitude_ < 1e-6)
    return std::nullopt;  // the elbow does not change the distance

  solver.X_TA_home_ = chain.toolPose(ArmVector::Zero(7)).inverse();
  solver.W_T_ = solver.X_TA_home_ * solver.W_;
  return solver;
}

struct SrsSolver::Elbow {
  double q4;
  Vector3d z, y, x;                 ///< of the bent arm at R123 = 1: S to W, elbow axis across it
  Vector3d back_z, back_y, back_x;  ///< the same turned back by joint 4
};

double SrsSolver::elbowCosine(double squared_distance) const {
  return (0.5 * squared_distance - elbow_offset_) / elbow_amplitude_;
}

/// Where axes miss S and W the true arm may reach as much farther.
double SrsSolver::elbowDoubt(double squared_distance) const {
  if (mismatch_ < kExact) return 0;
  return std::min(0.5, 4 * mismatch_ * std::sqrt(squared_distance) / elbow_amplitude_);
}

WristReach SrsSolver::wristReach() const {
  // elbowCosine() of the ends, with the doubt at the farthest.
  const double cosine = 1 + 1e-9 + elbowDoubt(2 * (elbow_offset_ + 2 * elbow_amplitude_));
  return {W_T_, S_, 2 * (elbow_offset_ - elbow_amplitude_ * cosine),
          2 * (elbow_offset_ + elbow_amplitude_ * cosine)};
}

int SrsSolver::elbows(double squared_distance, std::array<Elbow, 2>& found) const {
  double cosine = elbowCosine(squared_distance);
  // Newton decides in doubt, but cannot bend an arm that starts out straight: there it starts as
  // bent as the doubt allows.
  const double doubt = elbowDoubt(squared_distance);
  if (!(std::abs(cosine) <= 1 + 1e-12 + doubt)) return 0;
  cosine = std::clamp(cosine, -1 + doubt, 1 - doubt);
  const double angle = std::acos(cosine);

  int count = 0;
  for (const double sign : {1.0, -1.0}) {
    if (sign < 0 && angle < 1e-7) break;  // stretched: both answers are one
    Elbow& elbow = found[count];
    elbow.q4 = elbow_phase_ + sign * angle;
    const double c = std::cos(elbow.q4), s = std::sin(elbow.q4);
    const Vector3d S_to_W = S_to_axis_ + rotate(u4_, c, s, axis_to_W_);
    const double length = S_to_W.norm();
    if (length < 1e-6) continue;  // W in S: no swivel axis
    elbow.z = S_to_W / length;
    const Vector3d y = u4_ - u4_.dot(elbow.z) * elbow.z;
    const double y_length = y.norm();
    if (y_length < 1e-6) continue;
    elbow.y = y / y_length;
    elbow.x = elbow.y.cross(elbow.z);
    elbow.back_z = rotate(u4_, c, -s, elbow.z);
    elbow.back_y = rotate(u4_, c, -s, elbow.y);
    elbow.back_x = rotate(u4_, c, -s, elbow.x);
    ++count;
  }
  return count;
}

/// One call of visit(): what each branch needs, and where its answers go.
struct SrsSolver::Call {
  const Chain& chain;
  const Pose& X_AT;
  const IkQuery& query;
  const ArmVector& q_near;
  double slack;
  IkCounts& counts;
  const ArmKinematics::Take& take;

  bool legal(int joint, double angle) const {
    return !windings(angle, chain.lower[joint], chain.upper[joint], slack).none();
  }

  auto legalFrom(int first_joint) const {
    return
        [this, first_joint](int joint, double angle) { return legal(first_joint + joint, angle); };
  }

  /// False when the caller has had enough.
  bool add(ArmVector q) const {
    if (!polish(chain, X_AT, q)) {
      ++counts.no_ik;
      return true;
    }
    const CopiesTaken taken = forEachEquivalent(chain, query, q_near, q, take);
    counts.solutions += static_cast<std::uint32_t>(taken.count);
    if (taken.count == 0) ++counts.limits;
    return taken.go_on;
  }
};

/// The frame of the line from S to the goal's W at one swivel angle, and in it the tool's wanted
/// directions.
struct SrsSolver::Swivel {
  Vector3d x, y, z;
  Vector3d wrist_c, wrist_side;
};

bool SrsSolver::visitBranches(const Elbow& elbow, const Swivel& swivel, const Call& call) const {
  const auto shoulderTakes = [&](const Vector3d& v) -> Vector3d {
    return elbow.x.dot(v) * swivel.x + elbow.y.dot(v) * swivel.y + elbow.z.dot(v) * swivel.z;
  };
  const auto wristSees = [&](const Vector3d& v) -> Vector3d {
    return v.x() * elbow.back_x + v.y() * elbow.back_y + v.z() * elbow.back_z;
  };
  const Vector3d shoulder_c = shoulderTakes(shoulder_.c());
  const Vector3d wrist_c = wristSees(swivel.wrist_c);
  const ThreeAxes::Bend shoulder_bend = shoulder_.bend(shoulder_c);
  const ThreeAxes::Bend wrist_bend = wrist_.bend(wrist_c);
  if (shoulder_bend.count * wrist_bend.count == 0) {
    ++call.counts.no_ik;
    return true;
  }
  const auto shoulders = shoulder_.solve(shoulder_bend, shoulder_c, shoulderTakes(shoulder_.side()),
                                         call.q_near[0], call.legalFrom(0));
  if (!shoulders[0] && !shoulders[1]) {
    call.counts.limits += shoulder_bend.count * wrist_bend.count;
    return true;
  }
  const auto wrists = wrist_.solve(wrist_bend, wrist_c, wristSees(swivel.wrist_side),
                                   call.q_near[4], call.legalFrom(4));
  for (int a = 0; a < shoulder_bend.count; ++a) {
    for (int b = 0; b < wrist_bend.count; ++b) {
      if (!shoulders[a] || !wrists[b]) {
        ++call.counts.limits;
        continue;
      }
      ArmVector q(7);
      q << shoulders[a]->q1, shoulders[a]->q2, shoulders[a]->q3, elbow.q4, wrists[b]->q1,
          wrists[b]->q2, wrists[b]->q3;
      if (!call.add(q)) return false;
    }
  }
  return true;
}

IkCounts SrsSolver::visit(const Chain& chain, const Pose& X_AT, const IkQuery& query,
                          const ArmVector& q_near, const ArmKinematics::Take& take) const {
  IkCounts counts;
  const Pose G = X_AT * X_TA_home_;
  const Vector3d S_to_goal = G * W_ - S_;
  const double squared_distance = S_to_goal.squaredNorm();
  std::array<Elbow, 2> elbow_answers;
  const int elbow_count = squared_distance > 1e-12 ? elbows(squared_distance, elbow_answers) : 0;
  if (elbow_count == 0) {
    counts.no_ik = 1;
    return counts;
  }
  const double slack = mismatch_ < kExact ? kSlack : kRoughSlack;
  const Call call{chain, X_AT, query, q_near, slack, counts, take};

  // At swivel 0 the elbow axis is square to the first axis.
  Swivel swivel;
  swivel.z = S_to_goal / std::sqrt(squared_distance);
  const Vector3d square = u1_.cross(swivel.z);
  const Vector3d y0 = square.squaredNorm() > 1e-12 ? square.normalized() : across(swivel.z);
  const Vector3d x0 = y0.cross(swivel.z);
  const Vector3d G_c = G.linear() * wrist_.c(), G_side = G.linear() * wrist_.side();

  const auto samples = static_cast<std::uint32_t>(std::max(query.swivel_samples, 0));
  const int bits = std::bit_width(samples > 0 ? samples - 1 : 0);
  for (std::uint64_t k = 0; k < std::uint64_t{1} << bits; ++k) {
    const std::uint32_t place = reverseBits(static_cast<std::uint32_t>(k), bits);
    if (place >= samples) continue;
    const double angle = query.swivel_offset + kTurn * place / samples;
    const double cosine = std::cos(angle), sine = std::sin(angle);
    swivel.x = cosine * x0 + sine * y0;
    swivel.y = cosine * y0 - sine * x0;
    swivel.wrist_c << swivel.x.dot(G_c), swivel.y.dot(G_c), swivel.z.dot(G_c);
    swivel.wrist_side << swivel.x.dot(G_side), swivel.y.dot(G_side), swivel.z.dot(G_side);
    for (int e = 0; e < elbow_count; ++e) {
      if (!call.legal(3, elbow_answers[e].q4)) {
        counts.limits += 4;
      } else if (!visitBranches(elbow_answers[e], swivel, call)) {
        return counts;
      }
    }
  }
  return counts;
}

}  // namespace handover::kinematics
