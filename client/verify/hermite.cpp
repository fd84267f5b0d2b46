// SPDX-License-Identifier: Apache-2.0
#include "verify/hermite.hpp"

namespace handover::verify {
namespace {

/// @return the Bernstein coefficients of q - q(0).
std::array<double, 6> changeOf(double h, const JointSample& a, const JointSample& b) {
  const double end = b.q - a.q;
  return {0,
          h / 5 * a.qd,
          2 * h / 5 * a.qd + h * h / 20 * a.qdd,
          end - 2 * h / 5 * b.qd + h * h / 20 * b.qdd,
          end - h / 5 * b.qd,
          end};
}

}  // namespace

HermiteQuintic::HermiteQuintic(double h, const JointSample& a, const JointSample& b)
    : c_{}, change_(0, h, changeOf(h, a, b)) {
  // What is left to do for the three upper powers once the first sample is met.
  const double dq = b.q - (a.q + h * (a.qd + h / 2 * a.qdd));
  const double dv = h * (b.qd - (a.qd + h * a.qdd));
  const double da = h * h * (b.qdd - a.qdd);
  c_[0] = a.q;
  c_[1] = a.qd;
  c_[2] = a.qdd / 2;
  c_[3] = (10 * dq - 4 * dv + da / 2) / (h * h * h);
  c_[4] = (-15 * dq + 7 * dv - da) / (h * h * h * h);
  c_[5] = (6 * dq - 3 * dv + da / 2) / (h * h * h * h * h);
}

double HermiteQuintic::position(double s) const {
  return c_[0] + s * (c_[1] + s * (c_[2] + s * (c_[3] + s * (c_[4] + s * c_[5]))));
}

double HermiteQuintic::velocity(double s) const {
  return c_[1] + s * (2 * c_[2] + s * (3 * c_[3] + s * (4 * c_[4] + s * 5 * c_[5])));
}

}  // namespace handover::verify
