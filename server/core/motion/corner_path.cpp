// SPDX-License-Identifier: Apache-2.0
#include "core/motion/corner_path.hpp"

#include <algorithm>
#include <cmath>

namespace handover {
namespace {

using Eigen::VectorXd;

constexpr double kLeastHalf = 5e-6;       // [rad] of a parabola; shorter ones are stops
constexpr double kLeastStraight = 1e-12;  // [rad] less is rounding between two parabolas
constexpr int kCellsPerPath = 100;        // along the straight parts, about
constexpr double kCellsPerTurn = 10;      // of a parabola, per unit of |change of direction|

// Appends cells from the last point: `count` equal ones over `length` with the curvature c.
void appendCells(CornerPath& path, double length, const double* c, int count) {
  const std::size_t dof = path.dof;
  const std::size_t base = path.cells();
  for (int k = 1; k <= count; ++k) {
    const double s = length * k / count;
    path.ds.push_back(length / count);
    path.straight.push_back(c == nullptr);
    for (std::size_t j = 0; j < dof; ++j) {
      const double cj = c == nullptr ? 0.0 : c[j];
      const double dj = path.q_s[base * dof + j];
      path.curvature.push_back(cj);
      path.q.push_back(path.q[base * dof + j] + (dj + 0.5 * cj * s) * s);
      path.q_s.push_back(dj + cj * s);
    }
  }
}

void reserve(CornerPath& path, std::size_t cells) {
  path.ds.reserve(cells);
  path.straight.reserve(cells);
  path.curvature.reserve(cells * path.dof);
  path.q.reserve((cells + 1) * path.dof);
  path.q_s.reserve((cells + 1) * path.dof);
}

}  // namespace

std::vector<Corner> roundCorners(const std::vector<VectorXd>& points, double blend) {
  std::vector<Corner> corners(points.size());
  VectorXd before = points[1] - points[0], after;
  double length_before = before.norm();
  for (std::size_t i = 1; i < points.size(); ++i) {
    corners[i].at = corners[i - 1].at + length_before;
    if (i + 1 == points.size()) break;
    after = points[i + 1] - points[i];
    const double length_after = after.norm();
    Corner& corner = corners[i];
    corner.turn = (after / length_after - before / length_before).norm();
    corner.half = 0.5 * std::min(length_before, length_after);
    // The parabola passes the corner at a distance of half * turn / 4.
    if (corner.half * corner.turn > 4 * blend) corner.half = 4 * blend / corner.turn;
    if (corner.half < kLeastHalf) corner.half = 0;
    before.swap(after);
    length_before = length_after;
  }
  return corners;
}

CornerPath cutIntoCells(const std::vector<VectorXd>& points, const std::vector<Corner>& corners) {
  const std::size_t segments = points.size() - 1;
  CornerPath path;
  path.dof = static_cast<std::size_t>(points.front().size());
  const auto dof = static_cast<Eigen::Index>(path.dof);
  const double total = corners.back().at - corners.front().at;
  reserve(path, kCellsPerPath + 4 + 8 * segments);

  VectorXd direction = (points[1] - points[0]).normalized(), next(dof), curvature(dof);
  path.q.assign(points[0].begin(), points[0].end());
  path.q_s.assign(direction.begin(), direction.end());
  for (std::size_t i = 0; i < segments; ++i) {
    const double length = (points[i + 1] - points[i]).norm();
    const double rest = length - corners[i].half - corners[i + 1].half;
    const bool at_end = i == 0 || i + 1 == segments;
    if (at_end || rest > kLeastStraight) {
      int count = static_cast<int>(std::ceil(kCellsPerPath * rest / total));
      if (at_end) count = std::max(count, 2);
      appendCells(path, rest, nullptr, count);
    }
    if (i + 1 == segments) break;
    next = (points[i + 2] - points[i + 1]).normalized();
    const Corner& corner = corners[i + 1];
    const double span = 2 * corner.half;
    curvature = (next - direction) / span;
    const double by_turn = kCellsPerTurn * corner.turn;
    const double by_length = 0.25 * kCellsPerPath * span / total;
    const int count = std::max(1, static_cast<int>(std::ceil(std::max(by_turn, by_length))));
    appendCells(path, span, curvature.data(), count);
    // As the segments themselves have it, so that rounding does not pile up along the path.
    const std::size_t last = path.cells() * path.dof;
    for (Eigen::Index j = 0; j < dof; ++j) {
      path.q_s[last + static_cast<std::size_t>(j)] = next[j];
      path.q[last + static_cast<std::size_t>(j)] = points[i + 1][j] + corner.half * next[j];
    }
    direction.swap(next);
  }
  std::copy(points.back().begin(), points.back().end(), path.q.end() - dof);
  return path;
}

}  // namespace handover
