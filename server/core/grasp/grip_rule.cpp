// SPDX-License-Identifier: Apache-2.0
#include "core/grasp/grip_rule.hpp"

#include <algorithm>
#include <cmath>

namespace handover {
namespace {

using Eigen::Vector3d;

constexpr double kReach = 0.0015;            // of the contract's 2 mm
constexpr double kApart = 125 * M_PI / 180;  // of the contract's 120 deg
constexpr double kOutside = 1e-5;            // a point just outside its own face [m]
constexpr double kSame = 0.9998;             // cosine of 1 deg: normals counted as one

std::size_t at(int index) { return static_cast<std::size_t>(index); }

bool isRound(const Shape& shape) {
  return std::holds_alternative<SphereShape>(shape.geometry) ||
         std::holds_alternative<CylinderShape>(shape.geometry);
}

/// Collects directions, each once.
class Directions {
 public:
  bool knows(const Vector3d& n) const {
    return std::any_of(all.begin(), all.end(), [&](const Vector3d& m) { return n.dot(m) > kSame; });
  }

  std::vector<Vector3d> all;
};

}  // namespace

GripRule::GripRule(const ObjectSurface& surface, const HandModel& hand)
    : surface_(surface), finger_links_(hand.hand.finger_links) {
  for (const Link& link : hand.model->links) {
    links_.emplace_back(link.collision, link.divided.get());
  }
}

std::vector<Vector3d> GripRule::normalsFelt(const SurfaceTree& link, const Pose& X_OL) const {
  Directions felt;
  const auto add = [&](const Vector3d& n, const Vector3d& p, int shape, int body) {
    if (felt.knows(n) || surface_.inside(p + kOutside * n, shape, body)) return;
    felt.all.push_back(n);
  };
  const auto addFaces = [&](const SurfaceTree::Piece& of_link, int shape) {
    const ConvexPart& part = surface_.parts()[at(shape)];
    const TriangleMesh mesh{part.vertices, part.triangles};
    const Pose X_OS = of_link.shape < 0 ? X_OL : X_OL * link.shapes()[at(of_link.shape)].X_BS;
    for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
      const Vector3d n = normalOf(mesh, t);
      if (n.isZero() || felt.knows(n)) continue;
      TriangleCore face;
      for (std::size_t k = 0; k < 3; ++k)
        face.corners[k] = mesh.vertices[at(mesh.triangles[at(t)][k])];
      const double reach = kReach + of_link.rounded.radius;
      const GjkResult found = gjk(of_link.rounded.core, X_OS, face, Pose::Identity(), reach, reach);
      if (found.at_least <= reach && found.at_most <= reach) add(n, found.p_Wb, shape, -1);
    }
  };
  SurfaceTree::forEachNear(link, X_OL, surface_.tree(), Pose::Identity(), kReach,
                           [&](const SurfaceTree::Piece& of_link,
                               const SurfaceTree::Piece& of_object, const BodyDistance& near) {
                             if (of_object.body >= 0) {
                               const auto& mesh = surface_.divided()[at(of_object.body)].surface;
                               const Vector3d n = normalOf(mesh, of_object.triangle);
                               if (!n.isZero()) add(n, near.p_Wb, -1, of_object.body);
                             } else if (isRound(surface_.tree().shapes()[at(of_object.shape)])) {
                               add(near.n_W, near.p_Wb, of_object.shape, -1);
                             } else {
                               addFaces(of_link, of_object.shape);
                             }
                           });
  return felt.all;
}

bool GripRule::holds(const std::vector<Pose>& X_OL) const {
  std::vector<std::vector<Vector3d>> normals;
  for (const LinkId l : finger_links_) normals.push_back(normalsFelt(links_[l], X_OL[l]));
  const double most = std::cos(kApart);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      for (const Vector3d& a : normals[i]) {
        for (const Vector3d& b : normals[j]) {
          if (a.dot(b) < most) return true;
        }
      }
    }
  }
  return false;
}

}  // namespace handover
