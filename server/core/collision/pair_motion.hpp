// SPDX-License-Identifier: Apache-2.0
// How two rigid bodies may move against each other, to first order and beyond.
#pragma once

#include <Eigen/Core>

namespace handover {

/// A rigid displacement to first order: the point p_W goes by v + w x p_W.
struct Twist {
  Eigen::Vector3d w = Eigen::Vector3d::Zero(), v = Eigen::Vector3d::Zero();
};

/// From where they stand, two bodies move by x * a and x * b with the same x from -1 to 1, and
/// besides by up to `beyond`, both taken together [m].
struct PairMotion {
  Twist a, b;
  double beyond = 0;
  double most = 0;  ///< all in all they come no nearer to each other than by this [m]
};

}  // namespace handover
