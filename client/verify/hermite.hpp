// SPDX-License-Identifier: Apache-2.0
// The cubic Hermite curve between two samples, and its exact extremes.
#pragma once

#include <vector>

namespace handover::verify {

/// q(s) for s in [0, h] with given values and slopes at both ends. @pre h > 0.
class HermiteCubic {
 public:
  HermiteCubic(double h, double q0, double qd0, double q1, double qd1);

  double position(double s) const { return ((a_ * s + b_) * s + c_) * s + d_; }

  double velocity(double s) const { return (3 * a_ * s + 2 * b_) * s + c_; }

  double acceleration(double s) const { return 6 * a_ * s + 2 * b_; }

  /// Where in [0, h] the position, the velocity, the acceleration can be extreme: the ends, and the
  /// roots of the derivative between them.
  std::vector<double> positionExtremes() const;
  std::vector<double> velocityExtremes() const;

  std::vector<double> accelerationExtremes() const { return {0, h_}; }

  /// Largest |velocity| on [0, h].
  double topSpeed() const;

 private:
  double h_, a_, b_, c_, d_;
};

}  // namespace handover::verify
