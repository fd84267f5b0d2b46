// SPDX-License-Identifier: Apache-2.0
// One joint between two samples: the quintic that has the position, velocity and acceleration of
// both. Its Bernstein coefficients enclose it, and so do those of its derivatives.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace handover {

/// Position [rad], velocity, acceleration of one joint at one time.
struct JointState {
  double q, qd, qdd;
};

class Quintic {
 public:
  /// @pre duration > 0 [s].
  Quintic(const JointState& begin, const JointState& end, double duration)
      : begin_(begin), end_(end), h_(duration) {}

  /// At tau [s] from the begin; exact where both states lie on one polynomial of lower degree too.
  JointState at(double tau) const {
    const double x = tau / h_;
    const double d = end_.q - begin_.q;
    const double v0 = h_ * begin_.qd, v1 = h_ * end_.qd;
    const double a0 = h_ * h_ * begin_.qdd, a1 = h_ * h_ * end_.qdd;
    const double c3 = 10 * d - 6 * v0 - 4 * v1 - 0.5 * (3 * a0 - a1);
    const double c4 = -15 * d + 8 * v0 + 7 * v1 + 0.5 * (3 * a0 - 2 * a1);
    const double c5 = 6 * d - 3 * (v0 + v1) - 0.5 * (a0 - a1);
    const double q = begin_.q + x * (v0 + x * (0.5 * a0 + x * (c3 + x * (c4 + x * c5))));
    const double qd = v0 + x * (a0 + x * (3 * c3 + x * (4 * c4 + x * 5 * c5)));
    const double qdd = a0 + x * (6 * c3 + x * (12 * c4 + x * 20 * c5));
    return {q, qd / h_, qdd / (h_ * h_)};
  }

  /// Bernstein coefficients: control point k stands at the time k * duration / 5.
  std::array<double, 6> controls() const {
    std::array<double, 6> b = offsets();
    for (double& it : b) it += begin_.q;
    b[5] = end_.q;
    return b;
  }

  std::array<double, 5> velocityControls() const {
    std::array<double, 5> b = differences(offsets(), 5 / h_);
    b[0] = begin_.qd;
    b[4] = end_.qd;
    return b;
  }

  std::array<double, 4> accelerationControls() const {
    std::array<double, 4> b = differences(velocityControls(), 4 / h_);
    b[0] = begin_.qdd;
    b[3] = end_.qdd;
    return b;
  }

  std::array<double, 3> jerkControls() const { return differences(accelerationControls(), 3 / h_); }

 private:
  std::array<double, 6> offsets() const {
    const double d = end_.q - begin_.q;
    const double v0 = 0.2 * h_ * begin_.qd, v1 = 0.2 * h_ * end_.qd;
    const double a0 = 0.05 * h_ * h_ * begin_.qdd, a1 = 0.05 * h_ * h_ * end_.qdd;
    return {0, v0, 2 * v0 + a0, d - 2 * v1 + a1, d - v1, d};
  }

  template <std::size_t n>
  static std::array<double, n - 1> differences(const std::array<double, n>& b, double factor) {
    std::array<double, n - 1> d;
    for (std::size_t i = 0; i + 1 < n; ++i) d[i] = factor * (b[i + 1] - b[i]);
    return d;
  }

  JointState begin_, end_;
  double h_;
};

/// The greatest value on [0, 1] of the polynomial with these Bernstein coefficients, or `at_least`
/// if that is more: never too low, too high by at most `tolerance`.
template <std::size_t n>
double greatestValue(const std::array<double, n>& b, double at_least, double tolerance,
                     int depth = 40) {
  double best = at_least > b[0] ? at_least : b[0];
  best = best > b[n - 1] ? best : b[n - 1];
  double hull = best;
  for (std::size_t i = 1; i + 1 < n; ++i) hull = hull > b[i] ? hull : b[i];
  if (hull - best <= tolerance || depth == 0) return hull;
  std::array<double, n> left, right = b;  // de Casteljau at the middle
  for (std::size_t k = 0; k < n; ++k) {
    left[k] = right[0];
    for (std::size_t i = 0; i + 1 < n - k; ++i) right[i] = 0.5 * (right[i] + right[i + 1]);
  }
  best = greatestValue(left, best, tolerance, depth - 1);
  return greatestValue(right, best, tolerance, depth - 1);
}

/// The same of the polynomial's absolute value.
template <std::size_t n>
double greatestMagnitude(std::array<double, n> b, double at_least, double tolerance) {
  at_least = greatestValue(b, at_least, tolerance);
  for (double& it : b) it = -it;
  return greatestValue(b, at_least, tolerance);
}

}  // namespace handover
