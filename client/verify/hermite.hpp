// SPDX-License-Identifier: Apache-2.0
// The quintic Hermite curve between two samples, and rigorous bounds of it and its derivatives.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace handover::verify {

/// The largest value of a polynomial, and where.
struct Peak {
  double value = 0;
  double at = 0;  ///< in the polynomial's own argument
};

/// A polynomial of degree N on [from, to] by its Bernstein coefficients, between whose least and
/// greatest it lies everywhere.
template <std::size_t N>
class Bernstein {
 public:
  Bernstein(double from, double to, const std::array<double, N + 1>& c)
      : from_(from), to_(to), c_(c) {}

  /// Bounds of all values, reached where they belong to an end.
  double upperBound() const { return *std::max_element(c_.begin(), c_.end()); }

  double lowerBound() const { return *std::min_element(c_.begin(), c_.end()); }

  /// At least every |value|.
  double magnitude() const { return std::max(std::abs(upperBound()), std::abs(lowerBound())); }

  Bernstein<N - 1> derivative() const {
    std::array<double, N> d{};
    for (std::size_t i = 0; i < N; ++i) d[i] = N * (c_[i + 1] - c_[i]) / (to_ - from_);
    return {from_, to_, d};
  }

  Bernstein scaled(double factor, double offset = 0) const {
    Bernstein result = *this;
    for (double& c : result.c_) c = factor * c + offset;
    return result;
  }

  /// Both parts, divided at u in (0, 1) of the range, by de Casteljau.
  std::pair<Bernstein, Bernstein> split(double u) const {
    std::array<double, N + 1> left{}, right{}, work = c_;
    for (std::size_t level = 0; level <= N; ++level) {
      left[level] = work[0];
      right[N - level] = work[N - level];
      for (std::size_t i = 0; i + level < N; ++i) work[i] += u * (work[i + 1] - work[i]);
    }
    const double middle = from_ + u * (to_ - from_);
    return {{from_, middle, left}, {middle, to_, right}};
  }

  /// The part on [a, b]. @pre from <= a < b <= to.
  Bernstein part(double a, double b) const {
    Bernstein result = *this;
    if (b < to_) result = result.split((b - from_) / (to_ - from_)).first;
    if (a > from_) result = result.split((a - from_) / (result.to_ - from_)).second;
    return result;
  }

  /// The greatest value, at most `tolerance` less than the true one. A value that is no more than
  /// `enough` is not sought: then any bound up to `enough` is returned.
  Peak greatest(double tolerance, double enough) const {
    if (upperBound() <= enough) return {upperBound(), from_};
    Peak peak = c_.front() >= c_.back() ? Peak{c_.front(), from_} : Peak{c_.back(), to_};
    search(tolerance, 0, peak);
    return peak;
  }

 private:
  static constexpr int kMaxDepth = 48;

  void search(double tolerance, int depth, Peak& peak) const {
    if (upperBound() <= peak.value + tolerance || depth > kMaxDepth) return;
    const auto [left, right] = split(0.5);
    if (left.c_.back() > peak.value) peak = {left.c_.back(), left.to_};
    left.search(tolerance, depth + 1, peak);
    right.search(tolerance, depth + 1, peak);
  }

  double from_, to_;
  std::array<double, N + 1> c_;
};

/// Position, velocity and acceleration of a joint at a sample.
struct JointSample {
  double q = 0, qd = 0, qdd = 0;
};

/// q(s) for s in [0, h] with these values at both ends. @pre h > 0.
class HermiteQuintic {
 public:
  HermiteQuintic(double h, const JointSample& a, const JointSample& b);

  double position(double s) const;
  double velocity(double s) const;

  /// q less its value at the first sample: small numbers, so that derivatives keep their digits.
  const Bernstein<5>& change() const { return change_; }

  double first() const { return c_[0]; }

 private:
  std::array<double, 6> c_;  ///< of the powers of s
  Bernstein<5> change_;
};

}  // namespace handover::verify
