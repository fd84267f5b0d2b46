// SPDX-License-Identifier: Apache-2.0
#include "core/collision/surface_tree.hpp"

#include <algorithm>
#include <cmath>

namespace handover {
namespace {

using Eigen::Vector3d;

std::size_t at(int index) { return static_cast<std::size_t>(index); }

/// Distance of two pieces; nullopt where it is more than `max`.
std::optional<BodyDistance> pieceDistance(const RoundedCore& a, const Pose& X_WA,
                                          const RoundedCore& b, const Pose& X_WB, double max) {
  const double radii = a.radius + b.radius;
  const GjkResult cores = gjk(a.core, X_WA, b.core, X_WB, max + radii, -1);
  if (cores.at_least > max + radii || cores.at_most > max + radii) return std::nullopt;
  BodyDistance found{std::max(0.0, cores.at_most - radii), cores.p_Wa, cores.p_Wb, {}};
  found.n_W = cores.overlap ? Vector3d::UnitZ() : Vector3d((cores.p_Wa - cores.p_Wb).normalized());
  found.p_Wa -= a.radius * found.n_W;
  found.p_Wb += b.radius * found.n_W;
  return found;
}

/// Where the way passes through the triangle (Moeller and Trumbore), rims included.
std::optional<double> crossing(const Vector3d& from, const Vector3d& way,
                               const std::array<Vector3d, 3>& t) {
  const Vector3d ab = t[1] - t[0], ac = t[2] - t[0];
  const Vector3d across = way.cross(ac);
  const double determinant = ab.dot(across);
  if (determinant == 0) return std::nullopt;
  const Vector3d start = from - t[0];
  const double u = start.dot(across) / determinant;
  if (u < 0 || u > 1) return std::nullopt;
  const Vector3d turned = start.cross(ab);
  const double v = way.dot(turned) / determinant;
  if (v < 0 || u + v > 1) return std::nullopt;
  const double along = ac.dot(turned) / determinant;
  return along >= 0 && along <= 1 ? std::optional(along) : std::nullopt;
}

bool meetsBox(const Vector3d& from, const Vector3d& way, const Vector3d& middle,
              const Vector3d& half) {
  double enter = 0, leave = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const double room = half[axis] + 1e-9;
    const double offset = middle[axis] - from[axis];
    if (std::abs(way[axis]) < 1e-15) {
      if (std::abs(offset) > room) return false;
      continue;
    }
    const double a = (offset - room) / way[axis], b = (offset + room) / way[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave;
}

}  // namespace

SurfaceTree::SurfaceTree(const std::vector<Shape>& shapes, const DividedBodies* divided) {
  std::vector<bool> exact(shapes.size(), true);
  std::vector<Node> leaves;
  const auto addLeaf = [&](const Vector3d& lower, const Vector3d& upper) {
    Node leaf;
    leaf.middle = 0.5 * (lower + upper);
    leaf.half = 0.5 * (upper - lower);
    leaf.piece = static_cast<int>(leaves.size());
    leaves.push_back(leaf);
  };
  for (int b = 0; divided && b < static_cast<int>(divided->size()); ++b) {
    const DividedBody& body = (*divided)[at(b)];
    for (int s = 0; s < body.shape_count; ++s) exact[at(body.first_shape + s)] = false;
    for (int t = 0; t < static_cast<int>(body.surface.triangles.size()); ++t) {
      const auto& corners = body.surface.triangles[at(t)];
      const auto corner = [&](std::size_t k) -> const Vector3d& {
        return body.surface.vertices[at(corners[k])];
      };
      const TriangleCore core{{corner(0), corner(1), corner(2)}};
      const auto& c = core.corners;
      addLeaf(c[0].cwiseMin(c[1]).cwiseMin(c[2]), c[0].cwiseMax(c[1]).cwiseMax(c[2]));
      Piece& piece = pieces_.emplace_back();
      piece.rounded.core = core;
      piece.body = b;
      piece.triangle = t;
    }
  }
  for (std::size_t s = 0; s < shapes.size(); ++s) {
    if (!exact[s]) continue;
    Piece piece{coreOf(shapes[s]), static_cast<int>(shapes_.size()), -1, -1};
    const Pose& X_BS = shapes[s].X_BS;
    Vector3d lower, upper;
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d along = X_BS.linear().row(axis).transpose();
      const double room = piece.rounded.radius;
      upper[axis] = (X_BS * supportPoint(piece.rounded.core, along))[axis] + room;
      lower[axis] = (X_BS * supportPoint(piece.rounded.core, -along))[axis] - room;
    }
    addLeaf(lower, upper);
    pieces_.push_back(std::move(piece));
    shapes_.push_back(shapes[s]);
  }
  std::vector<int> order(leaves.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  if (!order.empty()) root_ = build(order, 0, static_cast<int>(order.size()), leaves);
}

int SurfaceTree::build(std::vector<int>& order, int first, int end,
                       const std::vector<Node>& leaves) {
  if (end - first == 1) {
    nodes_.push_back(leaves[at(order[at(first)])]);
    return static_cast<int>(nodes_.size()) - 1;
  }
  Eigen::AlignedBox3d box, middles;
  for (int i = first; i < end; ++i) {
    const Node& leaf = leaves[at(order[at(i)])];
    box.extend(Vector3d(leaf.middle - leaf.half)).extend(Vector3d(leaf.middle + leaf.half));
    middles.extend(leaf.middle);
  }
  int axis = 0;
  middles.sizes().maxCoeff(&axis);
  const int half = first + (end - first) / 2;
  std::nth_element(order.begin() + first, order.begin() + half, order.begin() + end,
                   [&](int a, int b) {
                     const double x = leaves[at(a)].middle[axis], y = leaves[at(b)].middle[axis];
                     return x < y || (x == y && a < b);
                   });
  Node node;
  node.middle = box.center();
  node.half = 0.5 * box.sizes();
  node.left = build(order, first, half, leaves);
  node.right = build(order, half, end, leaves);
  nodes_.push_back(node);
  return static_cast<int>(nodes_.size()) - 1;
}

Pose SurfaceTree::poseOf(const Piece& piece, const Pose& X_WB) const {
  return piece.shape < 0 ? X_WB : X_WB * shapes_[at(piece.shape)].X_BS;
}

/// A walk down two trees at once.
class SurfaceTree::Pair {
 public:
  Pair(const SurfaceTree& a, const Pose& X_WA, const SurfaceTree& b, const Pose& X_WB)
      : a_(a), b_(b), X_WA_(X_WA), X_WB_(X_WB), X_AB_(X_WA.inverse() * X_WB) {
    turn_ = X_AB_.linear().cwiseAbs();
  }

