// SPDX-License-Identifier: Apache-2.0
#include "core/decomposition/convex_decomposition.hpp"

#include "core/decomposition/mesh_piece.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <queue>
#include <tuple>

namespace handover {
namespace decomposition {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::size_t kMostTriangles = 200000;

/// How close the parts are to keep, and what that may cost.
struct Level {
  double reach;            ///< [m]
  std::size_t most_parts;  ///< before giving way to the next level
  double most_cells;       ///< of the grid, a byte each
};

constexpr Level kLevels[] = {
    {kMostReach / 4, 48, 1 << 25}, {kMostReach / 2, 64, 1 << 25}, {kMostReach, 512, 1 << 27}};
/// The more voxels, the nearer to its bound a part may come; fewer where these would be too many.
constexpr double kVoxelsPerReach = 2.5, kFineVoxelsPerReach = 4, kMostFineCells = 1 << 23;
/// Pieces are joined again: so many times more may be cut.
constexpr std::size_t kPiecesPerPart = 4;

/// Where to cut: at even fractions of the box, and closely beside the largest faces across an axis.
constexpr int kFractions = 4;
constexpr int kFaces = 2;
constexpr double kBeside = 1e-5;       // [m]
constexpr double kAcross = 0.99;       // cosine
constexpr std::size_t kScored = 1000;  // points of a piece that a cut is judged by
constexpr double kImbalance = 0.05;    // of the volume before: the price of a lopsided cut
constexpr std::size_t kManyVertices = 96;
constexpr double kSimplified = 0.2;  // of the reach

AlignedBox3d boxOf(const std::vector<Vector3d>& points) {
  AlignedBox3d box;
  for (const Vector3d& p : points) box.extend(p);
  return box;
}

AlignedBox3d boxOf(const std::vector<Triangle>& triangles) {
  AlignedBox3d box;
  for (const Triangle& t : triangles) {
    for (const Vector3d& p : t) box.extend(p);
  }
  return box;
}

// ---- the frame to cut in

void turn(std::vector<Triangle>& triangles, const Matrix3d& R) {
  for (Triangle& t : triangles) {
    for (Vector3d& p : t) p = R * p;
  }
}

Matrix3d principalAxes(const std::vector<Triangle>& triangles) {
  double whole = 0;
  Vector3d middle = Vector3d::Zero();
  const auto area = [](const Triangle& t) { return (t[1] - t[0]).cross(t[2] - t[0]).norm(); };
  for (const Triangle& t : triangles) {
    whole += area(t);
    middle += area(t) * (t[0] + t[1] + t[2]) / 3;
  }
  if (whole <= 0) return Matrix3d::Identity();
  middle /= whole;
  Matrix3d spread = Matrix3d::Zero();
  for (const Triangle& t : triangles) {
    const Vector3d at = (t[0] + t[1] + t[2]) / 3 - middle;
    spread += area(t) * at * at.transpose();
  }
  Matrix3d axes = Eigen::SelfAdjointEigenSolver<Matrix3d>(spread).eigenvectors();
  if (axes.determinant() < 0) axes.col(0) *= -1;
  return axes;
}

/// The mesh's own axes, unless its principal ones make a clearly smaller box: a body that was
/// turned is cut as it was before.
Matrix3d cuttingAxes(const std::vector<Triangle>& triangles) {
  const Matrix3d axes = principalAxes(triangles);
  std::vector<Triangle> turned = triangles;
  turn(turned, axes.transpose());
  const double least = 1e-3;  // of a flat body's box [m]
  const auto volume = [least](const AlignedBox3d& box) {
    return (box.sizes().array() + least).prod();
  };
  return volume(boxOf(turned)) < 0.8 * volume(boxOf(triangles)) ? axes : Matrix3d::Identity();
}

// ---- cutting

struct Cut {
  int axis = 0;
  double at = 0;
};

/// Planes across the axis with the most area of triangles in them.
std::vector<double> facesAcross(const MeshPiece& piece, int axis) {
  std::vector<std::pair<double, double>> faces;  // position, area
  for (const Triangle& t : piece.triangles()) {
    const Vector3d normal = (t[1] - t[0]).cross(t[2] - t[0]);
    if (std::abs(normal[axis]) > kAcross * normal.norm()) {
      faces.emplace_back((t[0] + t[1] + t[2])[axis] / 3, normal.norm());
    }
  }
  std::sort(faces.begin(), faces.end());
  std::vector<std::pair<double, double>> merged;
  for (const auto& [at, area] : faces) {
    if (!merged.empty() && at - merged.back().first < kBeside) {
      merged.back().second += area;
    } else {
      merged.emplace_back(at, area);
    }
  }
  std::stable_sort(merged.begin(), merged.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  if (merged.size() > kFaces) merged.resize(kFaces);
  std::vector<double> positions;
  for (const auto& [at, area] : merged) positions.push_back(at);
  return positions;
}

std::vector<Cut> cutsOf(const MeshPiece& piece) {
  std::vector<Cut> cuts;
  const AlignedBox3d& box = piece.box();
  const double longest = box.sizes().maxCoeff();
  for (int axis = 0; axis < 3; ++axis) {
    const double low = box.min()[axis], size = box.sizes()[axis];
    if (size >= 0.25 * longest) {
      for (int i = 1; i < kFractions; ++i) cuts.push_back({axis, low + size * i / kFractions});
    }
    for (const double face : facesAcross(piece, axis)) {
      for (const double at : {face - kBeside, face + kBeside}) {
        if (at > low + 2 * kBeside && at < low + size - 2 * kBeside) cuts.push_back({axis, at});
      }
    }
  }
  return cuts;
}

/// Volume of the hull, from some of the points.
double hullVolume(const std::vector<Vector3d>& points) {
  if (points.empty()) return 0;
  const std::size_t stride = points.size() / kScored + 1;
  std::vector<Vector3d> some;
  for (std::size_t i = 0; i < points.size(); i += stride) some.push_back(points[i]);
  // The inside corners stand last.
  for (std::size_t i = points.size() - std::min<std::size_t>(8, points.size());
       stride > 1 && i < points.size(); ++i) {
    some.push_back(points[i]);
  }
  return hullOf(std::move(some)).volume;
}

/// Cuts where the two hulls become smallest together.
std::pair<MeshPiece, MeshPiece> cutBest(const MeshPiece& piece, double volume,
                                        const SignedDistanceGrid& grid, const Deadline& deadline) {
  double least = std::numeric_limits<double>::infinity();
  Cut best;
  for (const Cut& cut : cutsOf(piece)) {
    if (deadline.over()) break;
    const auto [below, above] = piece.cut(cut.axis, cut.at);
    const double part = (cut.at - piece.box().min()[cut.axis]) / piece.box().sizes()[cut.axis];
    const double cost = hullVolume(below.points(grid)) + hullVolume(above.points(grid)) +
                        kImbalance * volume * std::abs(2 * part - 1);
    if (cost < least) least = cost, best = cut;
  }
  return piece.cut(best.axis, best.at);
}

/// Hulls of pieces that all fit; nullopt when it takes more than `most`, or past the deadline.
std::optional<std::vector<Hull>> cutToFit(MeshPiece whole, const SignedDistanceGrid& grid,
                                          std::size_t most, const Deadline& deadline) {
  std::vector<Hull> hulls;
  std::vector<MeshPiece> waiting;
  waiting.push_back(std::move(whole));
  while (!waiting.empty()) {
    if (deadline.over()) return std::nullopt;
    MeshPiece piece = std::move(waiting.back());
    waiting.pop_back();
    std::vector<Vector3d> points = piece.points(grid);
    if (points.empty()) continue;
    piece.shrink(boxOf(points));
    Hull hull = hullOf(std::move(points));
    if (grid.holds(hull)) {
      hulls.push_back(std::move(hull));
      if (hulls.size() + waiting.size() > most) return std::nullopt;
      continue;
    }
    auto [below, above] = cutBest(piece, hull.volume, grid, deadline);
    waiting.push_back(std::move(above));
    waiting.push_back(std::move(below));
  }
  return hulls;
}

// ---- joining

/// Joins hulls in pairs while the common hull fits, least added volume first.
class Joiner {
 public:
  Joiner(std::vector<Hull> hulls, const SignedDistanceGrid& grid)
      : hulls_(std::move(hulls)), gone_(hulls_.size(), false), grid_(grid) {}

  /// Past the deadline, as far as it came.
  std::vector<Hull> join(const Deadline& deadline) {
    for (std::size_t i = 0; i < hulls_.size() && !deadline.over(); ++i) propose(i);
    while (!pairs_.empty() && !deadline.over()) {
      const Pair best = pairs_.top();
      pairs_.pop();
      if (gone_[best.a] || gone_[best.b]) continue;
      // Most pairs never come so far: only here is it worth a look at the grid.
      Hull joined = joinedOf(hulls_[best.a], hulls_[best.b]);
      if (!grid_.holds(joined)) continue;
      hulls_.push_back(std::move(joined));
      gone_[best.a] = gone_[best.b] = true;
      gone_.push_back(false);
      propose(hulls_.size() - 1);
    }
    std::vector<Hull> left;
    for (std::size_t i = 0; i < hulls_.size(); ++i) {
      if (!gone_[i]) left.push_back(std::move(hulls_[i]));
    }
    return left;
  }

 private:
  struct Pair {
    double added;  ///< volume that neither has
    std::size_t b, a;

    bool operator>(const Pair& other) const {
      return std::tie(added, b, a) > std::tie(other.added, other.b, other.a);
    }
  };

  static Hull joinedOf(const Hull& a, const Hull& b) {
    std::vector<Vector3d> points = a.mesh.vertices;
    points.insert(points.end(), b.mesh.vertices.begin(), b.mesh.vertices.end());
    return hullOf(std::move(points));
  }

  /// All pairs of the newest hull with those before it.
  void propose(std::size_t newest) {
    const Hull& b = hulls_[newest];
    AlignedBox3d box = boxOf(b.mesh.vertices);
    box.min().array() -= grid_.voxel();
    box.max().array() += grid_.voxel();
    for (std::size_t i = 0; i < newest; ++i) {
      const Hull& a = hulls_[i];
      if (gone_[i] || !box.intersects(boxOf(a.mesh.vertices))) continue;
      pairs_.push({joinedOf(a, b).volume - a.volume - b.volume, newest, i});
    }
  }

  std::vector<Hull> hulls_;
  std::vector<bool> gone_;
  std::priority_queue<Pair, std::vector<Pair>, std::greater<Pair>> pairs_;
  const SignedDistanceGrid& grid_;
};

Hull simplified(const Hull& hull, const SignedDistanceGrid& grid, double reach) {
  if (hull.mesh.vertices.size() <= kManyVertices) return hull;
  Hull simple = simplifiedOutward(hull, kSimplified * reach);
  return grid.holds(simple) ? simple : hull;
}

// ---- the whole

/// Parts as near as the level asks for; nullopt where that takes too many, or past the deadline.
std::optional<std::vector<Hull>> divideAt(const Level& level,
                                          const std::vector<Triangle>& triangles,
                                          const Deadline& deadline) {
  const AlignedBox3d box = boxOf(triangles);
  double voxel = level.reach / kFineVoxelsPerReach;
  if (SignedDistanceGrid::cells(box, voxel) > kMostFineCells) {
    voxel = level.reach / kVoxelsPerReach;
  }
  if (SignedDistanceGrid::cells(box, voxel) > level.most_cells) return std::nullopt;
  const SignedDistanceGrid grid(triangles, box, voxel, level.reach, deadline);
  if (deadline.over()) return std::nullopt;
  auto pieces =
      cutToFit(MeshPiece(triangles, box), grid, kPiecesPerPart * level.most_parts, deadline);
  if (!pieces) return std::nullopt;
  std::vector<Hull> parts = Joiner(std::move(*pieces), grid).join(deadline);
  if (parts.size() > level.most_parts) return std::nullopt;
  for (Hull& part : parts) part = simplified(part, grid, level.reach);
  return parts;
}

Result<std::vector<Hull>> divide(const std::vector<Triangle>& triangles, const Deadline& deadline) {
  for (const Level& level : kLevels) {
    auto parts = divideAt(level, triangles, deadline);
    if (deadline.over()) return Error{ErrorCode::kDeadline, "stopped while it was divided"};
    if (parts) return std::move(*parts);
  }
  const Level& last = kLevels[std::size(kLevels) - 1];
  return Error{ErrorCode::kInvalidInput, "takes more than " + std::to_string(last.most_parts) +
                                             " convex parts to be met to 5 mm"};
}

/// Whether the coarsest grid holds them.
Result<bool> fitsAGrid(const std::vector<Triangle>& triangles) {
  const AlignedBox3d box = boxOf(triangles);
  const Level& last = kLevels[std::size(kLevels) - 1];
  const double voxel = last.reach / kVoxelsPerReach;
  if (SignedDistanceGrid::cells(box, voxel) > last.most_cells) {
    const Vector3d size = box.sizes();
    return Error{ErrorCode::kInvalidInput,
                 "is too large to be divided into convex parts to 5 mm: its box of " +
                     std::to_string(size.x()) + " x " + std::to_string(size.y()) + " x " +
                     std::to_string(size.z()) + " m holds more than " +
                     std::to_string(static_cast<long>(last.most_cells)) + " voxels of 2 mm"};
  }
  return true;
}

/// The mesh's triangles; what is wrong with it otherwise.
Result<std::vector<Triangle>> trianglesOf(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return Error{ErrorCode::kInvalidInput, "has no triangles"};
  if (mesh.triangles.size() > kMostTriangles) {
    return Error{ErrorCode::kInvalidInput,
                 "has " + std::to_string(mesh.triangles.size()) + " triangles, more than " +
                     std::to_string(kMostTriangles) + " are not divided into convex parts"};
  }
  std::vector<Triangle> triangles;
  for (const auto& t : mesh.triangles) {
    Triangle& triangle = triangles.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      triangle[i] = mesh.vertices.at(static_cast<std::size_t>(t[i]));
      if (!triangle[i].allFinite()) {
        return Error{ErrorCode::kInvalidInput, "has a vertex that is not finite"};
      }
    }
  }
  return triangles;
}

}  // namespace
}  // namespace decomposition

