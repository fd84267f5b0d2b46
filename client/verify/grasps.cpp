// SPDX-License-Identifier: Apache-2.0
#include "verify/checks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace handover::verify {
namespace {

constexpr double kContact = 2e-3;  // [m] between a finger link and O
constexpr double kSpread = 120 * M_PI / 180;
constexpr double kSpacing = 1.5e-3;    // [m] of samples on a finger's surface
constexpr double kReach = 6e-3;        // [m] up to which O's surface is looked for
constexpr double kSameContact = 5e-4;  // [m] beyond the deepest sample that still is the contact
constexpr int kMostSteps = 40;         // of samples along a triangle's edge

/// A triangle of O, outward normal and the box around it.
struct Facet {
  Eigen::Vector3d a, b, c, normal;
  Eigen::AlignedBox3d box;
  const Shell* shell = nullptr;
};

/// A sample of a finger over O's surface.
struct Touch {
  double height = 0;       ///< above O's surface, negative inside
  Eigen::Vector3d normal;  ///< of O there, in O's frame
};

std::vector<Facet> facetsOf(const Body& object) {
  std::vector<Facet> facets;
  for (const Shell& shell : object.shells()) {
    for (const Triangle& t : shell.mesh.triangles) {
      const auto vertex = [&](int k) { return shell.mesh.vertices[static_cast<std::size_t>(k)]; };
      Facet facet{vertex(t[0]), vertex(t[1]), vertex(t[2]), {}, {}, &shell};
      facet.normal = (facet.b - facet.a).cross(facet.c - facet.a);
      if (facet.normal.norm() <= 0) continue;
      facet.normal.normalize();
      facet.box.extend(facet.a).extend(facet.b).extend(facet.c);
      facets.push_back(facet);
    }
  }
  return facets;
}

/// False on faces between the parts that O is made of.
bool exposed(const Body& object, const Facet& facet, const Eigen::Vector3d& point) {
  const Eigen::Vector3d outside = point + 1e-5 * facet.normal;
  return std::none_of(object.shells().begin(), object.shells().end(), [&](const Shell& shell) {
    return &shell != facet.shell && shell.contains(outside);
  });
}

/// How a point lies to the facets, and the normals of all those that are equally near.
void feel(const Body& object, const std::vector<const Facet*>& facets, const Eigen::Vector3d& point,
          std::vector<Touch>& touches) {
  constexpr double kTie = 1e-6;
  double nearest = kReach;
  std::vector<std::pair<double, const Facet*>> hits;
  for (const Facet* facet : facets) {
    const Eigen::Vector3d foot = nearestOnTriangle(point, facet->a, facet->b, facet->c);
    const double distance = (point - foot).norm();
    if (distance > nearest + kTie || !exposed(object, *facet, foot)) continue;
    nearest = std::min(nearest, distance);
    hits.emplace_back(distance, facet);
  }
  if (hits.empty()) return;
  const bool inside = std::any_of(object.shells().begin(), object.shells().end(),
                                  [&](const Shell& shell) { return shell.contains(point); });
  for (const auto& [distance, facet] : hits) {
    if (distance <= nearest + kTie)
      touches.push_back({inside ? -distance : distance, facet->normal});
  }
}

/// Normals of O under the part of the finger that is nearest to O, or deepest in it; empty when the
/// finger is more than 2 mm away. Sampled, so that it works whether the two overlap or not.
std::vector<Eigen::Vector3d> contactNormals(const Body& finger, const Pose& X_OF,
                                            const Body& object, const std::vector<Facet>& facets) {
  std::vector<Touch> touches;
  for (const Shell& shell : finger.shells()) {
    for (const Triangle& t : shell.mesh.triangles) {
      const auto vertex = [&](int k) {
        return Eigen::Vector3d(X_OF * shell.mesh.vertices[static_cast<std::size_t>(k)]);
      };
      const Eigen::Vector3d a = vertex(t[0]), b = vertex(t[1]), c = vertex(t[2]);
      Eigen::AlignedBox3d box;
      box.extend(a).extend(b).extend(c);
      std::vector<const Facet*> near;
      for (const Facet& facet : facets) {
        if (facet.box.exteriorDistance(box) < kReach) near.push_back(&facet);
      }
      if (near.empty()) continue;
      const double longest = std::max({(b - a).norm(), (c - a).norm(), (c - b).norm()});
      const int steps = std::clamp(static_cast<int>(std::ceil(longest / kSpacing)), 1, kMostSteps);
      for (int i = 0; i <= steps; ++i) {
        for (int j = 0; i + j <= steps; ++j) {
          feel(object, near, a + (b - a) * i / steps + (c - a) * j / steps, touches);
        }
      }
    }
  }
  double deepest = kContact;
  for (const Touch& touch : touches) deepest = std::min(deepest, touch.height);
  std::vector<Eigen::Vector3d> normals;
  for (const Touch& touch : touches) {
    if (touch.height > deepest + kSameContact) continue;
    const bool known = std::any_of(normals.begin(), normals.end(), [&](const auto& normal) {
      return normal.dot(touch.normal) > 0.9998;  // 1 degree
    });
    if (!known) normals.push_back(touch.normal);
  }
  return normals;
}

void checkGrasp(const Motion& motion, const Party& party, int stage, Report& report) {
  const Scene& scene = motion.scene();
  const double time = motion.stage(stage).end();
  const Pose X_WO = motion.objectAt(time);
  const std::vector<Pose> X_WL = motion.linksAt(party.robot, time);
  const Body& object = scene.bodies[static_cast<std::size_t>(scene.object_body)].body;
  const std::vector<Facet> facets = facetsOf(object);

  std::vector<std::vector<Eigen::Vector3d>> fingers;
  std::vector<std::string> names;
  for (const SceneBody& body : scene.bodies) {
    const auto& links = party.arm.finger_links;
    if (body.robot != party.robot ||
        std::find(links.begin(), links.end(), body.link) == links.end()) {
      continue;
    }
    const Pose& X_WF = X_WL[static_cast<std::size_t>(body.link)];
    const Clearance gap = clearance(body.body, X_WF, object, X_WO, 2 * kContact);
    if (!gap.touching && gap.distance > kContact) continue;
    fingers.push_back(contactNormals(body.body, X_WO.inverse() * X_WF, object, facets));
    names.push_back(body.name);
  }
  if (fingers.size() < 2) {
    report.violations.push_back({stageName(stage), stage, time, "grasp",
                                 std::to_string(fingers.size()) +
                                     " finger link(s) within 2 mm of the object instead of two",
                                 names});
    return;
  }
  double widest = 0;
  for (std::size_t f = 0; f < fingers.size(); ++f) {
    for (std::size_t g = 0; g < f; ++g) {
      for (const Eigen::Vector3d& n : fingers[f]) {
        for (const Eigen::Vector3d& m : fingers[g]) {
          widest = std::max(widest, std::acos(std::clamp(n.dot(m), -1.0, 1.0)));
        }
      }
    }
  }
  if (widest <= kSpread) {
    report.violations.push_back(
        {stageName(stage), stage, time, "grasp",
         "contact normals differ by at most " +
             std::to_string(static_cast<int>(std::lround(widest * 180 / M_PI))) + " deg",
         names});
  }
}

}  // namespace

void checkGrasps(const Motion& motion, Report& report) {
  checkGrasp(motion, motion.scene().giver, kGiverGrasp, report);
  checkGrasp(motion, motion.scene().receiver, kReceiverGrasp, report);
}

}  // namespace handover::verify
