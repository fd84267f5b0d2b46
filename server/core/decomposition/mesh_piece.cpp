// SPDX-License-Identifier: Apache-2.0
#include "core/decomposition/mesh_piece.hpp"

#include <algorithm>
#include <cmath>

namespace handover::decomposition {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

/// A point between a below and b above the plane, exactly on it.
Vector3d crossing(const Vector3d& a, const Vector3d& b, int axis, double at) {
  Vector3d p = a + (at - a[axis]) / (b[axis] - a[axis]) * (b - a);
  p[axis] = at;
  return p;
}

/// Cuts a triangle that has corners on both sides.
void cutTriangle(const Triangle& t, int axis, double at, std::vector<Triangle>& below,
                 std::vector<Triangle>& above) {
  // Turned so that corner 0 is alone on its side.
  std::size_t alone = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const bool side = t[i][axis] > at;
    if (side != (t[(i + 1) % 3][axis] > at) && side != (t[(i + 2) % 3][axis] > at)) alone = i;
  }
  const Vector3d &a = t[alone], &b = t[(alone + 1) % 3], &c = t[(alone + 2) % 3];
  const Vector3d ab = crossing(a, b, axis, at), ac = crossing(a, c, axis, at);
  const bool alone_above = a[axis] > at;
  (alone_above ? above : below).push_back({a, ab, ac});
  std::vector<Triangle>& rest = alone_above ? below : above;
  rest.push_back({ab, b, c});
  rest.push_back({ab, c, ac});
}

/// Moeller and Trumbore, ends and rims included.
bool meets(const Vector3d& from, const Vector3d& to, const Triangle& t) {
  constexpr double kRim = 1e-9;
  const Vector3d along = to - from, ab = t[1] - t[0], ac = t[2] - t[0];
  const Vector3d across = along.cross(ac);
  const double determinant = ab.dot(across);
  if (std::abs(determinant) < 1e-18 * along.norm()) return false;
  const Vector3d start = from - t[0];
  const double u = start.dot(across) / determinant;
  if (u < -kRim || u > 1 + kRim) return false;
  const Vector3d turned = start.cross(ab);
  const double v = along.dot(turned) / determinant;
  if (v < -kRim || u + v > 1 + kRim) return false;
  const double s = ac.dot(turned) / determinant;
  return s >= -kRim && s <= 1 + kRim;
}

/// The middle of a cell whose side is known.
struct Witness {
  bool outside_box;
  double squared_distance;
  Vector3d middle;
  bool inside_solid;
};

constexpr int kWitnessCells = 2;

/// Those near a point: within the box first, nearest first.
std::vector<Witness> witnessesOf(const Vector3d& p, const Eigen::AlignedBox3d& box,
                                 const SignedDistanceGrid& grid) {
  std::vector<Witness> found;
  const Vector3i cell = grid.cellAt(p);
  for (int x = -kWitnessCells; x <= kWitnessCells; ++x) {
    for (int y = -kWitnessCells; y <= kWitnessCells; ++y) {
      for (int z = -kWitnessCells; z <= kWitnessCells; ++z) {
        const Vector3i at = cell + Vector3i(x, y, z);
        const SignedDistanceGrid::Side side = grid.side(at);
        if (side == SignedDistanceGrid::Side::kUnclear) continue;
        const Vector3d middle = grid.middle(at);
        found.push_back({!box.contains(middle), (middle - p).squaredNorm(), middle,
                         side == SignedDistanceGrid::Side::kInside});
      }
    }
  }
  std::stable_sort(found.begin(), found.end(), [](const Witness& a, const Witness& b) {
    return a.outside_box != b.outside_box ? b.outside_box : a.squared_distance < b.squared_distance;
  });
  return found;
}

}  // namespace

MeshPiece::MeshPiece(std::vector<Triangle> triangles, const Eigen::AlignedBox3d& box)
    : triangles_(std::move(triangles)), box_(box) {}

std::pair<MeshPiece, MeshPiece> MeshPiece::cut(int axis, double at) const {
  MeshPiece below({}, box_), above({}, box_);
  below.box_.max()[axis] = at;
  above.box_.min()[axis] = at;
  for (const Triangle& t : triangles_) {
    const auto [low, high] = std::minmax({t[0][axis], t[1][axis], t[2][axis]});
    if (high <= at) {
      below.triangles_.push_back(t);
    } else if (low >= at) {
      above.triangles_.push_back(t);
    } else {
      cutTriangle(t, axis, at, below.triangles_, above.triangles_);
    }
  }
  return {std::move(below), std::move(above)};
}

std::vector<Vector3d> MeshPiece::points(const SignedDistanceGrid& grid) const {
  std::vector<Vector3d> points;
  points.reserve(3 * triangles_.size() + 8);
  for (const Triangle& t : triangles_) points.insert(points.end(), t.begin(), t.end());
  for (int i = 0; i < 8; ++i) {
    const Vector3d corner = box_.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i));
    if (insideSolid(corner, grid)) points.push_back(corner);
  }
  return points;
}

bool MeshPiece::insideSolid(const Vector3d& corner, const SignedDistanceGrid& grid) const {
  const std::vector<Witness> witnesses = witnessesOf(corner, box_, grid);
  if (witnesses.empty()) return false;
  constexpr std::size_t kSide = 2 * kWitnessCells + 1, kAll = kSide * kSide * kSide;
  // All known and all the same: nothing of a closed surface is near.
  const bool same = std::all_of(witnesses.begin(), witnesses.end(), [&](const Witness& w) {
    return w.inside_solid == witnesses.front().inside_solid;
  });
  if (same && witnesses.size() == kAll) return witnesses.front().inside_solid;
  const double room = (kWitnessCells + 1) * grid.voxel();
  const Eigen::AlignedBox3d around(corner.array() - room, corner.array() + room);
  std::vector<const Triangle*> near;
  for (const Triangle& t : triangles_) {
    const Vector3d low = t[0].cwiseMin(t[1]).cwiseMin(t[2]);
    const Vector3d high = t[0].cwiseMax(t[1]).cwiseMax(t[2]);
    if (around.intersects(Eigen::AlignedBox3d(low, high))) near.push_back(&t);
  }
  // A middle that the corner sees without surface between them is on its side. Within the box the
  // box's own triangles are all that could be between.
  for (const Witness& witness : witnesses) {
    const bool seen = std::none_of(near.begin(), near.end(), [&](const Triangle* t) {
      return meets(corner, witness.middle, *t);
    });
    if (seen) return witness.inside_solid;
  }
  return false;  // on the surface, or in a crack of it: its triangles' corners do
}

}  // namespace handover::decomposition
