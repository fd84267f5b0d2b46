// SPDX-License-Identifier: Apache-2.0
#include "verify/body.hpp"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

#include <algorithm>
#include <optional>
#include <type_traits>
#include <utility>

namespace handover::verify {
namespace {

using Tree = fcl::BVHModel<fcl::OBBRSSd>;

std::unique_ptr<Tree> treeOf(const Mesh& mesh) {
  std::vector<fcl::Triangle> triangles;
  triangles.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    triangles.emplace_back(static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]),
                           static_cast<std::size_t>(t[2]));
  }
  auto tree = std::make_unique<Tree>();
  tree->beginModel();
  tree->addSubModel(mesh.vertices, triangles);
  tree->endModel();
  return tree;
}

/// A sphere or cylinder as FCL has it.
struct Curved {
  std::unique_ptr<fcl::CollisionGeometryd> shape;
  Pose X_BS;
};

struct Parts {
  Mesh flat;                  ///< boxes and meshes
  Mesh cover;                 ///< the same, and triangles around spheres and cylinders
  std::vector<Shell> shells;  ///< of the cover
  std::vector<Curved> curved;
};

void collect(const PlacedGeometry& placed, const Pose& X_above, const MeshSource& meshes,
             Parts& parts) {
  const Pose X_BS = X_above * placed.X_BS;
  const auto add = [&](Mesh mesh, std::optional<Shell::Round> round = std::nullopt) {
    mesh.transform(X_BS);
    parts.cover.append(mesh);
    if (!round) parts.flat.append(mesh);
    for (Shell& shell : shellsOf(mesh)) {
      shell.round = round;
      parts.shells.push_back(std::move(shell));
    }
  };
  std::visit(
      [&](const auto& shape) {
        using Type = std::decay_t<decltype(shape)>;
        if constexpr (std::is_same_v<Type, Box>) {
          add(boxMesh(shape.size));
        } else if constexpr (std::is_same_v<Type, MeshFile>) {
          for (Mesh& mesh : meshes(shape)) add(std::move(mesh));
        } else if constexpr (std::is_same_v<Type, Sphere>) {
          add(sphereMesh(shape.radius), Shell::Round{X_BS, shape.radius, 0});
          parts.curved.push_back({std::make_unique<fcl::Sphered>(shape.radius), X_BS});
        } else if constexpr (std::is_same_v<Type, Cylinder>) {
          add(cylinderMesh(shape.radius, shape.length),
              Shell::Round{X_BS, shape.radius, shape.length});
          parts.curved.push_back(
              {std::make_unique<fcl::Cylinderd>(shape.radius, shape.length), X_BS});
        } else {
          for (const PlacedGeometry& part : shape.parts) collect(part, X_BS, meshes, parts);
        }
      },
      placed.geometry);
}

Eigen::AlignedBox3d worldBox(const Body& body, const Pose& X_WB) {
  const Eigen::Vector3d centre = X_WB * body.box().center();
  const Eigen::Vector3d half = X_WB.linear().cwiseAbs() * (body.box().sizes() / 2);
  return {centre - half, centre + half};
}

bool meet(const fcl::CollisionGeometryd& a, const Pose& X_WA, const fcl::CollisionGeometryd& b,
          const Pose& X_WB) {
  const fcl::CollisionRequestd request;
  fcl::CollisionResultd result;
  return fcl::collide(&a, X_WA, &b, X_WB, request, result) > 0;
}

/// A part of `inner` within a closed shell of `outer`. Surfaces that do not meet are wholly in or
/// wholly out, so one vertex of each connected part tells.
bool within(const Body& inner, const Pose& X_WI, const Body& outer, const Pose& X_WO) {
  const Pose X_OI = X_WO.inverse() * X_WI;
  for (const Shell& part : inner.shells()) {
    const Eigen::Vector3d point = X_OI * part.mesh.vertices.front();
    if (!outer.box().contains(point)) continue;
    for (const Shell& shell : outer.shells()) {
      if (shell.contains(point)) return true;
    }
  }
  return false;
}

}  // namespace

struct Body::Data {
  std::unique_ptr<Tree> cover;
  std::unique_ptr<Tree> flat;  ///< null: nothing flat, or the same as cover
  std::vector<Curved> curved;  ///< empty: the cover is exact
};

namespace {

/// The true surfaces, for bodies whose covers meet.
bool surfacesMeet(const Body::Data& a, const Pose& X_WA, const Body::Data& b, const Pose& X_WB) {
  if (a.curved.empty() && b.curved.empty()) return true;
  const auto flatOf = [](const Body::Data& data) {
    return data.curved.empty() ? data.cover.get() : data.flat.get();
  };
  const Tree* flat_a = flatOf(a);
  const Tree* flat_b = flatOf(b);
  if (flat_a && flat_b && meet(*flat_a, X_WA, *flat_b, X_WB)) return true;
  for (const Curved& ca : a.curved) {
    if (flat_b && meet(*flat_b, X_WB, *ca.shape, X_WA * ca.X_BS)) return true;
    for (const Curved& cb : b.curved) {
      if (meet(*ca.shape, X_WA * ca.X_BS, *cb.shape, X_WB * cb.X_BS)) return true;
    }
  }
  return std::any_of(b.curved.begin(), b.curved.end(), [&](const Curved& cb) {
    return flat_a && meet(*flat_a, X_WA, *cb.shape, X_WB * cb.X_BS);
  });
}

}  // namespace

