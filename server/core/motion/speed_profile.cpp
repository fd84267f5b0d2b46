// SPDX-License-Identifier: Apache-2.0
#include "core/motion/speed_profile.hpp"

#include <algorithm>
#include <cmath>

namespace handover {
namespace {

constexpr double kHuge = 1e300;
constexpr double kRounding = 1e-9;  // of an acceleration limit, of speeds that were bounded by it

double square(double x) { return x * x; }

}  // namespace

SpeedProfile::SpeedProfile(const CornerPath& path, const TimingLimits& limits) : path_(path) {
  makeRows(limits);
  cap(limits);
  backward();
  forward();
  measureTime();
}

void SpeedProfile::makeRows(const TimingLimits& limits) {
  const std::size_t dof = path_.dof, n = path_.cells();
  rows_.resize(n * 2 * dof);
  row_cap_.assign(n, kHuge);
  straight_reach_.assign(n, kHuge);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < dof; ++j) {
      const double a = limits.acceleration[static_cast<Eigen::Index>(j)];
      const double b = path_.curvature[i * dof + j];
      const double c0 = path_.q_s[i * dof + j];
      if (path_.straight[i]) {
        straight_reach_[i] = std::min(straight_reach_[i], a / std::max(std::abs(c0), 1e-12));
        continue;
      }
      // At the cell's end x is x + 2 ds u and q_s is the next point's.
      const double c1 = path_.q_s[(i + 1) * dof + j] + 2 * path_.ds[i] * b;
      rows_[(2 * i) * dof + j] = makeRow(i, a, b, c0);
      rows_[(2 * i + 1) * dof + j] = makeRow(i, a, b, c1);
    }
  }
}

SpeedProfile::Row SpeedProfile::makeRow(std::size_t cell, double a, double b, double c) {
  if (std::abs(c) > 1e-9) return {a / std::abs(c), b / c};
  if (b != 0) row_cap_[cell] = std::min(row_cap_[cell], a / std::abs(b));
  return {kHuge, 0};
}

// Speed limits: |q_s| is largest at the ends of a cell, and so is x.
void SpeedProfile::cap(const TimingLimits& limits) {
  const std::size_t dof = path_.dof, n = path_.cells();
  cap_.assign(n + 1, kHuge);
  for (std::size_t i = 0; i < n; ++i) {
    double x = row_cap_[i];
    for (std::size_t j = 0; j < dof; ++j) {
      const double q_s =
          std::max(std::abs(path_.q_s[i * dof + j]), std::abs(path_.q_s[(i + 1) * dof + j]));
      const double v = limits.velocity[static_cast<Eigen::Index>(j)];
      if (q_s * 1e150 > v) x = std::min(x, square(v / q_s));
    }
    cap_[i] = std::min(cap_[i], x);
    cap_[i + 1] = std::min(cap_[i + 1], x);
  }
  cap_.front() = cap_.back() = 0;
}

// The tightest bounds at x; `next` is the greatest x allowed at the cell's end.
SpeedProfile::Range SpeedProfile::range(std::size_t cell, double x, double next) const {
  const double per = 1 / (2 * path_.ds[cell]);
  Range r{next * per, -per, 0, -per};
  if (path_.straight[cell]) {
    const double reach = straight_reach_[cell];
    if (reach < r.high(x)) r.high0 = reach, r.high1 = 0;
    if (-reach > r.low(x)) r.low0 = -reach, r.low1 = 0;
    return r;
  }
  double high = r.high(x), low = r.low(x);
  const Row* rows = &rows_[2 * cell * path_.dof];
  for (std::size_t k = 0; k < 2 * path_.dof; ++k) {
    const double shift = rows[k].slope * x;
    if (rows[k].reach - shift < high) {
      high = rows[k].reach - shift;
      r.high0 = rows[k].reach, r.high1 = -rows[k].slope;
    }
    if (-rows[k].reach - shift > low) {
      low = -rows[k].reach - shift;
      r.low0 = -rows[k].reach, r.low1 = -rows[k].slope;
    }
  }
  return r;
}

// Greatest x of each point from which the end can be reached at rest. x = 0, u = 0 keeps every
// bound, so the set is [0, reach]; its end is found by cutting with the two bounds that cross
// until none do.
void SpeedProfile::backward() {
  const std::size_t n = path_.cells();
  reach_.assign(n + 1, 0);
  for (std::size_t i = n; i-- > 0;) {
    double x = cap_[i];
    for (int cut = 0; cut < 100 && x > 0; ++cut) {
      const Range r = range(i, x, reach_[i + 1]);
      const double gap = r.low(x) - r.high(x);
      if (gap <= 1e-12 * (std::abs(r.low(x)) + std::abs(r.high(x)))) break;
      x = std::clamp((r.high0 - r.low0) / (r.low1 - r.high1), 0.0, x);
    }
    reach_[i] = x;
  }
}

void SpeedProfile::forward() {
  const std::size_t n = path_.cells();
  x_.assign(n + 1, 0);
  for (std::size_t i = 0; i < n; ++i) {
    const double u = range(i, x_[i], reach_[i + 1]).high(x_[i]);
    x_[i + 1] = std::clamp(x_[i] + 2 * path_.ds[i] * u, 0.0, reach_[i + 1]);
  }
}

void SpeedProfile::measureTime() {
  const std::size_t n = path_.cells();
  t_.assign(n + 1, 0);
  for (std::size_t i = 0; i < n; ++i) {
    const double speeds = std::sqrt(x_[i]) + std::sqrt(x_[i + 1]);
    if (!(speeds > 0)) passable_ = false;
    t_[i + 1] = t_[i] + 2 * path_.ds[i] / speeds;
  }
}

