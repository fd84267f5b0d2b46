// SPDX-License-Identifier: Apache-2.0
#include "core/decomposition/signed_distance_grid.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace handover::decomposition {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;
using Triangle = std::array<Vector3d, 3>;

constexpr int kUnits = 24;        // per voxel
constexpr int kPadding = 6;       // [cells] round the box: always outside
constexpr double kPieceSize = 8;  // [voxels] larger triangles are halved before they are drawn
constexpr double kHalfDiagonal = 0.8660254037844387;  // of a voxel
constexpr std::int8_t kFar = 127;

/// After Ericson, Real-Time Collision Detection, 5.1.5.
double squaredDistance(const Vector3d& p, const Triangle& t) {
  const Vector3d ab = t[1] - t[0], ac = t[2] - t[0], ap = p - t[0];
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return ap.squaredNorm();
  const Vector3d bp = p - t[1];
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return bp.squaredNorm();
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return (ap - d1 / (d1 - d3) * ab).squaredNorm();
  const Vector3d cp = p - t[2];
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return cp.squaredNorm();
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return (ap - d2 / (d2 - d6) * ac).squaredNorm();
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    return (bp - (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (t[2] - t[1])).squaredNorm();
  }
  const double scale = 1 / (va + vb + vc);
  return (ap - vb * scale * ab - vc * scale * ac).squaredNorm();
}

Eigen::AlignedBox3d boxOf(const Triangle& t) {
  Eigen::AlignedBox3d box(t[0]);
  box.extend(t[1]);
  box.extend(t[2]);
  return box;
}

}  // namespace

double SignedDistanceGrid::cells(const Eigen::AlignedBox3d& box, double voxel) {
  return (box.sizes().array() / voxel + 2 * kPadding + 1).prod();
}

SignedDistanceGrid::SignedDistanceGrid(const std::vector<Triangle>& triangles,
                                       const Eigen::AlignedBox3d& box, double voxel, double reach,
                                       const Deadline& deadline)
    : voxel_(voxel),
      // Every point of a hull lies in a voxel whose middle is at most half a diagonal away.
      most_(static_cast<int>(std::floor((reach / voxel - kHalfDiagonal) * kUnits))),
      origin_(box.min().array() - kPadding * voxel),
      size_((box.sizes() / voxel).array().ceil().cast<int>() + 2 * kPadding + 1),
      distance_(index(0, 0, size_.z()), kFar) {
  if (most_ < 0 || reach > 4 * voxel) throw std::invalid_argument("reach does not fit the voxels");
  for (const Triangle& t : triangles) {
    if (deadline.over()) return;
    addTriangle(t);
  }
  turnInsideNegative(deadline);
}

void SignedDistanceGrid::addTriangle(const Triangle& t) {
  std::size_t longest = 0;
  double length = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double edge = (t[(i + 1) % 3] - t[i]).norm();
    if (edge > length) length = edge, longest = i;
  }
  if (length <= kPieceSize * voxel_) return addPiece(t);
  const Vector3d &a = t[longest], &b = t[(longest + 1) % 3], &c = t[(longest + 2) % 3];
  const Vector3d half = 0.5 * (a + b);
  addTriangle({a, half, c});
  addTriangle({half, b, c});
}

void SignedDistanceGrid::addPiece(const Triangle& t) {
  // Beyond this, one distance is as good as another.
  const double band = voxel_ * std::max(1.0, (most_ + 1.0) / kUnits);
  const Eigen::AlignedBox3d box = boxOf(t);
  const Vector3i low = ((box.min() - origin_).array() / voxel_ - band / voxel_).ceil().cast<int>();
  const Vector3i high =
      ((box.max() - origin_).array() / voxel_ + band / voxel_).floor().cast<int>();
  Vector3d normal = (t[1] - t[0]).cross(t[2] - t[0]);
  if (normal.norm() > 0) normal.normalize();
  for (int z = low.z(); z <= high.z(); ++z) {
    for (int y = low.y(); y <= high.y(); ++y) {
      double height = normal.dot(middle({low.x(), y, z}) - t[0]);
      for (int x = low.x(); x <= high.x(); ++x, height += voxel_ * normal.x()) {
        std::int8_t& known = distance_[index(x, y, z)];
        if (std::abs(height) * kUnits > known * voxel_ || std::abs(height) >= band) continue;
        const double squared = squaredDistance(middle({x, y, z}), t);
        if (squared >= band * band) continue;
        const int units = static_cast<int>(std::ceil(std::sqrt(squared) * kUnits / voxel_));
        known = static_cast<std::int8_t>(std::min<int>(known, units));
      }
    }
  }
}

