// SPDX-License-Identifier: Apache-2.0
#include "verify/hermite.hpp"

#include <algorithm>
#include <cmath>

namespace handover::verify {

HermiteCubic::HermiteCubic(double h, double q0, double qd0, double q1, double qd1) : h_(h) {
  const double slope = (q1 - q0) / h;
  a_ = (qd0 + qd1 - 2 * slope) / (h * h);
  b_ = (3 * slope - 2 * qd0 - qd1) / h;
  c_ = qd0;
  d_ = q0;
}

std::vector<double> HermiteCubic::positionExtremes() const {
  std::vector<double> at = {0, h_};
  // Roots of 3a s² + 2b s + c, by the form that does not cancel.
  const double discriminant = b_ * b_ - 3 * a_ * c_;
  if (discriminant < 0) return at;
  const double k = -(b_ + std::copysign(std::sqrt(discriminant), b_));
  for (const double root : {k / (3 * a_), c_ / k}) {
    if (std::isfinite(root) && root > 0 && root < h_) at.push_back(root);
  }
  return at;
}

std::vector<double> HermiteCubic::velocityExtremes() const {
  std::vector<double> at = {0, h_};
  const double vertex = -b_ / (3 * a_);
  if (std::isfinite(vertex) && vertex > 0 && vertex < h_) at.push_back(vertex);
  return at;
}

double HermiteCubic::topSpeed() const {
  double top = 0;
  for (const double s : velocityExtremes()) top = std::max(top, std::abs(velocity(s)));
  return top;
}

}  // namespace handover::verify
