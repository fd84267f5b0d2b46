// SPDX-License-Identifier: Apache-2.0
#include "verify/checks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace handover::verify {
namespace {

constexpr double kContact = 2e-3;  // [m] between a link of the hand and O's surface
constexpr double kSpread = 120 * M_PI / 180;
constexpr double kSpacing = 1e-3;  // [m] of samples on O's surface near a link
constexpr int kMostSteps = 64;     // of samples along a triangle's edge
constexpr double kSame = 0.9998;   // cosine of 1 deg: normals counted as one
constexpr double kEdge = 1e-6;     // [m]: faces as near as this share an edge
constexpr double kCupTilt = 5 * M_PI / 180;

/// A triangle of O with its outward normal.
struct Facet {
  Eigen::Vector3d a, b, c, normal;
  const Shell* shell = nullptr;
};

Eigen::AlignedBox3d boxOf(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                          const Eigen::Vector3d& c) {
  Eigen::AlignedBox3d box;
  box.extend(a).extend(b).extend(c);
  return box;
}

/// O's own surface.
class Surface {
 public:
  explicit Surface(const Body& object) : object_(object) {
    for (const Shell& shell : object.shells()) {
      for (const Triangle& t : shell.mesh.triangles) {
        const auto vertex = [&](int k) { return shell.mesh.vertices[static_cast<std::size_t>(k)]; };
        Facet facet{vertex(t[0]), vertex(t[1]), vertex(t[2]), {}, &shell};
        facet.normal = (facet.b - facet.a).cross(facet.c - facet.a);
        if (facet.normal.norm() <= 0) continue;
        facet.normal.normalize();
        facets_.push_back(facet);
      }
    }
  }

  const std::vector<Facet>& facets() const { return facets_; }

  /// False where the facet lies within another part that O is made of.
  bool exposed(const Facet& facet, const Eigen::Vector3d& point) const {
    const Eigen::Vector3d outside = point + 1e-5 * facet.normal;
    return std::none_of(object_.shells().begin(), object_.shells().end(), [&](const Shell& shell) {
      return &shell != facet.shell && shell.contains(outside);
    });
  }

 private:
  const Body& object_;
  std::vector<Facet> facets_;
};

/// A link of the hand as O sees it.
class FeltLink {
 public:
  FeltLink(const Body& link, const Pose& X_OL) : X_LO_(X_OL.inverse()), link_(link) {
    for (const Shell& shell : link.shells()) {
      for (const Triangle& t : shell.mesh.triangles) {
        const auto vertex = [&](int k) {
          return Eigen::Vector3d(X_OL * shell.mesh.vertices[static_cast<std::size_t>(k)]);
        };
        Face face{vertex(t[0]), vertex(t[1]), vertex(t[2]), {}};
        face.reach = grown(boxOf(face.a, face.b, face.c));
        box_.extend(face.reach);
        faces_.push_back(face);
      }
    }
  }

  const Eigen::AlignedBox3d& reach() const { return box_; }

  /// Only what is near this box will be asked for.
  void turnTo(const Eigen::AlignedBox3d& box) {
    near_.clear();
    for (const Face& face : faces_) {
      if (face.reach.intersects(box)) near_.push_back(&face);
    }
  }

  /// Whether a point of O is within 2 mm of the link, or in it.
  bool feels(const Eigen::Vector3d& p_O) const {
    if (!box_.contains(p_O)) return false;
    for (const Face* face : near_) {
      if (!face->reach.contains(p_O)) continue;
      const Eigen::Vector3d foot = nearestOnTriangle(p_O, face->a, face->b, face->c);
      if ((p_O - foot).norm() <= kContact) return true;
    }
    const Eigen::Vector3d p_L = X_LO_ * p_O;
    return std::any_of(link_.shells().begin(), link_.shells().end(),
                       [&](const Shell& shell) { return shell.contains(p_L); });
  }

 private:
  struct Face {
    Eigen::Vector3d a, b, c;
    Eigen::AlignedBox3d reach;
  };

  static Eigen::AlignedBox3d grown(const Eigen::AlignedBox3d& box) {
    return {box.min().array() - kContact, box.max().array() + kContact};
  }

  Pose X_LO_;
  const Body& link_;
  std::vector<Face> faces_;
  std::vector<const Face*> near_;
  Eigen::AlignedBox3d box_;
};

/// Samples the part of the facet that is in the box, until `take` has enough.
template <typename Take>
void sampleFacet(const Facet& facet, const Eigen::AlignedBox3d& box, Take take) {
  if (!boxOf(facet.a, facet.b, facet.c).intersects(box)) return;
  const Eigen::Vector3d ab = facet.b - facet.a, ac = facet.c - facet.a;
  const double longest = std::max({ab.norm(), ac.norm(), (ab - ac).norm()});
  // A large facet is divided, and only what meets the box is gone through.
  if (longest > kMostSteps * kSpacing) {
    const Eigen::Vector3d mab = (facet.a + facet.b) / 2, mac = (facet.a + facet.c) / 2,
                          mbc = (facet.b + facet.c) / 2;
    for (const auto& [a, b, c] : {std::array{facet.a, mab, mac}, std::array{mab, facet.b, mbc},
                                  std::array{mac, mbc, facet.c}, std::array{mab, mbc, mac}}) {
      Facet part = facet;
      part.a = a;
      part.b = b;
      part.c = c;
      sampleFacet(part, box, take);
    }
    return;
  }
  const int steps = std::max(1, static_cast<int>(std::ceil(longest / kSpacing)));
  for (int i = 0; i <= steps; ++i) {
    for (int j = 0; i + j <= steps; ++j) {
      if (take(Eigen::Vector3d(facet.a + ab * i / steps + ac * j / steps))) return;
    }
  }
}

/// Outward normals of O where the link touches it, each direction once.
std::vector<Eigen::Vector3d> normalsFelt(const Surface& surface, FeltLink& link) {
  std::vector<Eigen::Vector3d> normals;
  for (const Facet& facet : surface.facets()) {
    const Eigen::AlignedBox3d own = boxOf(facet.a, facet.b, facet.c);
    if (!own.intersects(link.reach())) continue;
    link.turnTo(own);
    sampleFacet(facet, link.reach(), [&](const Eigen::Vector3d& sample) {
      const Eigen::Vector3d point = facet.shell->onSurface(sample);
      const Eigen::Vector3d normal = facet.shell->normalAt(point, facet.normal);
      const bool known = std::any_of(normals.begin(), normals.end(),
                                     [&](const auto& n) { return n.dot(normal) > kSame; });
      if (known) return !facet.shell->round;
      if (!link.feels(point) || !surface.exposed(facet, point)) return false;
      normals.push_back(normal);
      return !facet.shell->round;  // a flat facet has no other normal
    });
  }
  return normals;
}

class GripCheck {
 public:
  GripCheck(const Motion& motion, Report& report)
      : motion_(motion),
        scene_(motion.scene()),
        report_(report),
        surface_(scene_.body(scene_.object_body).body) {}