void SignedDistanceGrid::turnInsideNegative(const Deadline& deadline) {
  // Two neighbouring middles, both more than half a voxel off the surface, have none between them:
  // walking over such cells from a corner never leaks in.
  const auto open = [this](std::size_t cell) { return distance_[cell] > kUnits / 2; };
  std::vector<bool> outside(distance_.size(), false);
  std::vector<Vector3i> front{Vector3i::Zero()}, next;
  outside[0] = true;
  while (!front.empty()) {
    if (deadline.over()) return;
    next.clear();
    for (const Vector3i& at : front) {
      for (int k = 0; k < 3; ++k) {
        for (const int step : {-1, 1}) {
          Vector3i to = at;
          to[k] += step;
          if (to[k] < 0 || to[k] >= size_[k]) continue;
          const std::size_t cell = index(to.x(), to.y(), to.z());
          if (outside[cell] || !open(cell)) continue;
          outside[cell] = true;
          next.push_back(to);
        }
      }
    }
    front.swap(next);
  }
  for (std::size_t cell = 0; cell < distance_.size(); ++cell) {
    if (outside[cell] || !open(cell)) continue;
    distance_[cell] = static_cast<std::int8_t>(1 - distance_[cell]);  // ceil becomes floor
  }
}

Vector3i SignedDistanceGrid::cellAt(const Vector3d& p) const {
  const Vector3i cell = ((p - origin_) / voxel_).array().round().cast<int>();
  return cell.cwiseMax(Vector3i::Zero()).cwiseMin(size_ - Vector3i::Ones());
}

Vector3d SignedDistanceGrid::middle(const Vector3i& cell) const {
  return origin_ + voxel_ * cell.cast<double>();
}

SignedDistanceGrid::Side SignedDistanceGrid::side(const Vector3i& cell) const {
  const std::int8_t distance = distance_[index(cell.x(), cell.y(), cell.z())];
  if (distance < 0) return Side::kInside;
  return distance > kUnits / 2 ? Side::kOutside : Side::kUnclear;
}

bool SignedDistanceGrid::holds(const Hull& hull) const {
  Eigen::AlignedBox3d box;
  for (const Vector3d& v : hull.mesh.vertices) box.extend(v);
  const Vector3i low = cellAt(box.min()), high = cellAt(box.max());
  for (int z = low.z(); z <= high.z(); ++z) {
    for (int y = low.y(); y <= high.y(); ++y) {
      // The row's cells that may meet the hull: all planes moved out by the cell's half width.
      const Vector3d begin = middle({low.x(), y, z});
      double first = 0, last = voxel_ * (high.x() - low.x());
      for (const Eigen::Vector4d& plane : hull.planes) {
        const Vector3d normal = plane.head<3>();
        const double room = plane[3] - normal.dot(begin) + 0.5 * voxel_ * normal.lpNorm<1>() + 1e-9;
        if (std::abs(normal.x()) < 1e-12) {
          if (room < 0) last = -1;
        } else if (normal.x() > 0) {
          last = std::min(last, room / normal.x());
        } else {
          first = std::max(first, room / normal.x());
        }
        if (first > last) break;
      }
      if (first > last) continue;
      const int end = low.x() + static_cast<int>(std::floor(last / voxel_));
      for (int x = low.x() + static_cast<int>(std::ceil(first / voxel_)); x <= end; ++x) {
        if (distance_[index(x, y, z)] > most_) return false;
      }
    }
  }
  return true;
}

}  // namespace handover::decomposition
