// SPDX-License-Identifier: Apache-2.0
// The closed form for arms of seven revolute joints whose first three axes meet in a point S and
// whose last three meet in a point W. The elbow axis may pass beside S-E and E-W (Hubo: 30 mm), and
// the three axes of shoulder and wrist may lie in any order and at any angle to their neighbours
// but parallel.
//
// With the joints as rotations about their axes at q = 0 (product of exponentials), the tool pose
// asks for G = X_AT X_AT(0)^-1 = R1 R2 R3 R4 R5 R6 R7. The wrist point W goes to G W. Joint 4 alone
// sets |S W|; the shoulder's rotation turns the bent arm onto the line from S to G W and leaves the
// swivel angle about that line free; the wrist makes up the rest of the rotation.
#pragma once

#include "core/kinematics/chain.hpp"

#include <array>
#include <optional>

namespace handover::kinematics {

/// Three axes through one point, solved for a wanted rotation R = Rot(a, q1) Rot(b, q2) Rot(c, q3).
class ThreeAxes {
 public:
  ThreeAxes(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

  struct Answer {
    double q1, q2, q3;
  };

  /// What the answers share: q2 = phase +- the angle with this cosine and sine.
  struct Bend {
    int count;  ///< of answers, 0 to 2
    double cosine, sine;
  };

  /// @param R_c  where R takes c.
  Bend bend(const Eigen::Vector3d& R_c) const;

  /// @param R_c, R_side  where R takes c and side(). q1_free: taken for q1 where only q1 +- q3
  /// matters.
  /// @param legal  (joint 0 to 2, angle): asked of an angle before the next is worked out.
  /// @return the bend's answers; empty where an angle is not legal.
  template <typename Legal>
  std::array<std::optional<Answer>, 2> solve(const Bend& bend, const Eigen::Vector3d& R_c,
                                             const Eigen::Vector3d& R_side, double q1_free,
                                             const Legal& legal) const;

  const Eigen::Vector3d& c() const { return c_; }

  /// A unit vector across c.
  const Eigen::Vector3d& side() const { return side_; }

  /// False when two neighbouring axes are nearly parallel.
  bool usable() const { return amplitude_ > 0.1; }

 private:
  Eigen::Vector3d a_, b_, c_, side_, c_cross_side_;
  Eigen::Vector3d c_along_b_, c_across_b_, b_cross_c_;
  double offset_, amplitude_, cos_phase_, sin_phase_, phase_;
  bool right_angles_;
};

class SrsSolver {
 public:
  /// nullopt when the chain's axes do not lie as the closed form needs.
  static std::optional<SrsSolver> find(const Chain& chain);

  /// As ArmKinematics::wristReach.
  WristReach wristReach() const;
  /// As ArmKinematics::visit.
  IkCounts visit(const Chain& chain, const Pose& X_AT, const IkQuery& query,
                 const ArmVector& q_near, const ArmKinematics::Take& take) const;

 private:
  SrsSolver(const ThreeAxes& shoulder, const ThreeAxes& wrist)
      : shoulder_(shoulder), wrist_(wrist) {}

  /// One elbow angle and what follows from it alone.
  struct Elbow;
  struct Call;
  struct Swivel;
  /// False when the caller has had enough.
  bool visitBranches(const Elbow& elbow, const Swivel& swivel, const Call& call) const;
  int elbows(double squared_distance, std::array<Elbow, 2>& elbows) const;
  /// Of the elbow's bend, for a distance from S to W: beyond 1, by more than the doubt, there is
  /// none.
  double elbowCosine(double squared_distance) const;
  double elbowDoubt(double squared_distance) const;

  ThreeAxes shoulder_, wrist_;
  Eigen::Vector3d S_, W_;                  ///< at q = 0, in A
  Eigen::Vector3d u4_;                     ///< elbow axis
  Eigen::Vector3d S_to_axis_, axis_to_W_;  ///< by way of a point on the elbow axis
  Eigen::Vector3d u1_;                     ///< first axis
  double elbow_offset_ = 0, elbow_amplitude_ = 0, elbow_phase_ = 0;
  Pose X_TA_home_;       ///< inverse of X_AT(0)
  Eigen::Vector3d W_T_;  ///< W in T, wherever the arm is
  double mismatch_ = 0;  ///< by how much axes miss S or W [m]
};

/// The point nearest to the lines and the largest distance of one of them from it; nullopt if
/// parallel.
struct Meeting {
  Eigen::Vector3d point;
  double distance;
};

std::optional<Meeting> meetingPoint(const Chain::Axis* axes, int count);

}  // namespace handover::kinematics
