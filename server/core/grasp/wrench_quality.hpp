// SPDX-License-Identifier: Apache-2.0
// How well contacts hold an object: the largest ball in the hull of the wrenches they can exert.
#pragma once

#include <Eigen/Core>

#include <vector>

namespace handover {

struct ContactPoint {
  Eigen::Vector3d p;  ///< on the object
  Eigen::Vector3d n;  ///< unit, outward normal of the object
};

using Wrench = Eigen::Matrix<double, 6, 1>;

struct ContactModel {
  double friction = 0.6;
  /// Soft fingers: a contact of unit normal force also withstands a moment of friction *
  /// patch_radius about its normal. Without it two contacts never hold (they cannot stop the turn
  /// about their line).
  double patch_radius = 0.005;  ///< [m]
};

/// Wrenches of each contact with unit normal force: 8 edges of its friction cone and its two
/// greatest normal moments. Moments are about `centre`, divided by `size` [m] to weigh them against
/// forces.
std::vector<Wrench> contactWrenches(const std::vector<ContactPoint>& contacts,
                                    const Eigen::Vector3d& centre, double size,
                                    const ContactModel& model);

/// Radius of the largest ball around 0 in the convex hull of the wrenches (Ferrari-Canny); <= 0:
/// none, the contacts do not hold.
///
/// A polytope inside the hull grows where it is nearest to 0, so the answer is a lower bound: no
/// less than `enough` times the true radius, and certain in its sign.
double largestBall(const std::vector<Wrench>& wrenches, double enough = 0.9);

}  // namespace handover