  /// Calls leaves(piece of a, piece of b, limit) wherever the boxes are nearer than `limit`, which
  /// it may lower.
  template <typename Leaves>
  void walk(int i, int j, double& limit, const Leaves& leaves) const {
    const Node &a = a_.nodes_[at(i)], &b = b_.nodes_[at(j)];
    if (a.piece >= 0 && b.piece >= 0) {
      return leaves(a_.pieces_[at(a.piece)], b_.pieces_[at(b.piece)], limit);
    }
    const bool split_a = b.piece >= 0 || (a.piece < 0 && a.half.maxCoeff() > b.half.maxCoeff());
    const int first = split_a ? a.left : b.left, second = split_a ? a.right : b.right;
    const double to_first = split_a ? gap(first, j) : gap(i, first);
    const double to_second = split_a ? gap(second, j) : gap(i, second);
    const auto go = [&](int child, double gap) {
      if (gap > limit) return;
      split_a ? walk(child, j, limit, leaves) : walk(i, child, limit, leaves);
    };
    if (to_first <= to_second) {
      go(first, to_first);
      go(second, to_second);
    } else {
      go(second, to_second);
      go(first, to_first);
    }
  }

  /// Of two boxes, at most.
  double gap(int i, int j) const {
    const Node &a = a_.nodes_[at(i)], &b = b_.nodes_[at(j)];
    const Vector3d between = (X_AB_ * b.middle - a.middle).cwiseAbs();
    return (between - a.half - turn_ * b.half).cwiseMax(0.0).norm();
  }

  std::optional<BodyDistance> distance(const Piece& a, const Piece& b, double max) const {
    return pieceDistance(a.rounded, a_.poseOf(a, X_WA_), b.rounded, b_.poseOf(b, X_WB_), max);
  }

 private:
  const SurfaceTree &a_, &b_;
  const Pose &X_WA_, &X_WB_;
  Pose X_AB_;
  Eigen::Matrix3d turn_;
};

std::optional<BodyDistance> SurfaceTree::distance(const SurfaceTree& a, const Pose& X_WA,
                                                  const SurfaceTree& b, const Pose& X_WB,
                                                  double max) {
  std::optional<BodyDistance> best;
  if (a.root_ < 0 || b.root_ < 0) return best;
  const Pair pair(a, X_WA, b, X_WB);
  double limit = max;
  if (pair.gap(a.root_, b.root_) > limit) return best;
  pair.walk(a.root_, b.root_, limit, [&](const Piece& of_a, const Piece& of_b, double& least) {
    const auto found = pair.distance(of_a, of_b, least);
    if (!found) return;
    best = found;
    least = found->distance;
  });
  return best;
}

void SurfaceTree::forEachNear(const SurfaceTree& a, const Pose& X_WA, const SurfaceTree& b,
                              const Pose& X_WB, double reach, const NearVisit& visit) {
  if (a.root_ < 0 || b.root_ < 0) return;
  const Pair pair(a, X_WA, b, X_WB);
  double limit = reach;
  if (pair.gap(a.root_, b.root_) > limit) return;
  pair.walk(a.root_, b.root_, limit, [&](const Piece& of_a, const Piece& of_b, double&) {
    if (const auto found = pair.distance(of_a, of_b, reach)) visit(of_a, of_b, *found);
  });
}

void SurfaceTree::forEachCrossing(const Vector3d& from, const Vector3d& to,
                                  const CrossingVisit& visit) const {
  if (root_ < 0) return;
  const Vector3d way = to - from;
  std::vector<int> waiting{root_};
  while (!waiting.empty()) {
    const Node& node = nodes_[at(waiting.back())];
    waiting.pop_back();
    if (!meetsBox(from, way, node.middle, node.half)) continue;
    if (node.piece < 0) {
      waiting.push_back(node.left);
      waiting.push_back(node.right);
      continue;
    }
    const Piece& piece = pieces_[at(node.piece)];
    if (piece.body < 0) continue;
    const auto along = crossing(from, way, std::get<TriangleCore>(piece.rounded.core).corners);
    if (along) visit(piece, *along);
  }
}

Vector3d normalOf(const TriangleMesh& mesh, int triangle) {
  const auto corner = [&](std::size_t k) -> const Vector3d& {
    return mesh.vertices[at(mesh.triangles[at(triangle)][k])];
  };
  const Vector3d area = (corner(1) - corner(0)).cross(corner(2) - corner(0));
  return area.norm() > 0 ? Vector3d(area.normalized()) : Vector3d::Zero();
}

}  // namespace handover