double SpeedProfile::buildUp(const TimingLimits& limits) const {
  double longest = 0;
  for (std::size_t i = 0; i < path_.cells(); ++i) {
    const double u = std::abs(x_[i + 1] - x_[i]) / (2 * path_.ds[i]);
    for (std::size_t j = 0; j < path_.dof; ++j) {
      const auto joint = static_cast<Eigen::Index>(j);
      const double a = u * std::abs(path_.q_s[i * path_.dof + j]);
      longest = std::max(longest, std::min(a, limits.acceleration[joint]) / limits.jerk[joint]);
    }
  }
  return longest;
}

void SpeedProfile::slowDown(double factor) {
  for (double& x : x_) x /= square(factor);
  for (double& t : t_) t *= factor;
}

bool SpeedProfile::allowed(std::size_t cell, double x, double next) const {
  const double u = (next - x) / (2 * path_.ds[cell]);
  if (path_.straight[cell]) return std::abs(u) <= straight_reach_[cell] * (1 + kRounding);
  if (x > row_cap_[cell]) return false;
  const Row* rows = &rows_[2 * cell * path_.dof];
  return std::all_of(rows, rows + 2 * path_.dof, [&](const Row& row) {
    return std::abs(u + row.slope * x) <= row.reach * (1 + kRounding);
  });
}

// Returns the point from which to go on.
std::size_t SpeedProfile::flattenPeak(std::size_t peak, double window) {
  std::size_t first = peak, last = peak;  // of the points that get the level
  double level = x_[peak], length = 0;
  while (length < window * std::sqrt(level)) {
    const double before = first > 0 ? x_[first - 1] : 0;
    const double after = last + 1 < x_.size() ? x_[last + 1] : 0;
    level = std::min(level, std::max(before, after));
    if (level <= 0) return peak + 1;
    if (before >= level) length += path_.ds[--first];
    if (after >= level) length += path_.ds[last++];
  }
  const auto flat = [&](std::size_t i) { return i >= first && i <= last ? level : x_[i]; };
  for (std::size_t i = first > 0 ? first - 1 : 0; i <= last && i < path_.cells(); ++i) {
    if (!allowed(i, flat(i), flat(i + 1))) return last + 1;
  }
  std::fill(x_.begin() + static_cast<std::ptrdiff_t>(first),
            x_.begin() + static_cast<std::ptrdiff_t>(last) + 1, level);
  return last + 1;
}

void SpeedProfile::flattenPeaks(double window) {
  for (std::size_t i = 1; i + 1 < x_.size();) {
    const bool peak = x_[i] > x_[i - 1] && x_[i] >= x_[i + 1];
    i = peak ? flattenPeak(i, window) : i + 1;
  }
  measureTime();
}

// q at a time within a cell.
void SpeedProfile::fill(std::size_t cell, double t, double* q) const {
  const double tau = t - t_[cell];
  const double u = (x_[cell + 1] - x_[cell]) / (2 * path_.ds[cell]);
  const double s = std::clamp((std::sqrt(x_[cell]) + 0.5 * u * tau) * tau, 0.0, path_.ds[cell]);
  const double *from = &path_.q[cell * path_.dof], *q_s = &path_.q_s[cell * path_.dof],
               *q_ss = &path_.curvature[cell * path_.dof];
  for (std::size_t j = 0; j < path_.dof; ++j) q[j] = from[j] + (q_s[j] + 0.5 * q_ss[j] * s) * s;
}

Eigen::MatrixXd SpeedProfile::sample(double step) const {
  const auto dof = static_cast<Eigen::Index>(path_.dof);
  const auto steps = static_cast<Eigen::Index>(std::ceil(duration() / step - 1e-9));
  Eigen::MatrixXd samples(dof, steps + 1);
  std::size_t i = 0;
  for (Eigen::Index k = 0; k < steps; ++k) {
    const double t = static_cast<double>(k) * step;
    while (i + 1 < path_.cells() && t_[i + 1] <= t) ++i;
    fill(i, t, samples.col(k).data());
  }
  samples.col(steps) = Eigen::Map<const Eigen::VectorXd>(&*(path_.q.end() - dof), dof);
  return samples;
}

void SpeedProfile::at(double t, Eigen::Ref<Eigen::VectorXd> q) const {
  t = std::clamp(t, 0.0, duration());
  const auto after = std::upper_bound(t_.begin() + 1, t_.end() - 1, t);
  fill(static_cast<std::size_t>(after - t_.begin()) - 1, t, q.data());
}

double SpeedProfile::timeAt(double s) const {
  for (std::size_t i = 0; i < path_.cells(); ++i) {
    if (s <= 0) return t_[i];
    if (s < path_.ds[i]) {
      const double u = (x_[i + 1] - x_[i]) / (2 * path_.ds[i]);
      return t_[i] + 2 * s / (std::sqrt(x_[i]) + std::sqrt(x_[i] + 2 * u * s));
    }
    s -= path_.ds[i];
  }
  return duration();
}

double SpeedProfile::speedAt(double s) const {
  for (std::size_t i = 0; i < path_.cells(); ++i) {
    if (s < path_.ds[i]) {
      return std::sqrt(std::max(0.0, x_[i] + (x_[i + 1] - x_[i]) * std::max(0.0, s) / path_.ds[i]));
    }
    s -= path_.ds[i];
  }
  return 0;
}

}  // namespace handover