  void run() {
    for (int k = 0; k < scene_.holderCount(); ++k) {
      if (scene_.planHolder(k).suction) {
        suction(k);
      } else {
        fingers(k);
      }
    }
  }

 private:
  void violation(int k, const std::string& what, std::vector<std::string> bodies) {
    report_.add({motion_.task().of[static_cast<std::size_t>(k)].grasp, motion_.holdBegins(k),
                 "grip", what, std::move(bodies)});
  }

  void fingers(int k) {
    const Holder& holder = scene_.holder(k);
    const double time = motion_.holdBegins(k);
    const Pose X_OW = motion_.objectBy(k, time).inverse();
    std::vector<Pose> X_WL;
    motion_.linksAt(holder.robot, time, X_WL);
    std::vector<std::vector<Eigen::Vector3d>> normals;
    std::vector<bool> finger;
    std::vector<std::string> names;
    for (const int b : holder.hand_bodies) {
      const SceneBody& body = scene_.body(b);
      FeltLink link(body.body, X_OW * X_WL[static_cast<std::size_t>(body.link)]);
      auto felt = normalsFelt(surface_, link);
      if (felt.empty()) continue;
      normals.push_back(std::move(felt));
      finger.push_back(std::find(holder.finger_links.begin(), holder.finger_links.end(),
                                 body.link) != holder.finger_links.end());
      names.push_back(body.name);
    }
    double widest = -1;
    for (std::size_t f = 0; f < normals.size(); ++f) {
      for (std::size_t g = 0; g < f; ++g) {
        if (!finger[f] && !finger[g]) continue;
        for (const Eigen::Vector3d& n : normals[f]) {
          for (const Eigen::Vector3d& m : normals[g]) {
            widest = std::max(widest, std::acos(std::clamp(n.dot(m), -1.0, 1.0)));
          }
        }
      }
    }
    if (widest > kSpread) return;
    violation(k,
              widest < 0 ? "no two links of the hand, one of them a finger's, are within 2 mm of "
                           "the object"
                         : "contact normals differ by at most " +
                               std::to_string(std::lround(widest * 180 / M_PI)) + " deg",
              names);
  }

  void suction(int k) {
    const Holder& holder = scene_.holder(k);
    const double time = motion_.holdBegins(k);
    const Pose X_OW = motion_.objectBy(k, time).inverse();
    std::vector<Pose> X_WL;
    motion_.linksAt(holder.robot, time, X_WL);
    const Eigen::Vector3d centre =
        X_OW * X_WL[static_cast<std::size_t>(holder.tool_link)].translation();
    const Eigen::Vector3d axis =
        (X_OW * X_WL[static_cast<std::size_t>(holder.hand_links.front())]).linear() *
        scene_.planHolder(k).axis;
    double nearest = std::numeric_limits<double>::infinity();
    double least_tilt = M_PI;
    for (const Facet& facet : surface_.facets()) {
      const Eigen::Vector3d foot =
          facet.shell->onSurface(nearestOnTriangle(centre, facet.a, facet.b, facet.c));
      const double distance = (centre - foot).norm();
      if (distance > nearest + kEdge || !surface_.exposed(facet, foot)) continue;
      const Eigen::Vector3d normal = facet.shell->normalAt(foot, facet.normal);
      const double tilt = std::acos(std::clamp(-normal.dot(axis), -1.0, 1.0));
      least_tilt = distance < nearest - kEdge ? tilt : std::min(tilt, least_tilt);
      nearest = std::min(nearest, distance);
    }
    const std::string cup = scene_.planHolder(k).robot + "/" + scene_.planHolder(k).cup_link;
    if (nearest > kContact) {
      violation(k, "the cup is " + text(nearest * 1e3) + " mm away from the object", {cup});
    } else if (least_tilt > kCupTilt) {
      violation(k,
                "the cup leans by " + text(least_tilt * 180 / M_PI) + " deg from the object's face",
                {cup});
    }
  }

  const Motion& motion_;
  const Scene& scene_;
  Report& report_;
  Surface surface_;
};

}  // namespace

void checkGrips(const Motion& motion, Report& report) { GripCheck(motion, report).run(); }

}  // namespace handover::verify