Result<bool> divisible(const TriangleMesh& mesh) {
  using namespace decomposition;
  auto triangles = trianglesOf(mesh);
  if (!triangles) return triangles.error();
  turn(*triangles, cuttingAxes(*triangles).transpose());
  return fitsAGrid(*triangles);
}

Result<std::vector<TriangleMesh>> convexParts(const TriangleMesh& mesh) {
  return convexPartsWithin(mesh, {});
}

Result<std::vector<TriangleMesh>> convexPartsWithin(const TriangleMesh& mesh,
                                                    const Deadline& deadline) {
  using namespace decomposition;
  auto triangles = trianglesOf(mesh);
  if (!triangles) return triangles.error();
  const Eigen::Matrix3d axes = cuttingAxes(*triangles);
  turn(*triangles, axes.transpose());
  if (const auto fits = fitsAGrid(*triangles); !fits) return fits.error();
  const auto hulls = divide(*triangles, deadline);
  if (!hulls) return hulls.error();
  std::vector<TriangleMesh> parts;
  for (const Hull& hull : *hulls) {
    TriangleMesh& part = parts.emplace_back(hull.mesh);
    for (Eigen::Vector3d& vertex : part.vertices) vertex = axes * vertex;
  }
  return parts;
}

}  // namespace handover
