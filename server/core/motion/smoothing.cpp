// SPDX-License-Identifier: Apache-2.0
#include "core/motion/smoothing.hpp"

#include <algorithm>
#include <cmath>

namespace handover {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kSameJerk =
    1e-7;  // of the most that a joint shows: no change from one interval on
constexpr double kPositionRounding = 1e-14;  // [rad]
constexpr double kRounding = 1e-9;           // of a limit of jerk, forgiven when windows are chosen

// The spline takes this much longer than its samples, so that rounding breaks no limit.
constexpr double kEase = 1 + 1e-8;

bool anyBeyond(const double* from, const double* to, Index count, double bound) {
  double most = 0;
  for (Index i = 0; i < count; ++i) most = std::max(most, std::abs(to[i] - from[i]));
  return most > bound;
}

bool anyBeyond(const double* values, Index count, double bound) {
  double most = 0;
  for (Index i = 0; i < count; ++i) most = std::max(most, std::abs(values[i]));
  return most > bound;
}

}  // namespace

EvenSamples::EvenSamples(Eigen::MatrixXd q, double step, const VectorXd& jerk)
    : q_(std::move(q)), step_(step), bend_(q_.rows(), q_.cols()) {
  const VectorXd scale = (jerk * (step * step * step)).cwiseInverse();
  rounding_ = kPositionRounding * scale;
  const Index last = q_.cols() - 1;
  for (Index i = 0; i <= last; ++i) {
    const double *before = column(i - 1), *at = column(i), *after = column(i + 1);
    double* out = bend_.col(i).data();
    for (Index j = 0; j < q_.rows(); ++j) {
      out[j] = ((after[j] - at[j]) - (at[j] - before[j])) * scale[j];
    }
  }
}

const double* EvenSamples::column(Index sample) const {
  return q_.col(std::clamp<Index>(sample, 0, q_.cols() - 1)).data();
}

int EvenSamples::leastWindow() const {
  const Index dof = q_.rows(), size = bend_.size();
  const double* bend = bend_.data();
  Index seen = 0;  // where the last window failed, looked at first
  for (int m = 1;; ++m) {
    const double bound = m * (1 + kRounding);
    const Index shift = std::min(m * dof, size);
    if (seen + shift < size && std::abs(bend[seen + shift] - bend[seen]) > bound) continue;
    // Both the motion's first and its last m samples are seen against rest.
    bool beyond = anyBeyond(bend, shift, bound) || anyBeyond(bend + size - shift, shift, bound);
    for (Index i = 0; !beyond && i + shift < size; i += dof) {
      beyond = anyBeyond(bend + i, bend + i + shift, dof, bound);
      if (!beyond) continue;
      for (seen = i; std::abs(bend[seen + shift] - bend[seen]) <= bound;) ++seen;
    }
    if (!beyond) return m;
  }
}

void EvenSamples::fillJerk(int m, Index interval, double* use) const {
  const Index dof = q_.rows(), last = q_.cols() - 1;
  const Index before = interval - m, after = interval;
  for (Index j = 0; j < dof; ++j) {
    use[j] = (after <= last ? bend_(j, after) : 0.0) - (before >= 0 ? bend_(j, before) : 0.0);
  }
}

void EvenSamples::appendKnot(int m, Index knot, TimedPath& path) const {
  const Index dof = q_.rows(), first = knot - m;
  const double step = step_ * kEase;
  const Index end = first + m, last = q_.cols() - 1;
  const auto resting = static_cast<double>(std::max<Index>(0, std::min<Index>(m, -first)));
  const auto arrived = static_cast<double>(std::max<Index>(0, std::min<Index>(m, end - last - 1)));
  VectorXd q = resting * q_.col(0) + arrived * q_.col(last), qd(dof), qdd(dof);
  for (Index i = std::max<Index>(first, 0); i < std::min(end, last + 1); ++i) q += q_.col(i);
  const double *q0 = column(first - 1), *q1 = column(first), *q2 = column(first + m - 1),
               *q3 = column(first + m);
  for (Index j = 0; j < dof; ++j) {
    const double before = (q2[j] - q0[j]) / m, after = (q3[j] - q1[j]) / m;
    q[j] = q[j] / m + (after - before) / 6;
    qd[j] = (before + after) / (2 * step);
    qdd[j] = (after - before) / (step * step);
  }
  path.t.push_back(static_cast<double>(knot) * step);
  path.q.push_back(std::move(q));
  path.qd.push_back(std::move(qd));
  path.qdd.push_back(std::move(qdd));
}

TimedPath EvenSamples::spline(int m, double gap, const std::vector<Index>& keep,
                              std::vector<Index>& kept) const {
  const Index last = knots(m) - 1;
  const auto longest = std::max<Index>(1, static_cast<Index>(std::floor(gap / step_ + kRounding)));
  const VectorXd same =
      kSameJerk * bend_.rowwise().lpNorm<Eigen::Infinity>().cwiseMin(m) + rounding_;
  VectorXd run(q_.rows()), next(q_.rows());  // jerk since the last sample, jerk to come
  fillJerk(m, 0, run.data());
  kept.assign(1, 0);
  auto wanted = keep.begin();
  for (Index knot = 1; knot < last; ++knot) {
    while (wanted != keep.end() && *wanted < knot) ++wanted;
    fillJerk(m, knot, next.data());
    const bool changes = ((next - run).array().abs() > same.array()).any();
    const bool asked = wanted != keep.end() && *wanted == knot;
    if (!changes && !asked && knot - kept.back() < longest) continue;
    kept.push_back(knot);
    run.swap(next);
  }
  kept.push_back(last);

  TimedPath path;
  path.t.reserve(kept.size());
  path.q.reserve(kept.size());
  path.qd.reserve(kept.size());
  path.qdd.reserve(kept.size());
  for (const Index knot : kept) appendKnot(m, knot, path);
  path.q.front() = q_.col(0);
  path.q.back() = q_.col(q_.cols() - 1);
  return path;
}

}  // namespace handover