Body::Body(const std::vector<PlacedGeometry>& geometry, const MeshSource& meshes) {
  Parts parts;
  for (const PlacedGeometry& placed : geometry) {
    collect(placed, Pose::Identity(), meshes, parts);
  }
  for (const Eigen::Vector3d& vertex : parts.cover.vertices) box_.extend(vertex);
  for (const Eigen::Vector3d& vertex : parts.cover.vertices) {
    radius_ = std::max(radius_, (vertex - box_.center()).norm());
  }
  shells_ = std::move(parts.shells);
  auto data = std::make_unique<Data>();
  data->cover = treeOf(parts.cover);
  data->curved = std::move(parts.curved);
  if (!data->curved.empty() && !parts.flat.triangles.empty()) data->flat = treeOf(parts.flat);
  data_ = std::move(data);
}

Body::~Body() = default;
Body::Body(Body&&) noexcept = default;
Body& Body::operator=(Body&&) noexcept = default;

Clearance clearance(const Body& a, const Pose& X_WA, const Body& b, const Pose& X_WB, double near) {
  const double boxes = worldBox(a, X_WA).exteriorDistance(worldBox(b, X_WB));
  if (boxes >= near) return {false, boxes};
  const fcl::DistanceRequestd request;
  fcl::DistanceResultd result(near);  // prunes every branch that is farther away
  fcl::distance(a.data().cover.get(), X_WA, b.data().cover.get(), X_WB, request, result);
  const double distance = std::clamp(result.min_distance, 0.0, near);
  if (distance > 0) {
    const bool inside = boxes <= 0 && (within(a, X_WA, b, X_WB) || within(b, X_WB, a, X_WA));
    return {inside, inside ? 0 : distance};
  }
  return {surfacesMeet(a.data(), X_WA, b.data(), X_WB) || within(a, X_WA, b, X_WB) ||
              within(b, X_WB, a, X_WA),
          0};
}

namespace {

constexpr double kSampleSpacing = 1e-3;  // [m] on a surface that is in the other body
constexpr int kMostSteps = 24;           // of samples along the edge of a clipped piece
using Polygon = std::vector<Eigen::Vector3d>;

/// What of the polygon lies on one side of a plane: axis `k` of the points at most (or at least) at
/// `bound`.
Polygon clipped(const Polygon& polygon, int k, double bound, double sign) {
  Polygon result;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector3d& p = polygon[i];
    const Eigen::Vector3d& next = polygon[(i + 1) % polygon.size()];
    const double here = sign * (bound - p[k]), there = sign * (bound - next[k]);
    if (here >= 0) result.push_back(p);
    if ((here > 0 && there < 0) || (here < 0 && there > 0)) {
      result.push_back(p + here / (here - there) * (next - p));
    }
  }
  return result;
}

Polygon clipped(Polygon polygon, const Eigen::AlignedBox3d& box) {
  for (int k = 0; k < 3 && !polygon.empty(); ++k) {
    polygon = clipped(polygon, k, box.max()[k], 1);
    if (!polygon.empty()) polygon = clipped(polygon, k, box.min()[k], -1);
  }
  return polygon;
}

/// The deepest in `outer` of points on the surface of `inner`.
void deepen(const Body& inner, const Body& outer, const Pose& X_OI, double enough,
            double& deepest) {
  const auto look = [&](const Eigen::Vector3d& p_O) {
    for (const Shell& shell : outer.shells()) {
      if (shell.contains(p_O)) deepest = std::max(deepest, shell.depth(p_O));
    }
  };
  const Pose X_IO = X_OI.inverse();
  for (const Shell& part : inner.shells()) {
    for (const Triangle& t : part.mesh.triangles) {
      Polygon piece;
      for (const int corner : t) {
        piece.push_back(X_OI * part.mesh.vertices[static_cast<std::size_t>(corner)]);
      }
      piece = clipped(std::move(piece), outer.box());
      for (std::size_t i = 2; i < piece.size(); ++i) {
        const Eigen::Vector3d a = piece[i - 1] - piece[0], b = piece[i] - piece[0];
        const double longest = std::max({a.norm(), b.norm(), (a - b).norm()});
        const int steps =
            std::clamp(static_cast<int>(std::ceil(longest / kSampleSpacing)), 1, kMostSteps);
        for (int m = 0; m <= steps; ++m) {
          for (int n = 0; m + n <= steps; ++n) {
            const Eigen::Vector3d p_O = piece[0] + a * m / steps + b * n / steps;
            look(part.round ? X_OI * part.onSurface(X_IO * p_O) : p_O);
            if (deepest > enough) return;
          }
        }
      }
    }
  }
}

}  // namespace

double depthAtLeast(const Body& a, const Pose& X_WA, const Body& b, const Pose& X_WB,
                    double enough) {
  double deepest = 0;
  const Pose X_BA = X_WB.inverse() * X_WA;
  deepen(a, b, X_BA, enough, deepest);
  if (deepest <= enough) deepen(b, a, X_BA.inverse(), enough, deepest);
  return deepest;
}

bool partedBy(const Body& a, const Pose& X_WA, const Body& b, const Pose& X_WB, double distance) {
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        if (x == 0 && y == 0 && z == 0) continue;
        Pose X_WMoved = X_WB;
        X_WMoved.translation() += distance * Eigen::Vector3d(x, y, z).normalized();
        if (!clearance(a, X_WA, b, X_WMoved, distance).touching) return true;
      }
    }
  }
  return false;
}

}  // namespace handover::verify
